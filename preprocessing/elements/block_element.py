"""Elements whose matrices are made as dense blocks of all elements at once, and placed in the sparse matrices of the body."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np
from scipy import sparse

from preprocessing.elements.element import Coordinates, Element
from preprocessing.elements.space import Pair, Space
from toolkit.reduced_model.model import StressPoints


@dataclass(frozen=True, eq=False)
class BlockElement(Element):
    """Elements with small blocks; a kind states its space, the coordinates of a node, and its contributions."""

    nodes: np.ndarray  # (n_nodes, d)
    connectivity: np.ndarray  # (n_e, nodes of one element)

    space: ClassVar[Space]
    per_node: ClassVar[int]
    hidden: ClassVar[int] = 0

    @property
    def coordinates(self) -> Coordinates:
        return Coordinates(self.space, len(self.nodes), self.per_node, self.hidden)

    @property
    def ends(self) -> np.ndarray:
        """Positions of the nodes of every element, (n_e, nodes of one element, d)."""
        return self.nodes[self.connectivity]

    @property
    def dofs(self) -> np.ndarray:
        """Numbers of the coordinates of every element, the hidden ones last, (n_e, n_local)."""
        own = (self.per_node * self.connectivity[:, :, None] + np.arange(self.per_node)).reshape(len(self.connectivity), -1)
        hidden = self.coordinates.nodal + np.arange(self.hidden)
        return np.column_stack([own, np.broadcast_to(hidden, (len(own), self.hidden))])

    def component_masses(self, elements: np.ndarray, blocks: np.ndarray) -> dict[Pair, Any]:
        """Sparse M_ab from the blocks (n_e, d, d, p, p) of some elements on their first p coordinates."""
        dofs, n = self.dofs[elements, : blocks.shape[-1]], self.coordinates.n
        rows, columns = (each.ravel() for each in np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :]))
        return {
            (a, b): sparse.coo_array((blocks[:, a, b].ravel(), (rows, columns)), shape=(n, n)).tocsr()
            for a, b in self.space.pairs
        }

    def placed_rows(self, elements: np.ndarray, blocks: np.ndarray, numbers: np.ndarray | None = None, n_rows: int = 0) -> Any:
        """Rows (n_e, k, p) of some elements as a sparse matrix: one after the other, or at the numbers (n_e, k) of `n_rows`."""
        if numbers is None:
            numbers, n_rows = (
                np.arange(blocks.shape[0] * blocks.shape[1]).reshape(blocks.shape[:2]),
                blocks.shape[0] * blocks.shape[1],
            )
        rows, columns = np.broadcast_arrays(numbers[:, :, None], self.dofs[elements, None, : blocks.shape[2]])
        return sparse.coo_array((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(n_rows, self.coordinates.n)).tocsr()


@dataclass(frozen=True, eq=False)
class LineElement(BlockElement):
    """Straight elements between two nodes, on which interface points lie.

    The nodes turn too: their coordinates are x, y and a rotation, in space the displacements along and the rotations about x, y and z.
    """

    def apart(self) -> Self:
        """The same elements, no two of which share a coordinate: the nodes of the first element, then those of the second, and so on."""
        nodes = self.ends.reshape(-1, self.nodes.shape[1])
        return replace(self, nodes=nodes, connectivity=np.arange(len(nodes)).reshape(-1, 2))

    @property
    @abstractmethod
    def stress_points(self) -> StressPoints:
        """Where the rows of the stress are."""

    @abstractmethod
    def functions(self, element: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Numbers of one element's nodal coordinates (p,), and coefficients of r^k in displacement (4, d, p) and rotation.

        The rotation is (4, p) in the plane and (4, 3, p) in space.
        """
