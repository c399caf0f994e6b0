"""Consistent start: positions checked, velocities found, accelerations and multipliers solved for."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ConvergenceError, InputError, NoDerivativeError
from toolkit.solvers.direct_solve import solve_linear
from toolkit.solvers.start.rigid_bodies import told
from toolkit.solvers.start.start_velocities import (
    assemble,
    carried_along,
    project_velocities,
    refuse_own_velocities,
    written_velocities,
)
from toolkit.system.equations import Terms
from toolkit.system.system import System

POSITION_TOLERANCE = 1e-8
"""Largest violation of a constraint at the start, relative to the model size (or rad): round-off of input with 9 digits."""
VARIABLES_AT_ONCE = 64
"""Design variables whose derivatives of the constraints are looked at together."""


class State(NamedTuple):
    """One state, padded to n, and its total design derivatives (n, n_x)."""

    q: np.ndarray
    v: np.ndarray
    acc: np.ndarray
    dq: np.ndarray
    dv: np.ndarray
    dacc: np.ndarray


class ConsistentMotion(NamedTuple):
    """Coordinates and velocities that satisfy every joint, (n,), and their total design derivatives (n, n_x)."""

    q: np.ndarray
    v: np.ndarray
    dq: np.ndarray
    dv: np.ndarray


def consistent_start(
    system: System,
    levels: np.ndarray,
    q: np.ndarray | None = None,
    v: np.ndarray | None = None,
    time: float = 0.0,
    options: RunOptions | None = None,
) -> State:
    """Consistent state at the start; `q` and `v` (n_q,) replace the scene's own start.

    Such a replaced start has no design derivatives.

    Velocities that the scene writes hold, the others are found, see `start_velocities`; a given `v` has to fit the joints as it is.
    Positions are moved to where the joints are closed if `options.assemble` (by default the scene's), see `assembly`.

    Raises
    ------
    InputError
        A joint is violated at the start, or moving a design variable would violate it; or velocities contradict the joints.
    ConvergenceError
        The joints do not close near the given positions.
    SingularSystemError
        Joints are redundant, so that accelerations or multipliers are not unique.
    """
    return with_accelerations(system, levels, *consistent_motion(system, q, v, time, options), time)


def consistent_motion(
    system: System, q: np.ndarray | None, v: np.ndarray | None, time: float, options: RunOptions | None = None
) -> ConsistentMotion:
    """Coordinates and velocities of `consistent_start`, with their design derivatives."""
    position, _, dq, _ = system.start()
    if q is not None:
        position, dq = _padded(system, q), np.zeros_like(dq)
    position, dq = closed(system, position, dq, time, options)
    return moving(system, position, dq, v, time)


def moving(
    system: System, position: np.ndarray, dq: np.ndarray, v: np.ndarray | None = None, time: float = 0.0
) -> ConsistentMotion:
    """Motion in positions (n,) where every joint is closed, from these and their design derivatives (n, n_x)."""
    velocity, dv = _velocities(system, position, dq, v, time)
    return ConsistentMotion(position, velocity, dq, dv)


def with_accelerations(
    system: System, levels: np.ndarray, q: np.ndarray, v: np.ndarray, dq: np.ndarray, dv: np.ndarray, time: float = 0.0
) -> State:
    """State of coordinates and velocities (n,) that satisfy every joint, with their design derivatives (n, n_x)."""
    v, dv = rates_of_states(system, q, dq, v, dv, time)
    acc, dacc = initial_accelerations(system, q, v, dq, dv, levels, time)
    return State(q, v, acc, dq, dv, dacc)


def closed(
    system: System, position: np.ndarray, dq: np.ndarray, time: float, options: RunOptions | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Positions that satisfy every joint, next to positions (n,) with design derivatives (n, n_x), and their derivatives."""
    if (options or system.scene.solver).assemble:
        position, dq = assemble(system, position, dq, time)
    check_positions(system, position, dq, time)
    return position, dq


def _velocities(
    system: System, q: np.ndarray, dq: np.ndarray, own: np.ndarray | None, time: float
) -> tuple[np.ndarray, np.ndarray]:
    """Velocities that satisfy every joint, (n,), and their design derivatives (n, n_x)."""
    if own is None:
        v, dv = carried_along(system, q, *system.start()[1::2], dq)
        return project_velocities(system, q, v, dq, dv, time, written_velocities(system))
    given = _padded(system, own)
    found, dfound = project_velocities(system, q, given, dq, np.zeros_like(dq), time)
    refuse_own_velocities(system, given, found)
    return found, dfound


def rates_of_states(
    system: System, q: np.ndarray, dq: np.ndarray, v: np.ndarray, dv: np.ndarray, time: float
) -> tuple[np.ndarray, np.ndarray]:
    """Velocities with those of the loads' own states x, which follow from their laws, and design derivatives (n, n_x)."""
    states = system.numbering.states
    if not len(states):
        return v, dv
    terms = system.evaluate(system.inputs(time, np.zeros(3)), q, v, np.zeros_like(q), design=True)
    v, dv, change = v.copy(), dv.copy(), total_change(system, terms, dq, dv)
    v[states] -= terms.applied[states]
    dv[states] -= np.real(change[states])
    return v, dv


def _padded(system: System, given: np.ndarray) -> np.ndarray:
    if np.shape(given) != (system.n_q,):
        raise InputError(f"a start has the shape ({system.n_q},), one number per coordinate, not {np.shape(given)}.")
    return np.concatenate([given, np.zeros(system.n - system.n_q)]).astype(system.dtype)


def check_positions(system: System, q: np.ndarray, dq: np.ndarray, time: float) -> None:
    """Refuse a start q (n,) that violates a joint, or whose design derivative dq (n, n_x) does.

    Raises
    ------
    InputError
        Names the joint, and the design variable.
    """
    zero, n_q = np.zeros_like(q), system.n_q
    terms, by_design = system.evaluate_touched(system.inputs(time, np.array([0, 0, 1.0])), q, zero, zero)
    names = system.numbering.names
    violated = np.flatnonzero(np.abs(terms.applied[n_q:]) * system.weights[n_q:] > POSITION_TOLERANCE)
    if len(violated):
        i = n_q + violated[0]
        raise InputError(
            f"inconsistent start: {names[i]} is violated by {told(system, int(i), terms.applied[i])} at t = {time:g}. "
            "Give positions that satisfy every joint, or a length, offset or curve that starts at their value; or let "
            "solver.assemble = true close the joints."
        )
    violating = _violating(system, terms, by_design, dq)
    for i, x in violating:
        raise NoDerivativeError(
            f"design variable {system.design.names[x]!r} would violate {names[n_q + i]} at the start while the positions stay. "
            "Choose a variable that moves the points with it (a point, or leave the length to follow the points), or let "
            "solver.assemble = true move the bodies with it.",
            tuple(system.design.names[other] for other in np.unique(violating[:, 1])),
        )


def _violating(system: System, terms: Terms, by_design: np.ndarray, dq: np.ndarray) -> np.ndarray:
    """Constraints and variables that would violate them, (k, 2), by constraints.

    `by_design` is as `System.evaluate_touched` finds it.

    Some variables at a time, because new memory for many takes longer than all else.
    """
    plan, n_q, found = system.plan, system.n_q, [np.zeros((0, 2), np.int64)]
    for first in range(0, system.n_x, VARIABLES_AT_ONCE):
        moved = dq[:, first : first + VARIABLES_AT_ONCE]
        own = (plan.touched_row >= n_q) & (plan.touched_variable // VARIABLES_AT_ONCE == first // VARIABLES_AT_ONCE)
        change: np.ndarray = np.zeros((system.n - n_q, moved.shape[1]), system.dtype)
        change[plan.touched_row[own] - n_q, plan.touched_variable[own] - first] = by_design[own]
        sizes = np.abs(change + system.times(terms.A_q, moved, n_q) if np.any(moved) else change)
        if sizes.max(initial=0) > POSITION_TOLERANCE:
            largest = max(dq.max(initial=0), -dq.min(initial=0))
            found.append(np.argwhere(sizes > POSITION_TOLERANCE * (1 + largest)) + np.array([0, first]))
    places = np.concatenate(found)
    return places[np.argsort(places[:, 0], kind="stable")]


def initial_accelerations(
    system: System, q: np.ndarray, v: np.ndarray, dq: np.ndarray, dv: np.ndarray, levels: np.ndarray, time: float
) -> tuple[np.ndarray, np.ndarray]:
    """[a; lam] of the equations at the start, which are linear in them, (n,), and their design derivatives, (n, n_x).

    States of loads have no mass, and start without acceleration: the first step's error of that is of the order of the scheme.

    Raises
    ------
    SingularSystemError
        Joints are redundant, or something has no mass.
    """
    inputs = system.inputs(time, levels)
    terms = system.evaluate(inputs, q, v, np.zeros_like(q))
    acc = solve_linear(system, terms.I_acc + system.unit_of_states, -(terms.inertial + terms.applied), ACCELERATIONS)
    if not system.n_x:
        return acc, np.zeros_like(dq)
    terms = system.evaluate(inputs, q, v, acc, design=True)
    mass = terms.I_acc + system.unit_of_states
    return acc, solve_linear(system, mass, -total_change(system, terms, dq, dv), ACCELERATIONS)


ACCELERATIONS = "initial accelerations"


def total_change(system: System, terms: Terms, dq: np.ndarray, dv: np.ndarray) -> np.ndarray:
    """Derivative of the residual by the design at constant [a; lam], through coordinates, velocities and explicitly, (n, n_x)."""
    change: np.ndarray = terms.I_x + terms.A_x
    if np.any(dv):
        change = system.times(terms.A_v, dv) + change
    return system.times(terms.I_q + terms.A_q, dq) + change if np.any(dq) else change


LARGEST_CLOSING_MOVE = 10.0
"""Times `solver.drift_tolerance` that coordinates may move: closing a joint by a little can take a larger motion."""
VELOCITY_TOLERANCE = 0.05
"""Part of the largest velocity by which one may be off those that the joints allow: what coarse steps leave."""
AGAIN = (
    "A motion with a start begins at t = 0 again, and so do its time curves: give the drivers curves that begin where the start is, and "
    "the same geometry."
)


def continued_start(system: System, q: np.ndarray, v: np.ndarray, options: RunOptions) -> tuple[np.ndarray, np.ndarray, float]:
    """Coordinates and velocities (n_q,) next to given ones that satisfy every joint at t = 0, and how far coordinates moved for it.

    Raises
    ------
    InputError
        As `closed_start`.
    """
    still = np.zeros((system.n, system.n_x))
    found = closed_start(system, q, v, still, still, options)
    return found.q[: system.n_q], found.v[: system.n_q], moved_by(system, q, found.q)


def moved_by(system: System, q: np.ndarray, found: np.ndarray) -> float:
    """Largest move of coordinates (n_q,) to where they were found, (n_q,) or padded, in parts of the model size or in rad."""
    n_q = system.n_q
    return float(np.max(system.weights[:n_q] * np.abs(np.real(found[:n_q] - q)), initial=0.0))


def closed_start(
    system: System, q: np.ndarray, v: np.ndarray, dq: np.ndarray, dv: np.ndarray, options: RunOptions
) -> ConsistentMotion:
    """Motion that satisfies every joint at t = 0 next to given coordinates and velocities (n_q,) with derivatives (n, n_x).

    Raises
    ------
    InputError
        The joints are not where the state is, by more than ten times `solver.drift_tolerance`: it belongs to other numbers, or
        a driver begins elsewhere than it has led to.
    """
    n_q, free = system.n_q, np.zeros(system.n - system.n_q)
    try:
        given: np.ndarray = np.concatenate([q, free]).astype(system.dtype)
        position, dposition = closed(system, given, dq, 0.0, options.model_copy(update={"assemble": True}))
    except ConvergenceError as error:
        raise InputError(f"the start is off the joints of this scene at t = 0: {error} {AGAIN}") from error
    velocity, dvelocity = project_velocities(system, position, np.concatenate([v, free]).astype(system.dtype), dposition, dv, 0.0)
    weights, moved = system.weights[:n_q], moved_by(system, q, position)
    largest = float(np.max(weights * np.abs(v), initial=0.0))
    changed = float(np.max(weights * np.abs(velocity[:n_q] - v), initial=0.0))
    slow = options.drift_tolerance / options.end_time  # of a scene that rests, whose velocities are round-off
    if moved > LARGEST_CLOSING_MOVE * options.drift_tolerance or changed > VELOCITY_TOLERANCE * max(largest, slow):
        raise InputError(
            f"the start is off the joints of this scene at t = 0: by {moved:.1e} of the model size in position, by {changed:.1e} of "
            f"it per unit of time in velocity, of at most {largest:.1e}. {AGAIN}"
        )
    return ConsistentMotion(position, velocity, dposition, dvelocity)
