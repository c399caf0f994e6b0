"""Sparse matrices of a whole body on its coordinates, at one design and their derivatives by the parameters of its monomials."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from operator import add
from typing import Any, NamedTuple

from preprocessing.elements.blocks import weighted_sum
from preprocessing.elements.element import Contribution, Coordinates, Element
from preprocessing.elements.section import Monomial, monomial, monomial_derivative
from preprocessing.elements.space import Pair, Space

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
    m: tuple[Any, ...]  # sparse (n, n), M_ab in the order of the pairs of the space
    stiffness: Any  # sparse (n, n)
    damping: Any  # sparse (n, n)
    stress: Any  # sparse (n_stress * components, n), the components of one point after each other

    @property
    def mass(self) -> Any:
        """Mass matrix M, the sum of the M_aa."""
        return reduce(add, self.m[: self.coordinates.space.dimension])

    def changed(self, change: Any) -> Matrices:
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

    weight: float
    rows: Any  # (n_rows, n), blocks or sparse


class Part(NamedTuple):
    """One summand of one of the matrices, for unit parameters."""

    factors: Monomial
    name: str | Pair  # stiffness, damping or stress, or the pair (a, b) of M_ab
    matrix: Any  # blocks, or sparse
    root: Root | None = None  # of a stiffness, where it is known


@dataclass(frozen=True)
class Parts:
    """The matrices as polynomials of the parameters: each is the sum of its parts times their monomials."""

    parts: tuple[Part, ...]
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

    def at(self, values: Mapping[str, Any]) -> Matrices:
        """Matrices at one design."""
        return self._sum([(part, monomial(values, part.factors)) for part in self.parts])

    def derivative(self, values: Mapping[str, Any], parameter: str) -> Matrices:
        """Analytical derivative of the matrices by one parameter."""
        concerned = self._concerned.get(parameter, [])
        return self._sum([(part, monomial_derivative(values, part.factors, parameter)) for part in concerned])

    @cached_property
    def _concerned(self) -> dict[str, list[Part]]:
        """Parts whose monomials contain each parameter."""
        found: dict[str, list[Part]] = {}
        for part in self.parts:
            for parameter in dict(part.factors):
                found.setdefault(parameter, []).append(part)
        return found

    def _sum(self, weighted: list[tuple[Part, Any]]) -> Matrices:
        n, terms = self.coordinates.n, dict[str | Pair, list[tuple[Any, Any]]]()
        for part, weight in weighted:
            if weight != 0:
                terms.setdefault(part.name, []).append((weight, part.matrix))

        def one(name: str | Pair) -> Any:
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
    found: list[Part] = []
    n_stress = 0
    for each in element.contributions():
        found += _parts_of(each, element.coordinates.space)
        n_stress = each.matrix.shape[0] if each.kind == "stress" else n_stress
    return Parts(tuple(found), element.coordinates, element.components, n_stress)


def _parts_of(each: Contribution, space: Space) -> Iterator[Part]:
    material = MATERIAL[each.kind]
    if each.kind in ("mass", "constant mass"):
        for pair in space.pairs:
            yield from _summands(each, pair, each.matrix[pair], **material)
        whole = reduce(add, (each.matrix[axis, axis] for axis in range(space.dimension)))
    else:
        whole = each.matrix
        yield from _summands(each, each.kind, whole, **material)
    if each.kind in DAMPING:
        yield from _summands(each, "damping", whole, **{DAMPING[each.kind]: 1}, **material)


def _summands(each: Contribution, name: str | Pair, matrix: Any, **powers: int) -> Iterator[Part]:
    """One part for every term of the polynomial of the section, times powers of other quantities of its patch."""
    for number, dimensions in each.terms:
        root = None if each.rows is None else Root(number, each.rows)
        yield Part(each.patch.monomial(**powers, **dimensions), name, matrix if number == 1 else number * matrix, root)
