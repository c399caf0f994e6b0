"""Stiffnesses nearest to zero, against motions that the joints allow, in coordinates of comparable size."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from toolkit.solvers.static.stability.saddle import Saddle

COUNT = 2
"""Motions that are watched: the softest one may be overtaken by another."""
ITERATIONS, AGAIN = 6, 2
"""Iterations of the inverse iteration, from anywhere and from the motions of a point near by."""


class Softness(NamedTuple):
    """Stiffnesses k (m,) and their motions with the forces of the joints, [phi; mu] (n, m).

        K phi + phi_q^T mu = k W phi,   phi_q phi = 0,   W = diag(w^2),   phi^T W phi = 1

    with the weights w of the system.
    """

    values: np.ndarray
    motions: np.ndarray

    def change(self, difference: np.ndarray) -> np.ndarray:
        """Changes of the stiffnesses (m,) with a difference of the static matrix (n, n)."""
        found: np.ndarray = (self.motions * (difference @ self.motions)).sum(axis=0)
        return found


def softest(saddle: Saddle, n_free: int, n_b: int, known: Softness | None = None) -> Softness:
    """Softest stiffnesses, by inverse iteration of a block with Rayleigh's quotients; none if the matrix is not symmetric.

    The iteration begins with those of a point near by if it has as many.
    """
    n, count = len(saddle.scale), min(COUNT, n_free) if saddle.symmetric else 0
    nothing = Softness(np.zeros(0), np.zeros((n, 0)))
    if not count:
        return nothing
    scale, forces = saddle.scale[:n_b, None], np.zeros((n - n_b, count))
    near = None if known is None or len(known.values) != count else known.motions[:n_b] / scale
    block = np.random.default_rng(0).normal(size=(n_b, count)) if near is None else near
    for _ in range(ITERATIONS if near is None else AGAIN):
        block = _orthonormal(block)
        solved = saddle.solve(np.vstack([block / scale, forces]))
        flexibility, turn = np.linalg.eigh(block.T @ (solved[:n_b] / scale))
        if not np.all(flexibility):
            return nothing  # round-off has swallowed a motion of a scene whose sizes differ by too much
        solved = solved @ turn / flexibility
        block = solved[:n_b] / scale
    return Softness(1 / flexibility, solved / np.sqrt((block**2).sum(axis=0)))


def _orthonormal(block: np.ndarray) -> np.ndarray:
    """Columns (n, m) made orthonormal, by LAPACK itself: to prepare its call takes longer than these few columns."""
    factors, scales, _, _ = scipy.linalg.lapack.dgeqrf(block)
    found: np.ndarray = scipy.linalg.lapack.dorgqr(factors, scales)[0]
    return found
