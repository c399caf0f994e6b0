"""Sparse matrices of a whole body on its coordinates, their contractions with a basis, and its interface points.

Mesh, arc lengths and basis may carry a complex step in a parameter of the shape; real parts decide where the point lies.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from math import comb
from operator import add
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array, issparse

from preprocessing.elements.beams import LineElement
from preprocessing.elements.element import (
    BodyMatrix,
    Contribution,
    Coordinates,
    Element,
    ElementSpace,
    Matrix,
    Pair,
    weighted_sum,
)
from preprocessing.elements.section import Monomial, monomial, monomial_derivative
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.model import InterfacePoint

MATERIAL: dict[str, dict[str, int]] = {
    "mass": {"density": 1},
    "constant mass": {},
    "stiffness": {"youngs_modulus": 1},
    "stress": {"youngs_modulus": 1},
}
"""Quantities of the material, with their powers, that multiply each kind of contribution."""
DAMPING = {"mass": "damping_mass", "constant mass": "damping_mass", "stiffness": "damping_stiffness"}
"""Quantity by which each kind of contribution enters the damping D = a M + c K."""


@dataclass(frozen=True)
class Matrices:
    """Finite-element matrices on the n coordinates, theory section 1; M_ba is the transpose of M_ab."""

    coordinates: Coordinates
    components: int  # of the stress at a point
    m: tuple[csr_array, ...]  # (n, n), M_ab in the order of the pairs of the space
    stiffness: csr_array  # (n, n)
    damping: csr_array  # (n, n)
    stress: csr_array  # (n_stress * components, n), the components of one point after each other

    @property
    def mass(self) -> csr_array:
        """Mass matrix M, the sum of the M_aa."""
        return reduce(add, self.m[: self.coordinates.space.dimension])

    def changed(self, change: Callable[[csr_array], csr_array]) -> Matrices:
        """Matrices with `change` applied to each of them."""
        return Matrices(
            self.coordinates,
            self.components,
            tuple(change(matrix) for matrix in self.m),
            *(change(matrix) for matrix in (self.stiffness, self.damping, self.stress)),
        )

    def stepped(self, rates: Matrices, step: complex) -> Matrices:
        """Matrices a step along their derivatives."""
        mine, others = ((*each.m, each.stiffness, each.damping, each.stress) for each in (self, rates))
        *m, stiffness, damping, stress = (matrix + step * rate for matrix, rate in zip(mine, others, strict=True))
        return Matrices(self.coordinates, self.components, tuple(m), stiffness, damping, stress)


class Root(NamedTuple):
    """Rows F with weight F^T F = K: for shapes psi that hardly strain stiff elements, F psi keeps digits that K psi loses."""

    weight: complex
    rows: BodyMatrix  # (n_rows, n)


class MatrixPart(NamedTuple):
    """One summand of one of the matrices, for unit parameters."""

    factors: Monomial
    name: str | Pair  # stiffness, damping or stress, or the pair (a, b) of M_ab
    matrix: BodyMatrix
    root: Root | None = None  # of a stiffness, where it is known


@dataclass(frozen=True)
class Parts:
    """The matrices as polynomials of the parameters: each is the sum of its parts times their monomials."""

    parts: tuple[MatrixPart, ...]
    coordinates: Coordinates
    components: int  # of the stress at a point
    n_stress: int  # rows of the stress, points times components

    @property
    def constant_mass(self) -> Parts:
        """Parts of the M_ab that no parameter changes: concentrated masses."""
        return replace(self, parts=tuple(part for part in self.parts if not isinstance(part.name, str) and not part.factors))

    @property
    def none(self) -> Parts:
        """Matrices of zeros, without any part."""
        return replace(self, parts=())

    def at(self, values: Mapping[str, complex]) -> Matrices:
        """Matrices at one design."""
        return self._sum([(part, monomial(values, part.factors)) for part in self.parts])

    def derivative(self, values: Mapping[str, complex], parameter: str) -> Matrices:
        """Analytical derivative of the matrices by one parameter."""
        concerned = self._concerned.get(parameter, [])
        return self._sum([(part, monomial_derivative(values, part.factors, parameter)) for part in concerned])

    @cached_property
    def _concerned(self) -> dict[str, list[MatrixPart]]:
        """Parts whose monomials contain each parameter."""
        found: dict[str, list[MatrixPart]] = {}
        for part in self.parts:
            for parameter in dict(part.factors):
                found.setdefault(parameter, []).append(part)
        return found

    def _sum(self, weighted: list[tuple[MatrixPart, complex]]) -> Matrices:
        n, terms = self.coordinates.n, dict[str | Pair, list[tuple[complex, BodyMatrix]]]()
        for part, weight in weighted:
            if weight != 0:
                terms.setdefault(part.name, []).append((weight, part.matrix))

        def one(name: str | Pair) -> csr_array:
            return weighted_sum(terms.get(name, []), (self.n_stress if name == "stress" else n, n))

        masses = tuple(one(pair) for pair in self.coordinates.space.pairs)
        return Matrices(self.coordinates, self.components, masses, one("stiffness"), one("damping"), one("stress"))


def assemble(element: Element) -> Parts:
    """Parts of the matrices of all elements.

    What depends on geometry only stands in the contributions, what depends on the section in the monomials.

        M_ab = sum rho p(section) (...),   K = sum E p(section) (...),   D = a M + c K,   stress = sum E p(section) (...)

    with a polynomial p for every contribution of the element, and without rho where a mass is constant; see
    `preprocessing.elements.element.Contribution`.
    """
    found = tuple(part for each in element.contributions() for part in _parts_of(each, element.coordinates.space))
    n_stress = next((part.matrix.shape[0] for part in found if part.name == "stress"), 0)
    return Parts(found, element.coordinates, element.components, n_stress)


def _parts_of(each: Contribution, space: ElementSpace) -> Iterator[MatrixPart]:
    material = MATERIAL[each.kind]
    if isinstance(each.matrix, Mapping):
        for pair in space.pairs:
            yield from _summands(each, pair, each.matrix[pair], **material)
        whole = reduce(add, (each.matrix[axis, axis] for axis in range(space.dimension)))
    else:
        whole = each.matrix
        yield from _summands(each, each.kind, whole, **material)
    if each.kind in DAMPING:
        yield from _summands(each, "damping", whole, **{DAMPING[each.kind]: 1}, **material)


def _summands(each: Contribution, name: str | Pair, matrix: BodyMatrix, **powers: int) -> Iterator[MatrixPart]:
    """One part for every term of the polynomial of the section, times powers of other quantities of its patch."""
    for number, dimensions in each.terms:
        root = None if each.rows is None else Root(number, each.rows)
        yield MatrixPart(each.patch.monomial(**powers, **dimensions), name, matrix if number == 1 else number * matrix, root)


def energies(parts: Parts, values: Mapping[str, complex], name: str, psi: Matrix) -> Matrix:
    """Energy matrix Psi^T K Psi or Psi^T D Psi (`name` stiffness or damping), (n_f, n_f); sparse as Psi is.

    Thin beams are a million times stiffer along than across. In K u of a shape that bends, the stiff parts cancel and take six
    digits along; as the square of a strain they are what they are.
    """
    own = [part for part in parts.parts if part.name == name]
    nothing = csr_array((psi.shape[1],) * 2) if issparse(psi) else np.zeros((psi.shape[1],) * 2)
    return sum((monomial(values, part.factors) * energy(part, psi) for part in own), nothing)


def energy(part: MatrixPart, psi: Matrix) -> Matrix:
    """Contribution of one part to an energy matrix for unit parameters; Psi sparse or dense."""
    if part.root is None:
        return symmetric(psi.T @ (part.matrix @ psi))
    strain = part.root.rows @ psi
    return part.root.weight * (strain.T @ strain)


def symmetric(matrix: Matrix) -> Matrix:
    """Symmetric part of a matrix, without the round-off of products that makes it unsymmetric."""
    return (matrix + matrix.T) / 2


def antisymmetric(matrix: Matrix) -> Matrix:
    """Antisymmetric part of a matrix, without the round-off of products that makes it another one."""
    return (matrix - matrix.T) / 2


PARTS = {"symmetric": symmetric, "antisymmetric": antisymmetric, "whole": lambda matrix: matrix}
"""Parts of a product that are an invariant, by the words of `preprocessing.elements.element.Form`."""


NODE_DISTANCE = 1e-9
"""A point closer to a node than this part of the skin's length is on the node."""

