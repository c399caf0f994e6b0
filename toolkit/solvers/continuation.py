"""From an equilibrium to the full load along the path of equilibria, up to a limit point or past it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import islice, pairwise
from typing import NamedTuple

import numpy as np

from toolkit.errors import ConvergenceError, CriticalPointError, LimitPointError, SingularSystemError
from toolkit.run_options import RunOptions
from toolkit.solvers.arc_length import Arc, PathPoint, arcs, first_point
from toolkit.solvers.bifurcation import bifurcation
from toolkit.solvers.critical_state import is_stable
from toolkit.solvers.equilibrium import Equilibrium, find_equilibrium
from toolkit.solvers.limit_points import Place, full_load, limit_point
from toolkit.static_path import LimitPoint, StaticPath
from toolkit.system import System

NEAR = 1e-6
"""How far, in parts of the scene's size (or rad), Newton may move a point of the path that is under the full load to round-off."""


class Arrival(NamedTuple):
    """The equilibrium under the full load, the path from the first one, and what it cost."""

    state: Equilibrium
    path: StaticPath
    iterations: int
    steps: int


@dataclass
class Trail:
    """What was met on the path so far."""

    points: list[PathPoint]
    limits: list[LimitPoint] = field(default_factory=list)
    unstable: int = 0
    iterations: int = 0

    def path(self, system: System, *end: PathPoint) -> StaticPath:
        """The points so far, and an end."""
        points, n_q = [*self.points, *end], system.n_q
        q, multipliers = np.array([point.q[:n_q] for point in points]), np.array([point.acc[n_q:] for point in points])
        return StaticPath(np.array([point.factor for point in points]), q, multipliers, tuple(self.limits), self.unstable)


def to_full_load(
    system: System,
    options: RunOptions,
    state: Equilibrium,
    factor: float,
    past_limits: bool,
    progress: Callable[[int, int], None] | None = None,
) -> Arrival:
    """Follow the path to the first stable equilibrium under the full load.

    Raises
    ------
    LimitPointError
        The load turns back before, and the path is not to be followed past limit points.
    BifurcationError
        The path is unstable before its first limit point.
    ConvergenceError
        The path ends, or does not come to a stable equilibrium in `options.path_steps` steps.
    """
    trail = Trail([first_point(system, state.q, state.acc, factor, state.tangent)])
    first_length = 1.0 / (options.load_steps * trail.points[0].rate)
    for step, arc in enumerate(islice(arcs(system, options, trail.points[0], first_length), options.path_steps), 1):
        trail.iterations += arc.iterations
        for begin, end in pairwise(_places(system, options, arc)):
            crossing = full_load(system, options, arc, begin, end)
            found = _stable_end(system, options, trail, crossing.point) if crossing else None
            if crossing and found:
                path = trail.path(system, crossing.point._replace(factor=1.0))
                return Arrival(found, path, trail.iterations, step)
            trail.points.append(end.point)
            if end.point is not arc.end:
                _add_limit(system, options, trail, past_limits)
        if progress:
            progress(min(99, round(100 * max(point.factor for point in trail.points))), 100)
    raise _no_arrival(options, trail)


def _stable_end(system: System, options: RunOptions, trail: Trail, point: PathPoint) -> Equilibrium | None:
    """A point of the path under the full load, to round-off, if it is stable; a path that lost its stability without limit is refused."""
    q: np.ndarray = point.q.astype(system.dtype)
    acc: np.ndarray = point.acc.astype(system.dtype)
    try:
        state, count = find_equilibrium(system, options, 1.0, q, acc, NEAR)
    except (ConvergenceError, SingularSystemError) as error:
        raise _critical_full_load(system, point, error) from error
    trail.iterations += count
    if is_stable(system, options, state, 1.0):
        return state
    trail.unstable += 1
    if not trail.limits:
        raise bifurcation(system, options, trail.path(system, point)) or _no_arrival(options, trail)
    return None


def _add_limit(system: System, options: RunOptions, trail: Trail, past_limits: bool) -> None:
    """The last point is a limit point; the first one is refused if nobody asked to pass it, or if the path was unstable before."""
    *_, before, last = trail.points
    trail.limits.append(LimitPoint(last.factor, system.most_moved(last.direction), len(trail.points) - 1))
    if len(trail.limits) > 1:
        return
    state = Equilibrium(before.q.astype(system.dtype), before.acc.astype(system.dtype), before.direction[:-1])
    if not is_stable(system, options, state, before.factor):
        raise bifurcation(system, options, trail.path(system)) or _end_of_path(trail.limits[0])
    if not past_limits:
        raise _end_of_path(trail.limits[0])


def _places(system: System, options: RunOptions, arc: Arc) -> list[Place]:
    """Beginning and end of an arc, and the limit point between them."""
    limit = limit_point(system, options, arc)
    return [Place(0.0, arc.begin), *([limit] if limit else []), Place(arc.length, arc.end)]


def _end_of_path(limit: LimitPoint) -> LimitPointError:
    return LimitPointError(
        f"the static path ends at {limit.percent} of the load at a limit point (snap-through): more load finds no "
        f"equilibrium nearby, and {limit.coordinate} runs away. Stay below with a smaller load, follow the snap with a transient run in "
        'fine steps, or follow the path past it with solver.continuation = "arc-length" (ffrf statics --past-limit).',
        limit.load_factor,
        limit.coordinate,
    )


def _critical_full_load(system: System, point: PathPoint, error: Exception) -> CriticalPointError:
    coordinate = system.most_moved(point.direction)
    return CriticalPointError(
        f"the full load is that of a limit point or bifurcation to round-off, where nothing holds {coordinate} ({error}). Use a little "
        "less load.",
        point.factor,
        coordinate,
    )


def _no_arrival(options: RunOptions, trail: Trail) -> ConvergenceError:
    passed = ", ".join(limit.percent for limit in trail.limits) or "none"
    return ConvergenceError(
        f"the path of equilibria meets no stable one under the full load in {options.path_steps} steps: limit points at {passed} of "
        f"the load, {trail.unstable} unstable equilibria under the full load, and it goes on at {100 * trail.points[-1].factor:.6g} %. "
        "Raise solver.path_steps, use less load, or follow the motion with a transient run."
    )
