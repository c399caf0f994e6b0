"""A start in the last state of another run, whose joints are closed as well as its steps have kept them."""

from __future__ import annotations

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ConvergenceError, InputError
from toolkit.solvers.start.initial_conditions import Motion, closed
from toolkit.solvers.start.start_velocities import project_velocities
from toolkit.system.system import System

MOVED = 10.0
"""Times `solver.drift_tolerance` that coordinates may move: closing a joint by a little can take a larger motion."""
CHANGED = 0.05
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


def closed_start(system: System, q: np.ndarray, v: np.ndarray, dq: np.ndarray, dv: np.ndarray, options: RunOptions) -> Motion:
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
    if moved > MOVED * options.drift_tolerance or changed > CHANGED * max(largest, slow):
        raise InputError(
            f"the start is off the joints of this scene at t = 0: by {moved:.1e} of the model size in position, by {changed:.1e} of "
            f"it per unit of time in velocity, of at most {largest:.1e}. {AGAIN}"
        )
    return Motion(position, velocity, dposition, dvelocity)
