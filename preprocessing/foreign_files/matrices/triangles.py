"""Symmetric matrices of which a file holds one triangle."""

from __future__ import annotations

import numpy as np
from scipy import sparse

ROUND_OFF = 1e-9
"""Largest entry, relative to the largest of all, that may stand on one side of the diagonal alone where others stand on both."""


def both_triangles(
    row: np.ndarray, column: np.ndarray, value: np.ndarray, n: int, who: str = "it", one_only: bool = True
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows, columns and values of both triangles of a symmetric matrix (n, n), of which one triangle may be given, in any order of rows.

    Where no entry has its mirror image, the file holds one triangle, whichever; where each has, it holds both.

    Parameters
    ----------
    who : beginning of the sentence of an error
    one_only : whether both triangles are an error too

    Raises
    ------
    ValueError
        Some entries stand on both sides of the diagonal and some on one, so that it is not clear which are to be mirrored.
    """
    off = row != column
    if not np.any(off):
        return row, column, value
    entries = sparse.csr_array((np.ones(np.count_nonzero(off)), (row[off], column[off])), shape=(n, n))
    entries.data[:] = 1.0
    if entries.multiply(entries.T).nnz == 0:
        return np.concatenate([row, column[off]]), np.concatenate([column, row[off]]), np.concatenate([value, value[off]])
    if one_only:
        raise ValueError(f"{who} holds entries on both sides of the diagonal")
    _refuse_half(sparse.csr_array((value, (row, column)), shape=(n, n)), entries, who)
    return row, column, value


def _refuse_half(matrix: sparse.csr_array, entries: sparse.csr_array, who: str) -> None:
    """Refuse a matrix with both triangles, of which one lacks entries."""
    alone = entries - entries.multiply(entries.T)
    lacking = np.abs(matrix.multiply(alone).data) > ROUND_OFF * np.abs(matrix.data).max()
    if np.any(lacking):
        raise ValueError(
            f"{who} holds entries on both sides of the diagonal, but {np.count_nonzero(lacking)} of them on one side only; give one "
            "triangle, or both of them whole"
        )
