"""A part of a chain of elements with a frame of its own, which goes through both of its ends.

The first node of a part stays in its place in the frame, and the last one on the line through both: the chord. The elastic coordinates are
what this leaves of its nodal coordinates. With the matrix C that gives the nodal coordinates from these, and all sums over the elements of
the part,

    N = (sum N_e) C,   G = C^T (sum G_e) C,   H = C^T (sum H_e) C,   K = C^T (sum K_e) C,   stress operator = B C

and in space Q_ab as G. All axes and the origin are those of the whole undeformed body. A reduced part has the columns of C times those of
its Craig-Bampton shapes in the place of C.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import scipy

from toolkit.foundation.errors import InputError
from toolkit.reduced_model.cut.chain import Place, nodes_of_part
from toolkit.reduced_model.cut.craig_bampton import PartShapes
from toolkit.reduced_model.dependence import is_sparse, sparing

SHORT = 1e-3
"""Distance of the ends of a part in parts of its length, below which no chord leads from one to the other."""
WORTH = 10_000
"""Numbers of a matrix C that is worth the search for those that are not zero: it stands on both sides of many sums."""


@dataclass(frozen=True)
class Part(ABC):
    """Part of a chain: its elements from `first` up to, but without, `last`."""

    first: int
    last: int
    nodes: np.ndarray  # (n_nodes, d) of the part, undeformed
    recovery: np.ndarray  # (n, 1 + n_f) Z on the nodal coordinates of the part
    invariants: Any
    stress_rows: np.ndarray  # numbers of its stress points among those of the body

    per_node: ClassVar[int]
    """Coordinates of a node: displacements, then rotations."""
    ends: ClassVar[tuple[int, int]]
    """Elastic coordinates of the first and of the last node, where nothing is reduced."""

    @classmethod
    def kept(cls, count: int, nodes: Sequence[int]) -> np.ndarray:
        """Numbers of the elastic coordinates at both ends and at some nodes between, in order, of a part of `count` nodes."""
        first, last = cls.ends
        size = first + cls.per_node * (count - 2) + last
        inner = first + cls.per_node * (np.array(nodes, int)[:, None] - 1) + np.arange(cls.per_node)
        return np.unique(np.concatenate([np.arange(first), inner.ravel(), np.arange(size - last, size)]))

    @property
    def n_f(self) -> int:
        """Number of elastic coordinates."""
        return self.recovery.shape[1] - 1

    def at(self, place: Place) -> tuple[np.ndarray, np.ndarray]:
        """Shape functions Z_P (d, 1 + n_f) and T_P (1 + n_f,), in space (3, 1 + n_f), at a point of an element."""
        start, n, d = place.element - self.first, self.per_node, self.nodes.shape[1]
        local = self.recovery[n * start : n * (start + 2)]
        if place.ratio in (0.0, 1.0):
            rows = local[:n] if place.ratio == 0 else local[n:]
            return rows[:d], rows[d] if n == d + 1 else rows[d:]
        shape, turn = self.functions(self.nodes[start : start + 2], place.ratio)
        return shape @ local, turn @ local

    @abstractmethod
    def axes(self) -> np.ndarray:
        """Unit vectors along and across the chord, (d, d)."""

    @staticmethod
    @abstractmethod
    def functions(ends: np.ndarray, ratio: Any) -> tuple[np.ndarray, np.ndarray]:
        """Displacement (d, 2 per_node) and rotation of a point of a beam per coordinate of its ends."""

    @abstractmethod
    def picture(self, whole: Any) -> dict[str, Any]:
        """Fields of a reduced model that pictures of the part need, from the reduced model of the whole body."""


@dataclass(frozen=True)
class Sums:
    """Sums over some elements of a chain, on elastic coordinates that a matrix C (n, n_f) maps to the nodal ones."""

    own: slice  # elements
    nodes: np.ndarray  # (n_nodes, d)
    psi: np.ndarray  # C
    per_node: int

    @property
    def z(self) -> np.ndarray:
        """Matrix [[1, 0], [0, C]] with the undeformed shape as a coordinate of its own."""
        found = np.zeros((1 + len(self.psi), 1 + self.psi.shape[1]), self.psi.dtype)
        found[0, 0], found[1:, 1:] = 1, self.psi
        return found

    @property
    def where(self) -> np.ndarray:
        """Numbers of the nodal coordinates of every element, (n_elements, 2 per_node)."""
        return self.per_node * np.arange(len(self.nodes) - 1)[:, None] + np.arange(2 * self.per_node)

    @property
    def whole(self) -> np.ndarray:
        """Numbers of the undeformed shape, 0, and of the nodal coordinates of every element, (n_elements, 1 + 2 per_node)."""
        return np.column_stack([np.zeros(len(self.nodes) - 1, int), 1 + self.where])

    def reduced(self, shapes: PartShapes | None, stiffness: np.ndarray) -> Sums:
        """Sums on fewer coordinates, by the blocks of the stiffness at this design; on the same ones without shapes."""
        return self if shapes is None else replace(self, psi=self.psi @ shapes.columns(self.square(stiffness)))

    def moment(self, blocks: np.ndarray) -> np.ndarray:
        """Sum of blocks (n_e, 1 + 2 per_node, ..) on the undeformed shape and the elastic coordinates."""
        return _between(sparing(self.z, WORTH), blocks[self.own], self.whole)

    def square(self, blocks: np.ndarray) -> np.ndarray:
        """Sum of symmetric blocks (n_e, 2 per_node, ..) on the elastic coordinates, symmetric."""
        return symmetric(_between(sparing(self.psi, WORTH), blocks[self.own], self.where))

    def first_moment(self, blocks: np.ndarray) -> np.ndarray:
        """Sum of blocks (n_e, d, 1 + 2 per_node) on the undeformed shape and the elastic coordinates."""
        columns: np.ndarray = np.zeros((blocks.shape[1], 1 + len(self.psi)), blocks.dtype)
        for block, places in zip(blocks[self.own], self.whole, strict=True):
            columns[:, places] += block
        return columns @ self.z

    def stress(self, rows: np.ndarray, element: np.ndarray) -> np.ndarray:
        """Rows of the stress operator on the elastic coordinates, from rows (n_s, 2 per_node) on those of elements."""
        return np.einsum("sl,slf->sf", rows, self.psi[self.where[element]])

    @property
    def recovery(self) -> np.ndarray:
        """Matrix Z on the nodal coordinates: undeformed places, then C."""
        turns = np.zeros((len(self.nodes), self.per_node - self.nodes.shape[1]))
        return np.column_stack([np.column_stack([self.nodes, turns]).ravel(), self.psi])


def chord_of_part(nodes: np.ndarray, first: int, last: int) -> np.ndarray:
    """Unit vector (d,) from the first to the last of the nodes (n, d) of a part.

    Raises
    ------
    InputError
        No chord leads from one to the other.
    """
    chord, sides = nodes[-1] - nodes[0], np.real(np.diff(nodes, axis=0))
    length = np.sqrt(chord @ chord)
    if np.real(length) <= SHORT * np.sqrt((sides * sides).sum(axis=1)).sum():
        raise InputError(
            f"the part of a flexible body from node {first} to node {last} begins where it ends, so that its frame has no chord to "
            "turn with. Write other `frames`."
        )
    found: np.ndarray = chord / length
    return found


def part_nodes(elements: Any, first: int, last: int) -> np.ndarray:
    """Undeformed positions (n, d) of the nodes of a part."""
    found: np.ndarray = elements.nodes[nodes_of_part(elements.connectivity, first, last)]
    return found


def _between(shapes: Any, blocks: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Product C^T A C of shapes C (n, ..), sparse or dense; A (n, n) sums blocks (n_e, k, k) at places (n_e, k)."""
    where, size = (places[:, :, None], places[:, None, :]), (shapes.shape[0], shapes.shape[0])
    if is_sparse(shapes):
        row, column = (each.ravel() for each in np.broadcast_arrays(*where))
        found: np.ndarray = (shapes.T @ scipy.sparse.coo_array((blocks.ravel(), (row, column)), size).tocsr() @ shapes).toarray()
        return found
    placed = np.zeros(size, blocks.dtype)
    np.add.at(placed, where, blocks)
    return shapes.T @ placed @ shapes


def symmetric(matrix: np.ndarray) -> np.ndarray:
    """Symmetric part of a matrix that is symmetric but for round-off."""
    return (matrix + matrix.T) / 2