POINT_LAG = 1e-6
"""Parts of the largest movement that a point may lag behind its node; round-off is far below."""


def interface_point(beams: LineElement, arc_lengths: np.ndarray, z: np.ndarray, arc_length: complex) -> InterfacePoint:
    """Interface point at one arc length.

    Inside an element the arc length s on the true curve is mapped linearly to the place r = (s - s_1) / (s_2 - s_1) on the
    straight element, where `position` and `rotation` are cubic and quadratic. At a node they are the node's coordinates.

    Parameters
    ----------
    arc_lengths : (n_nodes,)
        Arc length of every node from F along the true curve.
    z : (n, 1 + n_f)
        The basis [xi, Psi]; in space a rotation has three rows.

    Raises
    ------
    InputError
        The arc length is not on the skin; or it is that of a node, but does not move with it under a complex step: the polygon of
        elements has a kink there, and the point no derivative.
    """
    nodes, place = np.real(arc_lengths), np.real(arc_length)
    nearest = int(np.abs(nodes - place).argmin())
    if abs(nodes[nearest] - place) <= NODE_DISTANCE * (nodes[-1] - nodes[0]):
        _refuse_passing(arc_lengths, nearest, arc_length)
        return node_point(beams, z, nearest, arc_lengths[nearest])
    if not nodes[0] <= place <= nodes[-1]:
        raise InputError(f"arc length {place:g} is off the skin, which reaches from {nodes[0]:g} to {nodes[-1]:g}.")
    element = int(np.searchsorted(nodes, place)) - 1
    return _inside_element(beams, z, element, arc_lengths[element : element + 2], arc_length)


