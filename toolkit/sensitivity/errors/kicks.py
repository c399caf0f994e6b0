"""What sets a motion vibrating: the start where forces are not in balance, and jumps of the curves of loads and drivers."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from toolkit.equations.equations import Terms
from toolkit.solvers.direct_solve import solve_linear
from toolkit.system.solution import Solution

QUIET = 1e-7
"""Part of the scene's size (or rad) by which a jump of accelerations moves anything in a step, below which it excites nothing."""
MOST_KICKS = 4
"""So many jumps of load curves are looked at, the largest."""
FORCES, ACCELERATIONS = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
"""Levels of the joints: their gaps, as statics closes them, and their accelerations alone."""
SAME = 1e-9
"""Part of a curve's numbers by which the two sides of a corner may differ by round-off."""


class Kick(NamedTuple):
    """Jumps of the accelerations and of their two next derivatives, (n, 3), at a time, and the number of the last state before it."""

    time: float
    state: int
    jumps: np.ndarray


def kicks(solution: Solution) -> Iterator[Kick]:
    """The start, and what the curves of loads and drivers do at their corners, where it moves something within a step."""
    system, longest = solution.system, float(np.diff(solution.times).max())
    found = [*filter(None, [_start(solution)]), *_corners(solution)]
    spans = longest ** np.array([2.0, 3.0, 4.0])
    sizes = [
        float((system.weights[: system.n_b, None] * np.abs(kick.jumps[: system.n_b]) * spans).max(initial=0.0)) for kick in found
    ]
    order = sorted(range(len(found)), key=lambda n: -sizes[n])[:MOST_KICKS]
    yield from (found[n] for n in sorted(order) if sizes[n] > QUIET)


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
    rate = system.times(terms.I_q + terms.A_q, v[:, None])[:, 0] + system.times(terms.A_v, a[:, None])[:, 0]
    rate[system.n_b :] = 0
    return Kick(float(solution.times[0]), 0, np.stack([a, _accelerated(solution, terms, rate), np.zeros(system.n)], axis=1))


def _accelerated(solution: Solution, terms: Terms, residual: np.ndarray) -> np.ndarray:
    """Accelerations (n,) by a residual, with nothing for multipliers."""
    system = solution.system
    found = solve_linear(system, terms.I_acc + system.unit_of_states, -residual, "accelerations")
    found[system.n_b :] = 0
    return found


def _corners(solution: Solution) -> Iterator[Kick]:
    """Jumps of the curves themselves, of their slopes and of their curvatures."""
    system, times = solution.system, solution.times
    curves = list(system.values.curves.values())
    corners = {float(np.real(t)) for curve in curves if not curve.is_constant for t in curve.corners()}
    for corner in sorted(t for t in corners if times[0] <= t < times[-1]):
        begins = corner == times[0]
        state = max(int(np.searchsorted(times, corner, "left")) - 1, 0)
        before, after = (
            _curves(curves, t) for t in (corner if begins else np.nextafter(corner, -np.inf), np.nextafter(corner, np.inf))
        )
        jumps = after - before
        if np.any(np.abs(jumps) > SAME * (np.abs(after) + np.abs(before))):
            yield Kick(corner, state, _jumps(solution, state, before, jumps))


def _curves(curves: list[Any], time: float) -> np.ndarray:
    """f, f', f'' of all curves, (n_curves, 3)."""
    return np.array([np.real(curve.evaluate(np.array([time]))[0]) for curve in curves])


def _jumps(solution: Solution, state: int, before: np.ndarray, jumps: np.ndarray) -> np.ndarray:
    """Accelerations (n, 3) by jumps of the curves (n_curves, 3), as if their loads grew by the jump, with time and with its square."""
    system = solution.system
    q, v, _ = padded(solution, state)
    inputs = system.inputs(solution.times[state], ACCELERATIONS)
    changes = [jumps, *(jumps[:, [k]] * np.array([1.0, 0.0, 0.0]) for k in (1, 2))]
    residuals, terms = [], None
    for change in (0 * before, *changes):
        terms = system.evaluate(inputs._replace(curves=before + change), q, v, np.zeros(system.n))
        residuals.append(terms.inertial + terms.applied)
    return np.stack([_accelerated(solution, terms, each - residuals[0]) for each in residuals[1:]], axis=1)
