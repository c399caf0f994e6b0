"""Eigenfrequencies of the constrained, linearised system about an equilibrium."""

from __future__ import annotations

import numpy as np
import scipy

from toolkit.analyses.modes_found import Modes
from toolkit.analyses.spinning import spinning_modes
from toolkit.foundation.errors import SingularSystemError
from toolkit.foundation.mode_shapes import told_apart
from toolkit.foundation.verdict import Verdict
from toolkit.solvers.free_motions import ROUND_OFF, felt_state, free_motions, is_symmetric, made_of
from toolkit.solvers.start.initial_conditions import closed, initial_accelerations
from toolkit.system.solution import Solution
from toolkit.system.system import System
from toolkit.validity.bodies.damped_modes import cautions_of_damping
from toolkit.validity.bodies.frequencies import cautions_of_modes
from toolkit.validity.bodies.spinning.spin import cautions_of_spin
from toolkit.validity.judge import judge

SLOW = 1e-11
"""Part of the largest squared frequency below which another may be hidden by its round-off."""


def solve_modes(solution: Solution, count: int | None = None) -> Modes:
    """Undamped modes about the last state of a static solution (or any state at rest); of a steady spin those of `spinning_modes`.

        Z^T K Z y = omega^2 Z^T M Z y,   J Z = 0,   K = d (residual) / dq with the joint forces' geometric stiffness

    K holds the change of the inertia forces of the accelerations, which vanish in an equilibrium: of what falls they cancel the weight.
    K is unsymmetric under following forces; then the general eigenvalue problem is solved.

    Raises
    ------
    SingularSystemError
        The joints leave no motion, the mass matrix is not positive definite, or following forces make the motion flutter.
    """
    if solution.spins:
        return spinning_modes(solution, count)
    system = solution.system
    n_q, n_b = system.n_q, system.n_b
    pad = np.zeros(system.n - n_q)
    q, rest = np.concatenate([solution.q[-1], pad]), np.zeros(system.n)
    acc = np.concatenate([solution.a[-1], solution.multipliers[-1]])  # what falls feels no weight
    terms = system.evaluate(system.inputs(solution.times[-1], np.array([0, 0, 1.0])), q, rest, acc)
    dense = {name: system.dense(getattr(terms, name)) for name in ("I_acc", "I_q", "A_q", "A_v")}
    mass, stiffness = dense["I_acc"][:n_b, :n_b], (dense["I_q"] + dense["A_q"])[:n_b, :n_q]
    felt = felt_state(system, stiffness)
    if felt:
        raise SingularSystemError(
            f"{felt} is an integral over time, which undamped modes do not have. Ask for the response "
            "damping-ratio, whose vibrations feel it, or leave the integral out."
        )
    stiffness = stiffness[:, :n_b]
    phi_q, weights, multipliers = dense["I_acc"][:n_b, n_q:].T, system.weights[:n_b], solution.multipliers[-1]
    free = free_motions(phi_q, weights)
    if not free.shape[1]:
        raise SingularSystemError("the joints leave no motion, so there are no modes. Remove a joint or a driver.")
    largest = made_of(stiffness, phi_q, multipliers, weights, free).max()
    squares, vectors = _eigen(free.T @ stiffness @ free, free.T @ mass @ free, largest)
    squares, shapes = _slow_ones_again(stiffness, mass, squares, free @ vectors, largest)
    terms_of = np.diag(made_of(stiffness, phi_q, multipliers, weights, shapes))
    zero = np.abs(squares) < ROUND_OFF * np.maximum(np.abs(squares).max(), terms_of)
    squares = np.where(zero, 0.0, squares)
    order = np.argsort(squares, kind="stable")
    squares, shapes = squares[order], told_apart(squares[order], shapes[:, order], weights)
    frequencies = np.sign(squares) * np.sqrt(np.abs(squares)) / (2 * np.pi)
    damped = cautions_of_damping(dense["A_v"][:n_b, :n_b], mass, squares[:count], shapes[:, :count])
    raised = cautions_of_modes(solution, frequencies[:count], count)
    found = Verdict.of([*cautions_of_spin(solution, frequencies), *damped, *raised])
    return Modes(frequencies[:count], np.pad(shapes[:, :count], ((0, n_q - n_b), (0, 0))), found)


def _eigen(stiffness: np.ndarray, mass: np.ndarray, terms: float) -> tuple[np.ndarray, np.ndarray]:
    if is_symmetric(stiffness, terms):
        try:
            return scipy.linalg.eigh((stiffness + stiffness.T) / 2, (mass + mass.T) / 2)
        except scipy.linalg.LinAlgError as error:
            raise SingularSystemError(
                f"the mass matrix is not positive definite ({error}), so there are no modes. Give every body a mass that its stiffness "
                "does not dwarf beyond round-off."
            ) from error
    squares, vectors = scipy.linalg.eig(stiffness, mass)
    if np.abs(squares.imag).max() > 1e-6 * np.abs(squares).max():
        raise SingularSystemError(
            "following forces make the motion flutter: the squares of some frequencies are complex. "
            "Use the transient analysis, or forces fixed in space."
        )
    return squares.real, vectors.real


def _slow_ones_again(
    stiffness: np.ndarray, mass: np.ndarray, squares: np.ndarray, shapes: np.ndarray, terms: float
) -> tuple[np.ndarray, np.ndarray]:
    """The slowest modes anew among themselves (Rayleigh and Ritz): round-off of the fastest may make free ones unstable."""
    slow = np.abs(squares) < SLOW * np.abs(squares).max()
    if slow.any():
        own = shapes[:, slow]
        squares[slow], turn = _eigen(own.T @ stiffness @ own, own.T @ mass @ own, terms)
        shapes[:, slow] = own @ turn
    return squares, shapes


def undeformed(system: System) -> Solution:
    """The given positions without deflection and velocity, with the joint forces that the loads at t = 0 call for.

    Raises
    ------
    InputError, SingularSystemError
        As `consistent_start`.
    """
    q, dq = closed(system, *system.undeformed(), 0.0)
    rest, drest = np.zeros_like(q), np.zeros_like(dq)
    acc, dacc = initial_accelerations(system, q, rest, dq, drest, np.array([1.0, 0.0, 0.0]), 0.0)
    options = system.scene.solver.model_copy(update={"equilibrium": "rest"})  # whatever statics would find
    states = tuple(item[None] for item in (q, rest, acc, dq, drest, dacc))
    return Solution.from_padded(system, np.zeros(1), states, options=options, judge=judge)