def _refuse_passing(arc_lengths: np.ndarray, node: int, arc_length: complex) -> None:
    """Refuse a place that is at the node now, but moves otherwise than the node does."""
    if abs(np.imag(arc_lengths[node] - arc_length)) > POINT_LAG * np.abs(np.imag([*arc_lengths, arc_length])).max():
        raise InputError(
            f"arc length {np.real(arc_length):g} is that of node {node}, but a parameter of the shape moves the node and not the "
            f"point: at the kink between two elements it has no derivative. Write node = {node} if it belongs to the node, or "
            "choose a place off the nodes."
        )


def node_point(beams: LineElement, z: np.ndarray, node: int, arc_length: complex = 0.0) -> InterfacePoint:
    """Interface point at a node; it cannot move along the elements, and of a frame its arc length is 0."""
    dimension = beams.nodes.shape[1]
    rows = z[beams.per_node * node : beams.per_node * (node + 1)]
    turned = rows[2] if dimension == 2 else rows[3:]
    return InterfacePoint(np.asarray(arc_length), np.array([arc_length, arc_length]), rows[None, :dimension], turned[None])


def _inside_element(beams: LineElement, z: np.ndarray, element: int, interval: np.ndarray, arc_length: complex) -> InterfacePoint:
    dofs, displacement, rotation = beams.functions(element)
    step = interval[1] - interval[0]
    ratio = (arc_length - interval[0]) / step
    local = z[dofs]
    return InterfacePoint(
        np.asarray(arc_length),
        np.array(interval),
        _about(displacement, ratio, step) @ local,
        _about(rotation, ratio, step) @ local,
    )


def _about(coefficients: np.ndarray, ratio: complex, step: complex) -> np.ndarray:
    """Coefficients of (s - s_0)^k of a polynomial given by its coefficients of r^j, r = ratio + (s - s_0) / step."""
    powers = range(len(coefficients))
    shift = np.array([[comb(j, k) * ratio ** (j - k) / step**k if j >= k else 0.0 for j in powers] for k in powers])
    return np.tensordot(shift, coefficients, axes=1)
