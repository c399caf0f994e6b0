"""What sets a motion vibrating: the start where forces are not in balance, and the curves of loads and drivers."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from toolkit.curves.curve import Curve
from toolkit.equations.equations import Inputs
from toolkit.sensitivity.errors.lost_parts import History, shakes
from toolkit.solvers.direct_solve import solve_linear
from toolkit.system.solution import Solution

QUIET = 1e-7
"""Part of the model size (or rad) by which a jump of accelerations moves anything in a step, below which it excites nothing."""
MOST_KICKS = 6
"""So many of them are looked at, the largest."""
FORCES, ACCELERATIONS = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
"""Levels of the joints: their gaps, as statics closes them, and their accelerations alone."""
SAMPLES, MOST_SAMPLES, LEAST = 16, 20_000, 2
"""Instants of a step at which curves are looked at, in how many instants at most, and in how many of a step at least."""


class Kick(NamedTuple):
    """What accelerates a motion out of what it follows.

    Attributes
    ----------
    time
        When, or when most.
    state
        Number of the last state of the motion before it.
    jumps
        Accelerations that set in, and their rates, (n, 2).
    changes
        Their derivatives by the design, (2, n, n_x).
    history
        Of the curve that multiplies them; None of the start, where they are there at once.
    """

    time: float
    state: int
    jumps: np.ndarray
    changes: np.ndarray
    history: History | None = None


def kicks(solution: Solution) -> list[Kick]:
    """The start, and what the curves of loads and drivers do, as far as it moves something within a step."""
    found = [_start(solution), *_of_curves(solution)]
    system, longest = solution.system, float(np.diff(solution.times).max())
    spans = system.weights[: system.n_b, None] * longest ** np.array([2.0, 3.0])
    sizes = [float((np.abs(kick.jumps[: system.n_b]) * spans).max(initial=0.0)) * _variation(kick.history) for kick in found]
    order = sorted(range(len(found)), key=lambda n: -sizes[n])[:MOST_KICKS]
    return [found[n] for n in sorted(order) if sizes[n] > QUIET]


def _variation(history: History | None) -> float:
    return 1.0 if history is None else float(np.ptp(history.values))


def padded(solution: Solution, state: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """q, v, a of a state, (n,), with nothing for multipliers."""
    rest = np.zeros(solution.system.n - solution.system.n_q)
    q, v, a = (np.append(each[state], rest) for each in (solution.q, solution.v, solution.a))
    return q, v, a


def _start(solution: Solution) -> Kick:
    """Accelerations out of rest, and velocities that deform."""
    system = solution.system
    q, v, a = padded(solution, 0)
    terms = system.evaluate(system.inputs(solution.times[0], ACCELERATIONS), q, v, np.zeros(system.n))
    rate = system.times(terms.I_q + terms.A_q, v[:, None]) + system.times(terms.A_v, a[:, None])
    rate[system.n_b :] = 0
    mass = terms.I_acc + system.unit_of_states
    changes = np.zeros((2, system.n, system.n_x))
    if solution.da.shape[-1]:
        changes[0, : system.n_q] = solution.da[0]
    return Kick(float(solution.times[0]), 0, np.column_stack([a, _accelerated(solution, mass, rate)[:, 0]]), changes)


def _accelerated(solution: Solution, mass: np.ndarray, residuals: np.ndarray) -> np.ndarray:
    """Accelerations (n, k) by residuals (n, k) and a mass matrix with joints on the pattern, with nothing for multipliers."""
    found = solve_linear(solution.system, mass, -residuals, "accelerations")
    found[solution.system.n_b :] = 0
    return found


def _of_curves(solution: Solution) -> Iterator[Kick]:
    """Curves act by their value as loads, and by their second derivative as drivers."""
    for c, curve in enumerate(solution.system.values.curves.values()):
        if curve.is_constant:
            continue
        times = _instants(solution, curve)
        numbers = np.real(curve.evaluate(times))
        for column in (0, 2):
            history = History(times, numbers[:, column])
            if np.ptp(history.values) > 0 and (kick := _kick(solution, c, column, history)) is not None:
                yield kick


def _instants(solution: Solution, curve: Curve) -> np.ndarray:
    """Some in every step, and both sides of every corner."""
    times = solution.times
    count = min(max(MOST_SAMPLES // len(times), LEAST), SAMPLES)
    parts = times[:-1, None] + np.diff(times)[:, None] * np.arange(count) / count
    corners = np.array([float(np.real(t)) for t in curve.corners()])
    corners = corners[(corners >= times[0]) & (corners < times[-1])]
    before = corners[corners > times[0]]
    return np.unique([*parts.ravel(), times[-1], *np.nextafter(before, -np.inf), *np.nextafter(corners, np.inf)])


def _kick(solution: Solution, curve: int, column: int, history: History) -> Kick | None:
    """Accelerations by a curve that grows by one, about where it changes most in a step; None if they excite nothing."""
    system, times = solution.system, solution.times
    in_step = np.abs(np.diff(np.interp(times, *history)))
    state = int(np.argmax(in_step))
    q, v, _ = padded(solution, state)
    inputs, rest = system.inputs(times[state], ACCELERATIONS), np.zeros(system.n)
    size, moved = float(np.ptp(history.values)), inputs.curves.copy()
    moved[curve, column] += size
    there = inputs._replace(curves=moved)
    (before, before_x), (after, _) = (_residual(solution, each, q, v, rest) for each in (inputs, there))
    if np.array_equal(before, after) or not shakes(solution, history):
        return None
    mass = system.evaluate(inputs, q, v, rest).I_acc + system.unit_of_states
    acceleration = _accelerated(solution, mass, (after - before)[:, None])
    changes = np.zeros((2, system.n, system.n_x))
    if system.n_x:
        _, after_x = _residual(solution, there, q, v, acceleration[:, 0])
        changes[0] = _accelerated(solution, mass, after_x - before_x) / size
    jumps = np.column_stack([acceleration[:, 0] / size, np.zeros(system.n)])
    return Kick(float(times[state]), state, jumps, changes, history)


def _residual(solution: Solution, inputs: Inputs, q: np.ndarray, v: np.ndarray, acc: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Residual (n,) and its partial derivatives by the design (n, n_x)."""
    terms = solution.system.evaluate(inputs, q, v, acc, design=True, linearize=False)
    return terms.inertial + terms.applied, terms.I_x + terms.A_x
