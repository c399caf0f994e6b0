"""A large sparse matrix with a border of one row and one column, by factors of the matrix alone."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

TRUSTED = 1e-10
"""Refinement of a solution, in parts of it, up to which it is believed: near a limit point the matrix alone is singular."""


def sparse_bordered_solve(full: np.ndarray, rhs: np.ndarray) -> np.ndarray | None:
    """Solution of [A, f; b^T, c] x = rhs (n + 1,), refined once; None where A alone is too near to singular."""
    n = len(full) - 1
    matrix, column, row, corner = csc_array(full[:n, :n]), full[:n, n], full[n, :n], full[n, n]
    try:
        factors = splu(matrix)
    except RuntimeError:  # exactly singular
        return None
    along = factors.solve(column)
    rest = corner - row @ along

    def solved(wanted: np.ndarray) -> np.ndarray:
        inside = factors.solve(wanted[:n])
        last = (wanted[n] - row @ inside) / rest
        return np.append(inside - last * along, last)

    with np.errstate(all="ignore"):
        found = solved(rhs)
        left = rhs - np.append(matrix @ found[:n] + column * found[n], row @ found[:n] + corner * found[n])
        change = solved(left)
    good = np.all(np.isfinite(change)) and np.abs(change).max() <= TRUSTED * np.abs(found).max()
    return found + change if good else None


def sparse_solve(matrix: np.ndarray, rhs: np.ndarray) -> np.ndarray | None:
    """The same with factors of the whole matrix, which takes longer; None where it is singular."""
    try:
        found: np.ndarray = splu(csc_array(matrix)).solve(rhs)
    except RuntimeError:
        return None
    return found
