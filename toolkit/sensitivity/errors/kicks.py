"""What sets a motion vibrating: the start where forces are not in balance, and jumps of the curves of loads and drivers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.equations.equations import Inputs
from toolkit.solvers.direct_solve import solve_linear
from toolkit.system.solution import Solution

QUIET = 1e-7
"""Part of the scene's size (or rad) by which a jump of accelerations moves anything in a step, below which it excites nothing."""
MOST_KICKS, MOST_CORNERS = 4, 12
"""So many of them are looked at, the largest, from so many corners of curves."""
FORCES, ACCELERATIONS = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
"""Levels of the joints: their gaps, as statics closes them, and their accelerations alone."""
SAME = 1e-9
"""Part of a curve's numbers by which the two sides of a corner may differ by round-off."""
BY_VALUE = np.array([1.0, 0.0, 0.0])


class Kick(NamedTuple):
    """Jumps of the accelerations and of their two next derivatives by time.

    Attributes
    ----------
    time
        When.
    state
        Number of the last state of the motion before it.
    jumps
        Shape (n, 3).
    changes
        Their derivatives by the design, (3, n, n_x).
    """

    time: float
    state: int
    jumps: np.ndarray
    changes: np.ndarray


class Corner(NamedTuple):
    """A time at which curves jump: their numbers before, and the jumps of f, of f' and of f'', each (n_curves, 3)."""

    time: float
    before: np.ndarray
    jumps: tuple[np.ndarray, np.ndarray, np.ndarray]


def kicks(solution: Solution) -> list[Kick]:
    """The start, and what the curves of loads and drivers do at their corners, where it moves something within a step."""
    found = [_start(solution), *(_kick(solution, corner) for corner in _corners(solution))]
    system, longest = solution.system, float(np.diff(solution.times).max())
    spans = system.weights[: system.n_b, None] * longest ** np.array([2.0, 3.0, 4.0])
    sizes = [float((np.abs(kick.jumps[: system.n_b]) * spans).max(initial=0.0)) for kick in found]
    order = sorted(range(len(found)), key=lambda n: -sizes[n])[:MOST_KICKS]
    return [found[n] for n in sorted(order) if sizes[n] > QUIET]


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
    jumps = np.column_stack([a, _accelerated(solution, mass, rate)[:, 0], np.zeros(system.n)])
    changes = np.zeros((3, system.n, system.n_x))
    if solution.da.shape[-1]:
        changes[0, : system.n_q] = solution.da[0]
    return Kick(float(solution.times[0]), 0, jumps, changes)


def _accelerated(solution: Solution, mass: np.ndarray, residuals: np.ndarray) -> np.ndarray:
    """Accelerations (n, k) by residuals (n, k) and a mass matrix with joints on the pattern, with nothing for multipliers."""
    system = solution.system
    found = solve_linear(system, mass, -residuals, "accelerations")
    found[system.n_b :] = 0
    return found


def _corners(solution: Solution) -> list[Corner]:
    """Those at which the curves jump most, and the start, at which they begin."""
    times, curves = solution.times, solution.system.values.curves.values()
    moving = [curve for curve in curves if not curve.is_constant]
    if not moving:
        return []
    places = {float(np.real(t)) for curve in moving for t in curve.corners()}
    found = [_corner(solution, times[0]), *(_corner(solution, t) for t in places if times[0] < t < times[-1])]
    step = float(np.diff(times).max())
    sizes = [_size(corner, step) for corner in found]
    order = sorted(range(len(found)), key=lambda n: (-sizes[n], found[n].time))[:MOST_CORNERS]
    return [found[n] for n in order if sizes[n] > SAME]


def _corner(solution: Solution, time: float) -> Corner:
    """Of the start, before which nothing changes, all rates are jumps."""
    after = _curves(solution, np.nextafter(time, np.inf))
    if time == solution.times[0]:
        before = _curves(solution, time)
        slopes, bends = after[:, [1]], after[:, [2]]
    else:
        before = _curves(solution, np.nextafter(time, -np.inf))
        slopes, bends = (after - before)[:, [1]], (after - before)[:, [2]]
    return Corner(time, before, (after - before, slopes * BY_VALUE, bends * BY_VALUE))


def _size(corner: Corner, step: float) -> float:
    """The largest jump within a step, a part of the curve's numbers."""
    level = np.abs(corner.before[:, 0]) + np.abs(corner.before[:, 0] + corner.jumps[0][:, 0])
    jumped = sum(np.abs(jump[:, 0]) * step**k for k, jump in enumerate(corner.jumps)) + np.abs(corner.jumps[0][:, 2]) * step**2
    return float(np.divide(jumped, level, out=np.where(jumped > 0, 1.0, 0.0), where=level > jumped).max(initial=0.0))


def _curves(solution: Solution, time: float) -> np.ndarray:
    """f, f', f'' of all curves, (n_curves, 3)."""
    return np.array([np.real(curve.evaluate(np.array([time]))[0]) for curve in solution.system.values.curves.values()])


def _kick(solution: Solution, corner: Corner) -> Kick:
    """Accelerations by jumps of the curves, as if their loads grew by the jump, with time and with its square."""
    system = solution.system
    state = max(int(np.searchsorted(solution.times, corner.time, "left")) - 1, 0)
    q, v, _ = padded(solution, state)
    inputs = system.inputs(solution.times[state], ACCELERATIONS)
    rest = np.zeros(system.n)
    mass = system.evaluate(inputs, q, v, rest).I_acc + system.unit_of_states
    before, before_x = _residual(solution, inputs._replace(curves=corner.before), q, v, rest)
    jumps, changes = [], []
    for jump in corner.jumps:
        there = inputs._replace(curves=corner.before + jump)
        after, _ = _residual(solution, there, q, v, rest)
        jumps.append(_accelerated(solution, mass, (after - before)[:, None])[:, 0])
        _, after_x = _residual(solution, there, q, v, jumps[-1])
        changes.append(_accelerated(solution, mass, after_x - before_x) if system.n_x else after_x)
    return Kick(corner.time, state, np.stack(jumps, axis=1), np.array(changes))


def _residual(solution: Solution, inputs: Inputs, q: np.ndarray, v: np.ndarray, acc: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Residual (n,) and its partial derivatives by the design (n, n_x)."""
    terms = solution.system.evaluate(inputs, q, v, acc, design=True, linearize=False)
    return terms.inertial + terms.applied, terms.I_x + terms.A_x
