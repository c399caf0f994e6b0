"""Constraints that repeat others: which rows of the joints' Jacobian depend on the others in the undeformed configuration."""

from __future__ import annotations

import numpy as np
from scipy.linalg import qr

ROUND_OFF = 1e-9
"""Part of a row, of length one, that is independent of the rows before it, below which it repeats them."""
FIRST = 1e3
"""Factor by which the lengths of quaternions come first: they are never dropped."""


def redundant_rows(jacobian: np.ndarray, weights: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Numbers of rows of a Jacobian (n_lam, n_q) that repeat the others.

    QR with column pivoting on its transpose, rows scaled to length one for coordinates divided by their weights (n_q,); rows in `first`
    are taken before all others.
    """
    rows = np.real(jacobian) / weights
    rows = rows / np.sqrt(np.sum(rows * rows, axis=1, keepdims=True)).clip(np.finfo(float).tiny)
    rows[first] *= FIRST
    _, triangle, order = qr(rows.T, mode="economic", pivoting=True)
    size = np.abs(np.diag(triangle))
    return np.sort(order[np.count_nonzero(size > ROUND_OFF) :])
