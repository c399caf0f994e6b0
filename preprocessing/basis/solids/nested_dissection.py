"""An order of elimination for large sparse matrices of spatial meshes: halves of the body first, what separates them last.

A. George: Nested dissection of a regular finite element mesh, SIAM Journal on Numerical Analysis 10 (1973), by the places of nodes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse

LEAF = 120
"""Coordinates of parts that are not halved any more."""


def dissected(matrix: Any, places: np.ndarray) -> np.ndarray:
    """Numbers (n,) of the coordinates in the order of elimination.

    Parameters
    ----------
    matrix : sparse (n, n), of which the pattern counts
    places : (n, d), where the node of every coordinate is
    """
    pattern = sparse.csr_array(matrix)
    graph = sparse.csr_array((np.ones(pattern.nnz, np.int8), pattern.indices, pattern.indptr), shape=pattern.shape)
    return _ordered(graph, places, np.arange(len(places)))


def _ordered(graph: Any, places: np.ndarray, members: np.ndarray) -> np.ndarray:
    """The members in order; graph and places are theirs."""
    if len(members) <= LEAF:
        return members
    axis = np.argmax(np.ptp(places, axis=0))
    left = places[:, axis] < np.median(places[:, axis])
    if not left.any():
        return members
    on_left, on_right = (side & (graph @ ~side > 0) for side in (left, ~left))
    border = on_left if on_left.sum() <= on_right.sum() else on_right
    inner = [np.flatnonzero(side & ~border) for side in (left, ~left)]
    return np.concatenate([*(_ordered(graph[each][:, each], places[each], members[each]) for each in inner), members[border]])
