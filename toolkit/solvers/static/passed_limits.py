"""Refusal of quasi-static motions that go on where the path of equilibria ends, or where it is unstable.

A step without inertia finds some equilibrium; nothing in it tells whether the one before leads there. Where the states do not follow each
other smoothly, the path between them is followed as in statics. Forces of dampers carry a motion past a limit point; with them nothing is
refused here.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import (
    ConvergenceError,
    CriticalPointError,
    LimitPointError,
    LimitPositionError,
    SingularSystemError,
)
from toolkit.solvers.start.open_joints import limit_of_drivers, told_limit
from toolkit.solvers.static.continuation import FULL_LOAD, limit_point
from toolkit.solvers.static.critical_state import has_negative_stiffness
from toolkit.solvers.static.equilibrium import LEVELS, inputs_at
from toolkit.solvers.static.path_equations import PassingTime, PathEquations, parts
from toolkit.solvers.static.path_steps import PREDICTION_MISS, Arc, arcs, first_point
from toolkit.system.system import System

MOST_STATES = 50
"""Most states whose stability is looked at to begin with."""
SAME_STATE = 1e-2
"""Part of the box within which the path leads to a state that was found."""
LONGEST_PART = 0.5
"""Longest step along the path between two states, a part of the time between them."""


def refuse_passed_limits(system: System, options: RunOptions, times: np.ndarray, q: np.ndarray, acc: np.ndarray) -> None:
    """Check states q, [a; lam] (n_t, n) at times (n_t,) of a motion without inertia.

    Raises
    ------
    ConvergenceError
        A limit point or a bifurcation lies between two of them; names the time.
    """
    z = np.real(np.where(np.arange(system.n) < system.n_q, q, acc))
    if _is_damped(system, z[0]):
        return
    for n in np.flatnonzero(_unsure(system, times, z)):
        _follow(system, options, times[n : n + 2], z[: n + 2])
    _refuse_unstable(system, times, z)


def _is_damped(system: System, z: np.ndarray) -> bool:
    equations = PathEquations(system, system.scene.solver, PassingTime(system, 0.0, 1.0))
    q, acc = equations.padded(z)
    return bool(np.any(system.evaluate(system.inputs(0.0, LEVELS), q, np.zeros_like(q), acc).A_v))


def _unsure(system: System, times: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Steps (n_t - 1,) whose end does not follow from the three states before, nor their beginning from the three after."""
    q = system.weights[: system.n_b] * z[:, : system.n_b]
    extent = np.maximum.accumulate(q) - np.minimum.accumulate(q)
    follows, precedes = _off(times, q), _off(times[::-1], q[::-1])[::-1]
    error = np.minimum(parts(follows[1:], extent[1:]), parts(precedes[:-1], extent[1:]))
    found: np.ndarray = error > PREDICTION_MISS
    return found


def _off(times: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Distance of states (n_t, n_q) from the parabola through the three before; infinite where there are fewer."""
    off = np.full(q.shape, np.inf)
    if len(q) > 3:
        a, b, c, t = (times[k : len(times) - 3 + k, None] for k in range(4))
        weights = (
            (t - b) * (t - c) / ((a - b) * (a - c)),
            (t - a) * (t - c) / ((b - a) * (b - c)),
            (t - a) * (t - b) / ((c - a) * (c - b)),
        )
        off[3:] = q[3:] - sum(weight * q[k : len(q) - 3 + k] for k, weight in enumerate(weights))
    return off


def _follow(system: System, options: RunOptions, times: np.ndarray, z: np.ndarray) -> None:
    """Follow the path from the last state but one to the last, of those so far (n_t, n)."""
    equations, n_b = PathEquations(system, options, PassingTime(system, *times)), system.n_b
    begin, span = times[0], times[1] - times[0]
    for arc in islice(_path(equations, z[-2], begin), options.path_steps):
        limit = limit_point(equations, arc)
        if limit:
            raise _passed(begin + span * limit.z[-1], system.most_moved(limit.slope))
        if arc.branching:
            raise _unstable(begin + span * arc.begin.factor)
        if arc.end.factor >= FULL_LOAD:
            break
    extent = system.weights[:n_b] * np.ptp(z[:, :n_b], axis=0)
    off = arc.end.z[:-1] - z[-1]
    if arc.end.factor < FULL_LOAD or parts(system.weights[:n_b] * off[:n_b], extent) > SAME_STATE:
        raise _passed(times[1], system.most_moved(off))


def _path(equations: PathEquations, z: np.ndarray, time: float) -> Iterator[Arc]:
    try:
        yield from arcs(equations, first_point(equations, np.append(z, 0.0)), LONGEST_PART)
    except (ConvergenceError, SingularSystemError) as error:
        raise ConvergenceError(
            f"without inertia the motion ends after t = {time:g}: the path of equilibria cannot be followed there ({error}). "
            "Only a run with inertia can go on."
        ) from error


def _refuse_unstable(system: System, times: np.ndarray, z: np.ndarray) -> None:
    """Refuse unstable states, by looking at some of them.

    Where one is unstable, halving the time since the last stable one finds where stability is lost.
    """
    equations = PathEquations(system, system.scene.solver, PassingTime(system, 0.0, times[-1]))

    def unstable(n: int) -> bool:
        matrix = equations.linearised(np.append(z[n], times[n] / times[-1]))[1]
        return has_negative_stiffness(system, matrix, equations.padded(z[n])[1])

    low = 0
    for n in np.unique(np.linspace(0, len(times) - 1, MOST_STATES).astype(int)):
        if unstable(n):
            high = int(n)
            while high - low > 1:
                middle = (low + high) // 2
                low, high = (low, middle) if unstable(middle) else (middle, high)
            raise _unstable(times[high])
        low = int(n)


def _unstable(time: float) -> ConvergenceError:
    return ConvergenceError(
        f"without inertia the motion is unstable from t = {time:.6g} on: past a bifurcation (buckling) or a limit point (snap-through) the "
        "smallest disturbance ends it. Only a run with inertia, from a slightly disturbed start, can follow."
    )


def _passed(time: float, coordinate: str) -> ConvergenceError:
    return ConvergenceError(
        f"the quasi-static motion jumps at t = {time:.6g}: at a limit point (snap-through) the path of equilibria turns back, and "
        f"{coordinate} runs away. Only a run with inertia can follow; statics names the point."
    )


SAME_LIMIT = 0.01
"""Part of the way of the drivers within which a limit position is the limit point that the path of equilibria has met."""


def at_limit_position(
    system: System, options: RunOptions, q: np.ndarray, factor: float, error: ConvergenceError | SingularSystemError
) -> ConvergenceError | SingularSystemError:
    """Error of a path from coordinates q (n,) at a factor on, or one that tells of the limit position to which drivers lead."""

    def acting(place: float):
        return inputs_at(system, options, place)

    limit = limit_of_drivers(system, acting, q, (0.0, factor, 1.0))
    met = error.load_factor if isinstance(error, CriticalPointError) else 1.0
    if limit is None or limit.place > met + SAME_LIMIT:
        return error
    text = told_limit(system, acting, limit, 1.0, f"at {100 * limit.place:.4g} % of the way of its drivers")
    if isinstance(error, CriticalPointError):
        return LimitPointError(text, error.load_factor, error.coordinate)
    return LimitPositionError(text)
