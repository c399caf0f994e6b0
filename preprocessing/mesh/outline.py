"""The boundary of a plane mesh: its edges, one after the other along every closed line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

CORNERS = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 4}


@dataclass(frozen=True, eq=False)
class BoundaryLines:
    """Edges of the boundary, line by line; the body is to the left of every edge where its elements count anticlockwise."""

    nodes: np.ndarray  # (n_nodes, 2) of the whole mesh
    edges: np.ndarray  # (n_edges, 3) first, last and middle node; -1 for none in the middle

    @property
    def tangents(self) -> np.ndarray:
        """Unit vectors along the chords, (n_edges, 2)."""
        chords = self.nodes[self.edges[:, 1]] - self.nodes[self.edges[:, 0]]
        return chords / np.linalg.norm(chords, axis=1, keepdims=True)

    @property
    def points(self) -> np.ndarray:
        """Numbers of the nodes of the boundary, in order."""
        return np.unique(self.edges[self.edges >= 0])

    def between(self, nodes: np.ndarray) -> BoundaryLines:
        """Edges all of whose nodes are among the given ones."""
        inside = np.append(np.isin(np.arange(len(self.nodes)), nodes), True)  # the last one stands for no node in the middle
        return BoundaryLines(self.nodes, self.edges[inside[self.edges].all(axis=1)])

    def products(self) -> Any:
        """Integrals int N_k N_l ds for nodes k and l, by Simpson's rule or half of a straight edge; sparse (n_nodes, n_nodes)."""
        length = np.sqrt(((self.nodes[self.edges[:, 1]] - self.nodes[self.edges[:, 0]]) ** 2).sum(axis=1))
        straight = self.edges[:, 2] < 0
        ends, middle = np.where(straight, 1 / 2, 1 / 6) * length, np.where(straight, 0, 4 / 6) * length
        found = np.zeros(len(self.nodes) + 1, self.nodes.dtype)  # the last one stands for no node
        np.add.at(found, self.edges, np.column_stack([ends, ends, middle]))
        return sparse.diags_array(found[:-1], format="csr")


def outline_of(nodes: np.ndarray, blocks: Mapping[str, np.ndarray]) -> BoundaryLines:
    """Edges that belong to one element only.

    Parameters
    ----------
    blocks : kind of element -> (n_e, nodes of one element), corners first, then the middles of the edges
    """
    every = np.concatenate([edges_of(kind, block) for kind, block in blocks.items()])
    key = np.sort(every[:, :2], axis=1)
    _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    return BoundaryLines(nodes, _in_lines(every[np.sort(first[count == 1])]))


def edges_of(kind: str, block: np.ndarray) -> np.ndarray:
    """Edges of all elements, (n_e n_corners, 3)."""
    corners = CORNERS[kind]
    first = block[:, :corners]
    last = np.roll(first, -1, axis=1)
    middle = block[:, corners : 2 * corners] if block.shape[1] >= 2 * corners else np.full_like(first, -1)
    return np.stack([first, last, middle], axis=2).reshape(-1, 3)


def _in_lines(edges: np.ndarray) -> np.ndarray:
    """The edges in the order in which they follow one another, the smallest number of a node first in every line."""
    at: dict[int, list[int]] = {}
    for k, (first, last, _) in enumerate(edges.tolist()):
        at.setdefault(first, []).append(k)
        at.setdefault(last, []).append(k)
    left, found = np.ones(len(edges), bool), []
    for start in np.argsort(edges[:, :2].min(axis=1), kind="stable").tolist():
        k = start
        while left[k]:
            left[k] = False
            found.append(k)
            ends = edges[k, [1, 0]].tolist()  # onward from the last node, if anything is left there
            k = next((other for end in ends for other in at[end] if left[other]), k)
    return edges[found]
