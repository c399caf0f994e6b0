"""Constraints that repeat others: which rows of the joints' Jacobian depend on the others in the undeformed configuration."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import qr

REPEATS, ALMOST = 1e-9, 1e-5
"""Part of a row, of length one, that is independent of the rows before it, below which it repeats them, and below which it nearly does:
such a joint jams, because points or axes do not fit."""
FIRST = 1e3
"""Factor by which the lengths of quaternions come first: they are never dropped."""


class Rows(NamedTuple):
    """Numbers of rows."""

    kept: np.ndarray
    repeating: np.ndarray
    almost: np.ndarray  # of those that are kept


def independent_rows(jacobian: np.ndarray, weights: np.ndarray, first: np.ndarray) -> Rows:
    """Rows of a Jacobian (n_lam, n_q) that repeat the others, and those that nearly do.

    QR with column pivoting on its transpose, rows scaled to length one for coordinates divided by their weights (n_q,); rows in `first`
    are taken before all others.
    """
    rows = np.real(jacobian) / weights
    rows = rows / np.sqrt(np.sum(rows * rows, axis=1, keepdims=True)).clip(np.finfo(float).tiny)
    rows[first] *= FIRST
    _, triangle, order = qr(rows.T, mode="economic", pivoting=True)
    size = np.abs(np.diag(triangle))
    count, sure = np.count_nonzero(size > REPEATS), np.count_nonzero(size > ALMOST)
    return Rows(np.sort(order[:count]), np.sort(order[count:]), np.sort(order[sure:count]))


def null_vectors(jacobian: np.ndarray, kept: np.ndarray, repeating: np.ndarray) -> np.ndarray:
    """N (n_lam, k) with J^T N = 0, one for every repeating row d: N_d = e_d - C_d^T, J_d = C_d J_K for the rows K that are kept.

    Complex-safe: without a conjugate.
    """
    found: np.ndarray = np.zeros((len(jacobian), len(repeating)), jacobian.dtype)
    own = jacobian[kept]
    found[repeating, np.arange(len(repeating))] = 1
    found[kept] = -np.linalg.solve(own @ own.T, own @ jacobian[repeating].T)
    return found
