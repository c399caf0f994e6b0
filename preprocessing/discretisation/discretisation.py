"""One body at one design as finite elements, and how it changes with the design: all that precedes the choice of a basis."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from preprocessing.assembly.assembly import Parts
from preprocessing.assembly.energies import energies
from preprocessing.assembly.interface import interface_point
from preprocessing.assembly.invariants import contract, contract_derivative, polynomials
from preprocessing.basis.basis import DesignRates
from preprocessing.basis.reduction import per_node, undeformed
from preprocessing.elements.stress import stress_points
from preprocessing.mesh.curve_mesh import CurveMesh
from toolkit.reduced_model.dependence import Polynomial
from toolkit.reduced_model.model import InterfacePoint, StressPoints

STEP = 1e-30
"""Complex step through the construction of geometry and elements: far below round-off, so that only the first derivative is left."""


class FiniteElements(Protocol):
    """Finite elements of a body at one design, in the plane or in space; complex where a parameter made a complex step."""

    @property
    def parts(self) -> Parts:
        """The matrices."""

    @property
    def nodes(self) -> np.ndarray:
        """Undeformed positions, (n_nodes, d)."""

    @property
    def places(self) -> Mapping[str, Any]:
        """Interface point -> its arc length."""

    @property
    def stress_points(self) -> StressPoints:
        """Where the rows of the stress are."""

    def interfaces(self, z: np.ndarray) -> dict[str, InterfacePoint]:
        """The interface points for Z = [xi, Psi] (n, 1 + n_f)."""

    def interface_rows(self) -> dict[str, np.ndarray]:
        """Interface point -> rows (3 or 6, n) that give its displacement and its rotation from the nodal coordinates."""

    def items(self, z: np.ndarray) -> dict[str, np.ndarray]:
        """Arrays of the reduced model, besides the invariants, that can depend on the design."""

    def nodal(self, matrix: Any) -> Any:
        """The block of a square matrix that belongs to the nodal coordinates."""

    def contract(self, values: Mapping[str, Any], z: np.ndarray) -> Any:
        """Invariants at values of the parameters for Z = [xi, Psi]."""

    def contract_derivative(self, matrices: Any, d_matrices: Any, z: np.ndarray, d_z: np.ndarray) -> Any:
        """Their derivative from those of the matrices and of Z."""

    def polynomials(self, parameters: Sequence[str], z: np.ndarray, computed: bool) -> dict[str, Polynomial]:
        """Their exact dependence on the parameters for a constant Z, of a full basis or of shapes that were `computed`."""


@dataclass(frozen=True)
class Discretisation:
    """Finite elements of a planar body along a curve."""

    mesh: CurveMesh
    arc_lengths: np.ndarray  # (n_nodes,)
    parts: Parts
    places: Mapping[str, Any]  # interface point -> its arc length
    target: np.ndarray | None  # (n_nodes, 2)

    @property
    def nodes(self) -> np.ndarray:
        """Undeformed positions, (n_nodes, 2)."""
        return self.mesh.nodes

    @property
    def stress_points(self) -> StressPoints:
        """Where the rows of the stress are."""
        return stress_points(len(self.mesh.connectivity))

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

    def nodal(self, matrix: Any) -> Any:
        """All of a matrix."""
        return matrix

    def contract(self, values: Mapping[str, Any], z: np.ndarray) -> Any:
        """Invariants at values of the parameters for Z = [xi, Psi]."""
        own = {name: energies(self.parts, values, name, z[:, 1:]) for name in ("stiffness", "damping")}
        return replace(contract(self.parts.at(values), z), **own)

    def contract_derivative(self, matrices: Any, d_matrices: Any, z: np.ndarray, d_z: np.ndarray) -> Any:
        """Their derivative from those of the matrices and of Z."""
        return contract_derivative(matrices, d_matrices, z, d_z)

    def polynomials(self, parameters: Sequence[str], z: np.ndarray, computed: bool) -> dict[str, Polynomial]:
        """Their exact dependence on the parameters for a constant Z."""
        return polynomials(self.parts, parameters, z, computed=computed)


@dataclass(frozen=True)
class Change:
    """Derivatives by one parameter of what precedes the basis."""

    matrices: Any
    rates: DesignRates  # what the basis is made of
    stepped: FiniteElements  # with the complex step still in it


@dataclass(frozen=True)
class DesignSpace:
    """All designs of one body: its parameters, and how one design becomes finite elements."""

    values: Mapping[str, float]  # parameter -> nominal value
    quantities: Mapping[str, str]  # parameter -> what it is, for its unit
    in_monomials: frozenset[str]  # parameters by which the matrices are polynomials
    discretise: Callable[[Mapping[str, Any]], FiniteElements]
    steps: Mapping[str, FiniteElements] = field(default_factory=dict)  # complex steps that were made already

    def nominal(self) -> FiniteElements:
        """At the nominal design."""
        return self.discretise(self.values)

    def stepped(self, parameter: str) -> FiniteElements:
        """With a complex step in one parameter."""
        if parameter in self.steps:
            return self.steps[parameter]
        return self.discretise({**self.values, parameter: self.values[parameter] + 1j * STEP})

    def change(self, nominal: FiniteElements, parameter: str) -> Change:
        """Derivatives by one parameter: of the monomials by their powers, of the geometry by a complex step through its formulas."""
        if parameter in self.in_monomials:
            d_matrices = nominal.parts.derivative(self.values, parameter)
            return _change(d_matrices, np.zeros(per_node(nominal.nodes) * len(nominal.nodes)), {}, nominal)
        stepped = self.stepped(parameter)
        d_xi, d_rows = derivative_of(undeformed(stepped.nodes)), stepped.interface_rows()
        d_matrices = imaginary(stepped.parts.at(self.values))
        return _change(d_matrices, d_xi, {name: derivative_of(rows) for name, rows in d_rows.items()}, stepped)


def _change(d_matrices: Any, d_xi: np.ndarray, d_rows: dict[str, np.ndarray], stepped: FiniteElements) -> Change:
    d_stiffness, d_mass = (stepped.nodal(matrix) for matrix in (d_matrices.stiffness, d_matrices.mass))
    return Change(d_matrices, DesignRates(d_stiffness, d_mass, d_xi, d_rows), stepped)


def positions(z: np.ndarray) -> np.ndarray:
    """The rows of Z that give the nodes' positions, (n_nodes, 2, 1 + n_f)."""
    return z.reshape(-1, 3, z.shape[1])[:, :2]


def derivative_of(value: Any) -> Any:
    """What a complex step left."""
    return np.imag(value) / STEP


def imaginary(matrices: Any) -> Any:
    """Derivatives of matrices, planar or spatial, by the parameter that made a complex step."""
    return replace(matrices, **{name: _imaginary(value) for name, value in vars(matrices).items()})


def _imaginary(value: Any) -> Any:
    if isinstance(value, int):
        return value
    return tuple(each.imag / STEP for each in value) if isinstance(value, tuple) else value.imag / STEP
