"""Motions that the joints allow, and the stiffness against them: how large its terms are, and whether it is symmetric."""

from __future__ import annotations

import numpy as np
import scipy

from toolkit.system.system import System

ROUND_OFF = 1e-14
"""Part of the largest squared frequency, or of the stiffnesses that a mode's own is the sum of, below which it cannot be told
from zero."""
UNSYMMETRIC = 1e-9
"""Part of the largest stiffness that following forces make unsymmetric at least, if they do so at all."""


def made_of(
    stiffness: np.ndarray, phi_q: np.ndarray, multipliers: np.ndarray, weights: np.ndarray, motions: np.ndarray
) -> np.ndarray:
    """Size of the terms that the stiffness against motions (n_q, m) is the sum of, (m, m), by which its round-off is measured.

    They are entries of the stiffness, and joint forces at levers of the model size: those of a balance, which has no stiffness, cancel in
    each entry already.
    """
    sizes: np.ndarray = np.abs(motions)
    lever = (np.abs(phi_q.T) @ np.abs(np.real(multipliers)) / weights).max(initial=0)
    moves = (weights[:, None] * sizes).max(axis=0)
    return sizes.T @ np.abs(stiffness) @ sizes + lever * np.outer(moves, moves)


def free_motions(phi_q: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Basis of the motions that the joints allow, (n_q, n_free), in coordinates scaled to comparable size."""
    if not len(phi_q):
        return np.diag(1 / weights)
    scaled = phi_q / weights
    _, sizes, rows = np.linalg.svd(scaled)
    rank = np.count_nonzero(sizes > np.finfo(float).eps * max(scaled.shape) * sizes.max(initial=0))
    free: np.ndarray = rows[rank:].T / weights[:, None]
    return free


def felt_state(system: System, stiffness: np.ndarray) -> str:
    """Name of the first state of a load that bodies feel, by a stiffness (n_q, n_q) or larger; empty if there is none.

    One that counts turns they do not feel.
    """
    n_b = system.n_b
    felt = np.flatnonzero(np.any(stiffness[:n_b, n_b : system.n_q], axis=0))
    return system.numbering.names[n_b + felt[0]] if len(felt) else ""


def is_symmetric(stiffness: np.ndarray | scipy.sparse.csr_array, terms: float = 0.0) -> bool:
    """Whether a stiffness is symmetric but for round-off; `terms` is the largest of what its entries are sums of."""
    return bool(abs(stiffness - stiffness.T).max() <= UNSYMMETRIC * abs(stiffness).max() + 10 * ROUND_OFF * terms)


def is_symmetric_everywhere(matrix: np.ndarray | scipy.sparse.csr_array) -> bool:
    """Whether each entry is the same as its mirror, beside the stiffness of its own two coordinates.

    A force that follows a soft body makes it unsymmetric, however stiff others are.
    """
    largest, size = abs(matrix).max(), np.sqrt(np.abs(matrix.diagonal()))
    if isinstance(matrix, np.ndarray):
        off, least = np.abs(matrix - matrix.T), np.outer(size, size)
        return bool(np.all(off <= UNSYMMETRIC * (least + np.abs(matrix)) + ROUND_OFF * largest))
    off = scipy.sparse.coo_array(abs(matrix - matrix.T))
    both = np.asarray(scipy.sparse.csr_array(abs(matrix))[off.row, off.col]).ravel()
    allowed = UNSYMMETRIC * (size[off.row] * size[off.col] + both) + ROUND_OFF * largest
    return bool(np.all(off.data <= allowed))
