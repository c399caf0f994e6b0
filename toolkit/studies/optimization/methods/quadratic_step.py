"""The step of sequential quadratic programming within a box, where the constraints may have to give way.

    min  g p + p B p / 2 + sum of nu t + w t^2 / 2,    c + J p + t >= 0,   t >= 0,   low <= p <= high

It is written as the shortest vector in a polyhedron, which non-negative least squares finds (Lawson and Hanson, 1974, chapter 23): no
iteration has a tolerance of its own.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import nnls

SOFT = 1e-3
"""w, the curvature of the price that a violated constraint has: small beside nu, so that it decides nothing."""
EMPTY = 1e-14
"""Residual of the least squares below which the polyhedron is empty."""


class Step(NamedTuple):
    """The step p (n,) and the multipliers of the constraints (m,)."""

    p: np.ndarray
    multipliers: np.ndarray


class Linearised(NamedTuple):
    """Slope g (n,) of the objective, constraints c (m,) and their slopes J (m, n)."""

    g: np.ndarray
    c: np.ndarray
    j: np.ndarray


def quadratic_step(curvature: np.ndarray, at: Linearised, low: np.ndarray, high: np.ndarray, price: float) -> Step | None:
    """The best step by positive definite curvatures B (n, n), with t only where no step keeps the constraints; none where round-off leaves
    none."""
    n, m = len(at.g), len(at.c)
    factor = cholesky(curvature, lower=True)
    back = solve_triangular(factor, np.eye(n), lower=True).T  # p = back (x - offset), |x|^2 / 2 = g p + p B p / 2 + a constant
    p_0 = -back @ solve_triangular(factor, at.g, lower=True)
    rows, least = np.vstack([at.j @ back, back, -back]), np.concatenate([-at.c - at.j @ p_0, low - p_0, p_0 - high])
    shortest = _shortest(rows, least)
    if shortest is None:
        beside, t_0 = np.eye(m) / np.sqrt(SOFT), np.full(m, -price / SOFT)
        soft = np.vstack([beside, np.zeros((2 * n, m)), beside])
        rows = np.hstack([np.vstack([rows, np.zeros((m, n))]), soft])
        shortest = _shortest(rows, np.concatenate([least[:m] - t_0, least[m:], -t_0]))
    if shortest is None:
        return None
    x, multipliers = shortest
    return Step(np.clip(back @ x[:n] + p_0, low, high), multipliers[:m])


def _shortest(rows: np.ndarray, least: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """The shortest x with rows x >= least, and the multipliers of that; none where there is no such x."""
    matrix, wanted = np.vstack([rows.T, least]), np.zeros(rows.shape[1] + 1)
    wanted[-1] = 1.0
    weights, _ = nnls(matrix, wanted, maxiter=30 * len(rows))
    left = matrix @ weights - wanted
    if -left[-1] < EMPTY:
        return None
    return -left[:-1] / left[-1], weights / -left[-1]
