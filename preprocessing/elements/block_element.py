"""Elements whose matrices are made as dense blocks of all elements at once."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np

from preprocessing.elements.blocks import Blocks, Places, weighted_sum
from preprocessing.elements.element import Coordinates, Element
from preprocessing.elements.section import Patch, SectionTerm, monomial
from preprocessing.elements.section_shape import Terms
from preprocessing.elements.space import Pair, Space
from toolkit.reduced_model.model import StressPoints


@dataclass(frozen=True, eq=False)
class BlockElement(Element):
    """Elements with small blocks; a kind states its space, the coordinates of a node, and its contributions."""

    nodes: np.ndarray  # (n_nodes, d)
    connectivity: np.ndarray  # (n_e, nodes of one element)

    space: ClassVar[Space]
    per_node: ClassVar[int]

    @property
    def hidden(self) -> int:
        """Number of hidden coordinates, see `elements.element.Coordinates`."""
        return 0

    @property
    def coordinates(self) -> Coordinates:
        return Coordinates(self.space, len(self.nodes), self.per_node, self.hidden)

    @cached_property
    def ends(self) -> np.ndarray:
        """Positions of the nodes of every element, (n_e, nodes of one element, d)."""
        return self.nodes[self.connectivity]

    @cached_property
    def dofs(self) -> np.ndarray:
        """Numbers of the coordinates of every element, the hidden ones last, (n_e, n_local)."""
        own = (self.per_node * self.connectivity[:, :, None] + np.arange(self.per_node)).reshape(len(self.connectivity), -1)
        hidden = self.coordinates.nodal + np.arange(self.hidden)
        return np.column_stack([own, np.broadcast_to(hidden, (len(own), self.hidden))])

    def component_masses(self, elements: np.ndarray, blocks: np.ndarray) -> dict[Pair, Blocks]:
        """Component masses M_ab from the blocks (n_e, d, d, p, p) of some elements on their first p coordinates."""
        dofs, n = self.dofs[elements, : blocks.shape[-1]], self.coordinates.n
        places = Places(elements, dofs, dofs, (n, n))
        return {(a, b): Blocks(places, blocks[:, a, b]) for a, b in self.space.pairs}

    def placed_rows(self, elements: np.ndarray, blocks: np.ndarray, numbers: np.ndarray | None = None, n_rows: int = 0) -> Blocks:
        """Rows (n_e, k, p) of some elements: one after the other, or at the numbers (n_e, k) of `n_rows`."""
        if numbers is None:
            n_rows = blocks.shape[0] * blocks.shape[1]
            numbers = np.arange(n_rows).reshape(blocks.shape[:2])
        return Blocks(Places(elements, numbers, self.dofs[elements, : blocks.shape[2]], (n_rows, self.coordinates.n)), blocks)


def section_terms(
    name: str, patch: Patch, rows: np.ndarray, terms: Terms, factor: Any = 1.0, column: int = 0, **material: int
) -> Iterator[SectionTerm]:
    """Section terms of a polynomial, times a factor and powers of quantities of the material."""
    for number, powers in terms:
        yield SectionTerm(name, rows, column, patch.monomial(**material, **powers), factor * number)


class Tension(NamedTuple):
    """Stiffening of elements by tension: E p(section) times their strain times the squares of their slopes."""

    patch: Patch
    elements: np.ndarray  # (n_e,) their numbers
    terms: Terms  # of the polynomial p
    strain: np.ndarray  # (n_e, p) rows of the strain along the element
    slopes: np.ndarray  # (n_e, k, p) rows F whose squares sum up to the integral of the squares of the slopes


@dataclass(frozen=True, eq=False)
class LineElement(BlockElement):
    """Straight elements between two nodes, on which interface points lie.

    The nodes turn too: their coordinates are x, y and a rotation, in space the displacements along and the rotations about x, y and z.
    """

    wanted: np.ndarray | None = field(default=None, kw_only=True)
    """Numbers of the elements that contribute; None: all of them."""

    @property
    def contributing(self) -> np.ndarray:
        """Numbers of the elements that contribute, listed also where these are all."""
        return np.arange(len(self.connectivity)) if self.wanted is None else self.wanted

    def of_patch(self, patch: Patch) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of a patch's elements that contribute, and their places among all that do."""
        if self.wanted is None:
            return patch.elements, patch.elements
        here = np.flatnonzero(np.isin(self.wanted, patch.elements))
        return self.wanted[here], here

    @property
    def stepped(self) -> np.ndarray:
        """Which elements have a node that a complex step moves, (n_e,) truth values."""
        return np.any(np.imag(self.ends) != 0, axis=(1, 2))

    def tensions(self) -> Iterator[Tension]:
        """Stiffening of the elements by tension; a kind without this method has no geometric stiffness."""
        yield from ()

    def section_terms(self) -> Iterator[SectionTerm]:
        """Terms of the sections of all elements; none of a kind that consists of no beams."""
        yield from ()

    @property
    def section_axes(self) -> np.ndarray:
        """Axes e_3 of all sections before they are made normal to their elements, (n_e, 3); z in the plane."""
        return np.tile([0.0, 0.0, 1.0], (len(self.connectivity), 1))

    def geometric_stiffness(self, values: Mapping[str, Any], displacement: np.ndarray) -> Any:
        n, found = self.coordinates.n, list[tuple[Any, Blocks]]()
        for patch, elements, terms, strain, slopes in self.tensions():
            dofs = self.dofs[elements, : strain.shape[1]]
            stretched = np.einsum("ep,ep->e", strain, displacement[dofs])
            blocks = Blocks(
                Places(elements, dofs, dofs, (n, n)), np.einsum("e,ekp,ekq->epq", stretched, slopes, slopes, optimize=True)
            )
            found += [(number * monomial(values, patch.monomial(youngs_modulus=1, **powers)), blocks) for number, powers in terms]
        return weighted_sum(found, (n, n)) if found else super().geometric_stiffness(values, displacement)

    def changing(self) -> Self:
        """Elements of which only those contribute that a complex step changes; leaving all in is right, but slow."""
        return self

    @property
    @abstractmethod
    def stress_points(self) -> StressPoints:
        """Stress points, one to each row of the stress operator."""

    @abstractmethod
    def functions(self, element: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Numbers of one element's nodal coordinates (p,), and coefficients of r^k in displacement (4, d, p) and rotation.

        The rotation is (4, p) in the plane and (4, 3, p) in space.
        """
