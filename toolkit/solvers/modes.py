"""Eigenfrequencies of the constrained, linearised system about an equilibrium."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, eig, eigh, null_space

from toolkit.errors import SingularSystemError
from toolkit.mode_shapes import told_apart
from toolkit.solution import Solution
from toolkit.validity.damped_modes import cautions_of_damping
from toolkit.validity.spin import cautions_of_spin
from toolkit.validity.verdict import Verdict

ROUND_OFF = 1e-14
"""Part of the largest squared frequency, or of the stiffnesses that a mode's own is the sum of, below which it cannot be told
from zero."""
UNSYMMETRIC = 1e-9
"""Part of the largest stiffness that following forces make unsymmetric at least, if they do so at all."""


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
    dense = {name: system.matrix(getattr(terms, name)).toarray() for name in ("I_acc", "I_q", "A_q", "A_v")}
    mass, stiffness = dense["I_acc"][:n_q, :n_q], (dense["I_q"] + dense["A_q"])[:n_q, :n_q]
    phi_q, weights, multipliers = dense["I_acc"][:n_q, n_q:].T, system.weights[:n_q], solution.multipliers[-1]
    free = free_motions(phi_q, weights)
    if not free.shape[1]:
        raise SingularSystemError("the joints leave no motion, so there are no modes. Remove a joint or a driver.")
    squares, vectors = _eigen(
        free.T @ stiffness @ free, free.T @ mass @ free, made_of(stiffness, phi_q, multipliers, weights, free).max()
    )
    shapes = free @ vectors
    terms_of = np.diag(made_of(stiffness, phi_q, multipliers, weights, shapes))
    zero = np.abs(squares) < ROUND_OFF * np.maximum(np.abs(squares).max(), terms_of)
    squares = np.where(zero, 0.0, squares)
    order = np.argsort(squares, kind="stable")
    squares, shapes = squares[order], told_apart(squares[order], shapes[:, order], weights)
    frequencies = np.sign(squares) * np.sqrt(np.abs(squares)) / (2 * np.pi)
    damped = cautions_of_damping(dense["A_v"][:n_q, :n_q], mass, squares[:count], shapes[:, :count])
    return Modes(frequencies[:count], shapes[:, :count], Verdict.of([*cautions_of_spin(solution, frequencies), *damped]))


def made_of(
    stiffness: np.ndarray, phi_q: np.ndarray, multipliers: np.ndarray, weights: np.ndarray, motions: np.ndarray
) -> np.ndarray:
    """How large the terms are that the stiffness against motions (n_q, m) is the sum of, (m, m): what its round-off is measured by.

    They are entries of the stiffness, and joint forces at levers of the scene's size: those of a balance, which has no stiffness, cancel in
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
    return null_space(phi_q / weights).reshape(len(weights), -1) / weights[:, None]


def is_symmetric(stiffness: np.ndarray, terms: float) -> bool:
    """Whether a stiffness is symmetric but for round-off; `terms` is the largest of what its entries are sums of."""
    return bool(np.abs(stiffness - stiffness.T).max() <= UNSYMMETRIC * np.abs(stiffness).max() + 10 * ROUND_OFF * terms)


def _eigen(stiffness: np.ndarray, mass: np.ndarray, terms: float) -> tuple[np.ndarray, np.ndarray]:
    if is_symmetric(stiffness, terms):
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
