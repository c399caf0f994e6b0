"""Pairs of nodes that share an element: the entries of all matrices of a mesh, each with its place found once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from preprocessing.elements.solids.elements import ElementBlock


@dataclass(frozen=True, eq=False)
class NodePairs:
    """Pairs of nodes in common elements, in the order of a sparse matrix by rows."""

    n_nodes: int
    starts: np.ndarray  # (n_nodes + 1,) of the rows
    columns: np.ndarray  # (n_pairs,)
    places: tuple[np.ndarray, ...]  # of each block, (n_e, n_local, n_local) numbers of the pairs of its elements

    def sums(self, places: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Sums (n_pairs, ...) of element values over the pairs; values (n_e, n_local, n_local, ...) belong to the places."""
        flat = values.reshape(places.size, -1)
        every = [np.bincount(places.ravel(), column, len(self.columns)) for column in flat.T]
        return np.stack(every, axis=-1).reshape(len(self.columns), *values.shape[3:])

    def matrix(self, values: np.ndarray) -> Any:
        """Sparse (n_nodes, n_nodes) of one value (n_pairs,) for each pair, or of blocks (n_pairs, d, d) between their components."""
        if values.ndim == 1:
            return sparse.csr_array((values, self.columns, self.starts), shape=(self.n_nodes,) * 2)
        n = self.n_nodes * values.shape[1]
        return sparse.bsr_array((values, self.columns, self.starts), shape=(n, n)).tocsr()


def node_pairs(blocks: Sequence[ElementBlock], n_nodes: int) -> NodePairs:
    """Pairs of nodes of all elements."""
    keys = [n_nodes * block.connectivity[:, :, None] + block.connectivity[:, None, :] for block in blocks]
    found, number = np.unique(np.concatenate([key.ravel() for key in keys]), return_inverse=True)
    starts = np.searchsorted(found, n_nodes * np.arange(n_nodes + 1))
    return NodePairs(n_nodes, starts.astype(np.int32), (found % n_nodes).astype(np.int32), tuple(_split(number, keys)))


def _split(number: np.ndarray, keys: Sequence[np.ndarray]) -> Iterator[np.ndarray]:
    ends = np.cumsum([key.size for key in keys])
    for key, end in zip(keys, ends, strict=True):
        yield number[end - key.size : end].astype(np.int32).reshape(key.shape)
