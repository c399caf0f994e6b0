"""Eigenfrequencies of the constrained, linearised system about an equilibrium."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.analyses.modes_found import Modes
from toolkit.analyses.spinning import spinning_modes
from toolkit.foundation.errors import SingularSystemError
from toolkit.foundation.mode_shapes import told_apart
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.responses.vibrations.flutter import unstable_vibrations
from toolkit.solvers.free_motions import ROUND_OFF, felt_state, free_motions, made_of
from toolkit.solvers.start.initial_conditions import closed, initial_accelerations
from toolkit.solvers.undamped_modes import undamped_modes
from toolkit.system.solution import Solution
from toolkit.system.system import System
from toolkit.validity.bodies.damped_modes import cautions_of_damping
from toolkit.validity.bodies.frequencies import cautions_of_modes
from toolkit.validity.bodies.spinning.spin import cautions_of_spin
from toolkit.validity.judge import judge


def solve_modes(solution: Solution, count: int | None = None) -> Modes:
    """Undamped modes about the last state of a static solution (or any state at rest); of a steady spin those of `spinning_modes`.

        Z^T K Z y = omega^2 Z^T M Z y,   J Z = 0,   K = d (residual) / dq with the joint forces' geometric stiffness

    K holds the change of the inertia forces of the accelerations, which vanish in an equilibrium: of what falls they cancel the weight.
    K is unsymmetric under following forces; then the general eigenvalue problem is solved, and two modes may flutter: they have one
    frequency, one grows and the other decays. Whether an imaginary part is round-off is decided by the condition of its own pair.

    Raises
    ------
    SingularSystemError
        The joints leave no motion, or the mass matrix is not positive definite.
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
    squares, shapes = undamped_modes(stiffness, mass, free, largest)
    terms_of = np.diag(made_of(stiffness, phi_q, multipliers, weights, shapes))
    zero = (np.abs(squares) < ROUND_OFF * np.maximum(np.abs(squares).max(), terms_of)) & (np.imag(squares) == 0)
    squares = np.where(zero, 0.0, squares)
    frequencies, ratios = _vibrations(squares)
    order = np.lexsort((ratios, frequencies))
    squares, frequencies, ratios, shapes = squares[order], frequencies[order], ratios[order], shapes[:, order]
    real = np.flatnonzero(ratios == 0)
    if real.size:
        shapes[:, real] = told_apart(squares[real].real, shapes[:, real].real, weights)
    damped = cautions_of_damping(dense["A_v"][:n_b, :n_b], mass, *_first(squares, shapes, real[real < (count or len(squares))]))
    raised = cautions_of_modes(solution, frequencies[:count], count)
    unstable = unstable_vibrations(solution)
    found = Verdict.of([*cautions_of_spin(solution, frequencies), *damped, *raised, *unstable, *_flutter(frequencies, ratios)])
    shapes = np.pad(shapes[:, :count], ((0, n_q - n_b), (0, 0)))
    return Modes(frequencies[:count], shapes, found, ratios[:count] if np.any(ratios) else None)


def _first(squares: np.ndarray, shapes: np.ndarray, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return squares[chosen].real, shapes[:, chosen].real


def _vibrations(squares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies in cycles per time, and damping in parts of the critical one, of squares that are complex where vibrations flutter.

    Of a pair of squares one belongs to a vibration that grows, the other to one of the same frequency that decays.
    """
    s = np.sqrt(-squares + 0j)
    s = np.where(s.imag < 0, -s, s)
    flutters = np.imag(squares) != 0
    sizes = np.sqrt(np.abs(squares))
    frequencies = np.where(flutters, s.imag, np.sign(squares.real) * sizes) / (2 * np.pi)
    return frequencies, np.divide(-s.real, sizes, out=np.zeros(len(s)), where=flutters)


def _flutter(frequencies: np.ndarray, ratios: np.ndarray) -> Iterator[Caution]:
    """Caution on a mode of negative damping, with its numbers, where modes without dampers flutter."""
    growing = np.flatnonzero(ratios < 0)
    if growing.size:
        k = int(growing[0])
        rate = -2 * np.pi * frequencies[k] * ratios[k] / np.sqrt(1 - ratios[k] ** 2)
        yield Caution(
            "flutter",
            f"two modes have merged into one frequency, {frequencies[k]:.4g} Hz (numbers {k + 1} and {k + 2}): without dampers one grows "
            f"like exp({rate:.4g} t), the other one decays as fast.",
            doubt=False,
        )


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
