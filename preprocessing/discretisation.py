"""One body at one design as finite elements, and how it changes with the design: all that precedes the choice of a basis."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from preprocessing.assembly import Matrices, Parts
from preprocessing.basis import DesignRates
from preprocessing.interface import interface_point
from preprocessing.mesh import CurveMesh
from preprocessing.reduction import undeformed
from toolkit.reduced_model import InterfacePoint

STEP = 1e-30
"""Complex step through the construction of geometry and elements: far below round-off, so that only the first derivative is left."""


@dataclass(frozen=True)
class Discretisation:
    """Finite elements of a body; complex where a parameter made a complex step."""

    mesh: CurveMesh
    arc_lengths: np.ndarray  # (n_nodes,)
    parts: Parts
    places: Mapping[str, Any]  # interface point -> its arc length
    target: np.ndarray | None  # (n_nodes, 2)

    def interfaces(self, z: np.ndarray) -> dict[str, InterfacePoint]:
        """The interface points for Z = [xi, Psi] (n, 1 + n_f)."""
        return {name: interface_point(self.mesh, self.arc_lengths, z, place) for name, place in self.places.items()}

    def interface_rows(self) -> dict[str, np.ndarray]:
        """Interface point -> rows (3, n) that give its displacement x, y and its rotation from the nodal coordinates."""
        every = self.interfaces(np.eye(3 * len(self.mesh.nodes)))
        return {name: np.vstack([point.position[0], point.rotation[:1]]) for name, point in every.items()}

    def items(self, z: np.ndarray) -> dict[str, np.ndarray]:
        """Arrays of the reduced model, besides the invariants, that can depend on the design."""
        found = {
            f"interfaces.{name}.{key}": getattr(point, key)
            for name, point in self.interfaces(z).items()
            for key in ("arc_length", "position", "rotation")
        }
        if self.target is not None:
            found |= {"shape.position": positions(z), "shape.target": self.target}
        return found


@dataclass(frozen=True)
class Change:
    """Derivatives by one parameter of what precedes the basis."""

    matrices: Matrices
    rates: DesignRates  # what the basis is made of
    stepped: Discretisation  # with the complex step still in it


@dataclass(frozen=True)
class DesignSpace:
    """All designs of one body: its parameters, and how one design becomes finite elements."""

    values: Mapping[str, float]  # parameter -> nominal value
    quantities: Mapping[str, str]  # parameter -> what it is, for its unit
    in_monomials: frozenset[str]  # parameters by which the matrices are polynomials
    discretise: Callable[[Mapping[str, Any]], Discretisation]
    steps: Mapping[str, Discretisation] = field(default_factory=dict)  # complex steps that were made already

    def nominal(self) -> Discretisation:
        """At the nominal design."""
        return self.discretise(self.values)

    def stepped(self, parameter: str) -> Discretisation:
        """With a complex step in one parameter."""
        if parameter in self.steps:
            return self.steps[parameter]
        return self.discretise({**self.values, parameter: self.values[parameter] + 1j * STEP})

    def change(self, nominal: Discretisation, parameter: str) -> Change:
        """Derivatives by one parameter: of the monomials by their powers, of the geometry by a complex step through its formulas."""
        if parameter in self.in_monomials:
            d_matrices = nominal.parts.derivative(self.values, parameter)
            return _change(d_matrices, np.zeros(3 * len(nominal.mesh.nodes)), {}, nominal)
        stepped = self.stepped(parameter)
        d_xi, d_rows = derivative_of(undeformed(stepped.mesh.nodes)), stepped.interface_rows()
        d_matrices = imaginary(stepped.parts.at(self.values))
        return _change(d_matrices, d_xi, {name: derivative_of(rows) for name, rows in d_rows.items()}, stepped)


def _change(d_matrices: Matrices, d_xi: np.ndarray, d_rows: dict[str, np.ndarray], stepped: Discretisation) -> Change:
    return Change(d_matrices, DesignRates(d_matrices.stiffness, d_matrices.mass, d_xi, d_rows), stepped)


def positions(z: np.ndarray) -> np.ndarray:
    """The rows of Z that give the nodes' positions, (n_nodes, 2, 1 + n_f)."""
    return z.reshape(-1, 3, z.shape[1])[:, :2]


def derivative_of(value: Any) -> Any:
    """What a complex step left."""
    return np.imag(value) / STEP


def imaginary(matrices: Matrices) -> Matrices:
    """Derivatives of matrices by the parameter that made a complex step."""
    return Matrices(**{name: value.imag / STEP for name, value in vars(matrices).items()})
