"""One body at one design as finite elements, and how it changes with the design: all that precedes the choice of its basis."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeVar

import numpy as np
from scipy.sparse import csr_array

from preprocessing.elements.beams import LineElement
from preprocessing.reduction.assembly import Matrices, Parts, assemble, interface_point, node_point
from preprocessing.reduction.basis import DesignRates
from preprocessing.reduction.chosen_basis import per_node, undeformed
from toolkit.reduced_model.model import InterfacePoint, StressPoints, place_parameter

STEP = 1e-30
"""Complex step through the construction of geometry and elements: far below round-off, so that only the first derivative is left."""


@dataclass(frozen=True, eq=False)
class Discretisation:
    """Finite elements of a body at one design, in the plane or in space; complex where a parameter made a complex step.

    Interface points lie at arc lengths along a chain of elements, or at nodes.
    """

    element: LineElement
    places: Mapping[str, complex] = field(default_factory=dict)  # interface point -> its arc length, of a chain
    arc_lengths: np.ndarray | None = None  # (n_nodes,) of a chain
    target: np.ndarray | None = None  # (n_nodes, 2)
    at_nodes: Mapping[str, int] = field(default_factory=dict)  # interface point -> its node, of a frame

    @cached_property
    def parts(self) -> Parts:
        """Parts of the matrices of all elements."""
        return assemble(self.element)

    @cached_property
    def changing_parts(self) -> Parts:
        """Parts of the matrices of those elements that a complex step changes; all others have no derivative."""
        return assemble(self.element.changing())

    @property
    def nodes(self) -> np.ndarray:
        """Undeformed positions, (n_nodes, d)."""
        return self.element.nodes

    @property
    def stress_points(self) -> StressPoints:
        """Stress points, one to each row of the stress operator."""
        return self.element.stress_points

    def interfaces(self, z: np.ndarray) -> dict[str, InterfacePoint]:
        """Interface points for Z = [xi, Psi] (n, 1 + n_f), by name."""
        if self.arc_lengths is None:
            return {name: node_point(self.element, z, node) for name, node in self.at_nodes.items()}
        return {name: interface_point(self.element, self.arc_lengths, z, place) for name, place in self.places.items()}

    def interface_rows(self) -> dict[str, np.ndarray]:
        """Rows (3 or 6, n) that give the displacement and rotation of every interface point from the nodal coordinates."""
        every = self.interfaces(np.eye(self.element.coordinates.nodal))
        return {name: np.vstack([point.position[0], point.rotation[0]]) for name, point in every.items()}

    def items(self, z: np.ndarray) -> dict[str, np.ndarray]:
        """Arrays of the reduced model, besides the invariants, that can depend on the design."""
        keys = ("arc_length", "position", "rotation")
        found = {f"interfaces.{name}.{key}": getattr(point, key) for name, point in self.interfaces(z).items() for key in keys}
        if self.target is not None:
            found |= {"shape.position": self.positions(z)[:, :2], "shape.target": self.target}
        return found

    def positions(self, z: np.ndarray) -> np.ndarray:
        """Rows of Z that give the nodes' positions, (n_nodes, d, 1 + n_f)."""
        return z.reshape(len(self.nodes), -1, z.shape[1])[:, : self.nodes.shape[1]]


@dataclass(frozen=True)
class DesignChange:
    """Derivatives by one parameter of all that precedes the choice of a basis."""

    matrices: Matrices
    rates: DesignRates  # what the basis is made of
    stepped: Discretisation  # with the complex step still in it


@dataclass(frozen=True)
class DesignSpace:
    """All designs of one body: its parameters, and how one design becomes finite elements."""

    values: Mapping[str, float]  # parameter -> nominal value
    quantities: Mapping[str, str]  # parameter -> what it is, for its unit
    in_monomials: frozenset[str]  # parameters by which the matrices are polynomials
    discretise: Callable[[Mapping[str, complex]], Discretisation]
    steps: Mapping[str, Discretisation] = field(default_factory=dict)  # complex steps that were made already

    def nominal(self) -> Discretisation:
        """Discretisation at the nominal design."""
        return self.discretise(self.values)

    def stepped(self, parameter: str) -> Discretisation:
        """Discretisation with a complex step in one parameter."""
        if parameter in self.steps:
            return self.steps[parameter]
        return self.discretise({**self.values, parameter: self.values[parameter] + 1j * STEP})

    def change(self, nominal: Discretisation, parameter: str) -> DesignChange:
        """Derivatives by one parameter: of the monomials by their powers, of the geometry by a complex step through its formulas."""
        if parameter in self.in_monomials:
            d_matrices = nominal.parts.derivative(self.values, parameter)
            return _change(d_matrices, np.zeros(per_node(nominal.nodes) * len(nominal.nodes)), {}, nominal)
        stepped = self.stepped(parameter)
        d_xi, d_rows = derivative_of(undeformed(stepped.nodes)), stepped.interface_rows()
        d_parts = replace(stepped.changing_parts, n_stress=nominal.parts.n_stress)
        d_matrices = d_parts.at(self.values).changed(lambda matrix: matrix.imag / STEP)
        return _change(d_matrices, d_xi, {name: derivative_of(rows) for name, rows in d_rows.items()}, stepped)


def _change(d_matrices: Matrices, d_xi: np.ndarray, d_rows: dict[str, np.ndarray], stepped: Discretisation) -> DesignChange:
    d_stiffness, d_mass = map(d_matrices.coordinates.of_nodes, (d_matrices.stiffness, d_matrices.mass))
    return DesignChange(d_matrices, DesignRates(d_stiffness, d_mass, d_xi, d_rows), stepped)


Stepped = TypeVar("Stepped", np.ndarray, csr_array)
"""Array or sparse matrix in which a complex step may be."""


def derivative_of(value: Stepped) -> Stepped:
    """Derivative from the imaginary part that a complex step left; zeros of what is real."""
    return np.imag(value) / STEP


def with_places(space: DesignSpace, followed: Collection[str] | None = None) -> DesignSpace:
    """Design space with a parameter for every interface point inside an element, or for those that are `followed`.

    At a node the polygon has a kink and no derivative.
    """
    if followed is not None and not followed:
        return space
    nominal = space.nominal()
    empty = np.zeros((per_node(nominal.nodes) * len(nominal.nodes), 1))
    inside = {name for name, p in nominal.interfaces(empty).items() if p.arc_length_range[0] < p.arc_length_range[1]}
    wanted = inside if followed is None else inside & set(followed)
    free = {place_parameter(name): (name, float(np.real(s))) for name, s in nominal.places.items() if name in wanted}

    def discretise(design: Mapping[str, complex]) -> Discretisation:
        found = space.discretise(design)
        moved = {name: found.places[name] + design[parameter] - s for parameter, (name, s) in free.items()}
        return replace(found, places={**found.places, **moved})

    return replace(
        space,
        values={**space.values, **{parameter: s for parameter, (_, s) in free.items()}},
        quantities={**space.quantities, **dict.fromkeys(free, "length")},
        discretise=discretise,
    )
