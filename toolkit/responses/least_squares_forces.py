"""Multipliers of redundant constraints: of all that give the same forces on the bodies those of least squares.

The run has lam_K for a set K of independent rows, and zero for the others (see `compilation.redundant_rows`). With all rows
J = C J_K, C = J J_K^T (J_K J_K^T)^-1, and weights S that make forces and torques comparable,

    C^T lam = lam_K,   lam^T S^2 lam minimal:      lam = S^-2 C (C^T S^-2 C)^-1 lam_K

Derivatives: with A = J^T S^-1, mu = S lam and P = A^+ A, from A mu = J_K^T lam_K,

    dmu = A^+ (d(J^T lam_run) - dA mu) + (I - P) dA^T A^+^T mu
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from toolkit.equations import Inputs, Terms
from toolkit.system import System


class Forces(NamedTuple):
    """Multipliers and their derivatives by q, by the run's multipliers and by the design."""

    value: np.ndarray  # (n_lam,)
    by_q: np.ndarray  # (n_lam, n_q)
    by_lam: np.ndarray  # (n_lam, n_lam)
    by_x: np.ndarray  # (n_lam, n_x)


def least_squares_forces(system: System, q: np.ndarray, lam: np.ndarray) -> Forces:
    """Multipliers (n_lam,) of least squares for those of a run from which redundant rows were dropped."""
    n_lam = system.n - system.n_q
    whole = replace(system, plan=system.plan._replace(dropped=np.zeros(0, np.int64)))
    scale = 1 / system.weights[system.n_q :]  # S
    J = _blocks(whole, _terms(whole, q, np.zeros(system.n_q), 0 * lam))[2]
    kept = np.setdiff1d(np.arange(n_lam), system.plan.dropped - system.n_q)
    C = np.linalg.solve(J[kept] @ J[kept].T, J[kept] @ J.T).T
    weighted = C / scale[:, None] ** 2
    value = weighted @ np.linalg.solve(C.T @ weighted, lam[kept])
    return Forces(value, *_derivatives(whole, q, np.real(lam), np.real(value), np.real(J), scale))


def _derivatives(
    whole: System, q: np.ndarray, lam: np.ndarray, value: np.ndarray, J: np.ndarray, scale: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    A, mu = J.T / scale, scale * value
    inverse = np.linalg.pinv(A, rcond=1e-9)
    through = inverse.T @ mu
    free = np.eye(len(mu)) - inverse @ A
    force = _blocks(whole, _terms(whole, q, 0 * through, lam - value))
    rows = _blocks(whole, _terms(whole, q, through, 0 * value))
    by_q = inverse @ force[0] + free @ (rows[1] / scale[:, None])
    by_x = inverse @ force[3] + free @ (rows[4] / scale[:, None])
    return by_q / scale[:, None], inverse @ J.T / scale[:, None], by_x / scale[:, None]


def _terms(whole: System, q: np.ndarray, a: np.ndarray, lam: np.ndarray) -> Terms:
    """Joints alone: J^T lam, and J a in their rows."""
    curves, curves_x = whole.curves(np.zeros(1))
    inputs = Inputs(curves[0], curves_x[0], 1.0, np.array([1.0, 0, 0]), True, True)
    dtype = np.result_type(q, a, lam, whole.dtype)
    padded, acc = np.concatenate([q, 0 * lam]).astype(dtype), np.concatenate([a, lam]).astype(dtype)
    return whole.evaluate(inputs, padded, 0 * padded, acc, design=True)


def _blocks(whole: System, terms: Terms) -> tuple[np.ndarray, ...]:
    """d(J^T lam)/dq, d(J a)/dq, J, d(J^T lam)/dx, d(J a)/dx."""
    n_q = whole.n_q
    by_q, by_acc = whole.matrix(terms.I_q).toarray(), whole.matrix(terms.I_acc).toarray()
    return by_q[:n_q, :n_q], by_q[n_q:, :n_q], by_acc[n_q:, :n_q], terms.I_x[:n_q], terms.I_x[n_q:]
