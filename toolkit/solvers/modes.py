"""Eigenfrequencies of the constrained, linearised system about an equilibrium."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, eig, eigh, null_space

from toolkit.errors import SingularSystemError
from toolkit.solution import Solution
from toolkit.validity.spin import cautions_of_spin
from toolkit.validity.verdict import Verdict

ROUND_OFF = 1e-14
"""Part of the largest squared frequency below which another cannot be told from zero."""


class Modes(NamedTuple):
    """Frequencies in cycles per time, ascending, and mode shapes.

    A negative frequency f stands for an unstable equilibrium: the motion grows like exp(2 pi |f| t).
    The verdict holds what speaks against them: that the scene spins, for example, while these are modes about a state at rest.
    """

    frequencies: np.ndarray  # (n_modes,)
    shapes: np.ndarray  # (n_q, n_modes)
    verdict: Verdict = Verdict()


def solve_modes(solution: Solution, count: int | None = None) -> Modes:
    """Undamped modes about the last state of a static solution (or any state at rest).

        Z^T K Z y = omega^2 Z^T M Z y,   J Z = 0,   K = d (residual) / dq with the joint forces' geometric stiffness

    K is unsymmetric under following forces; then the general eigenvalue problem is solved.

    Raises
    ------
    SingularSystemError
        The joints leave no motion, the mass matrix is not positive definite, or following forces make the motion flutter.
    """
    system = solution.system
    n_q = system.n_q
    pad = np.zeros(system.n - n_q)
    q, rest = np.concatenate([solution.q[-1], pad]), np.zeros(system.n)
    acc = np.concatenate([np.zeros(n_q), solution.multipliers[-1]])
    terms = system.evaluate(system.inputs(solution.times[-1], np.array([0, 0, 1.0])), q, rest, acc)
    dense = {name: system.matrix(getattr(terms, name)).toarray() for name in ("I_acc", "I_q", "A_q")}
    mass, stiffness = dense["I_acc"][:n_q, :n_q], (dense["I_q"] + dense["A_q"])[:n_q, :n_q]
    free = free_motions(dense["I_acc"][:n_q, n_q:].T, system.weights[:n_q])
    if not free.shape[1]:
        raise SingularSystemError("the joints leave no motion, so there are no modes. Remove a joint or a driver.")
    squares, vectors = _eigen(free.T @ stiffness @ free, free.T @ mass @ free)
    squares = np.where(np.abs(squares) < ROUND_OFF * np.abs(squares).max(initial=0), 0.0, squares)
    order = np.argsort(squares, kind="stable")[:count]
    frequencies = np.sign(squares) * np.sqrt(np.abs(squares)) / (2 * np.pi)
    return Modes(frequencies[order], free @ vectors[:, order], Verdict.of(cautions_of_spin(solution, frequencies)))


def free_motions(phi_q: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Basis of the motions that the joints allow, (n_q, n_free), in coordinates scaled to comparable size."""
    if not len(phi_q):
        return np.diag(1 / weights)
    return null_space(phi_q / weights).reshape(len(weights), -1) / weights[:, None]


def _eigen(stiffness: np.ndarray, mass: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    asymmetry = np.abs(stiffness - stiffness.T).max(initial=0)
    if asymmetry <= 1e-9 * np.abs(stiffness).max(initial=0):
        try:
            return eigh((stiffness + stiffness.T) / 2, (mass + mass.T) / 2)
        except LinAlgError as error:
            raise SingularSystemError(
                f"the mass matrix is not positive definite ({error}), so there are no modes. Give every body a mass that its stiffness "
                "does not dwarf beyond round-off."
            ) from error
    squares, vectors = eig(stiffness, mass)
    if np.abs(squares.imag).max() > 1e-6 * np.abs(squares).max():
        raise SingularSystemError(
            "following forces make the motion flutter: the squares of some frequencies are complex. "
            "Use the transient analysis, or forces fixed in space."
        )
    return squares.real, vectors.real
