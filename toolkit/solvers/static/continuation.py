"""From an equilibrium to the full load along the path of equilibria, limit points on it, and the load margin.

At a limit point the static matrix K has a left null vector psi. With the residual R(q, lam, factor; x) = 0 along all designs,

    psi^T (K d[q; lam] + R_factor dfactor + R_x dx) = 0,     dfactor/dx = - psi^T R_x / psi^T R_factor

so that neither the change of the state nor second derivatives are needed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import islice, pairwise
from typing import NamedTuple

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import (
    BifurcationError,
    ConvergenceError,
    CriticalPointError,
    LimitPointError,
    NoLimitPointError,
    SingularSystemError,
)
from toolkit.foundation.value_types import Scalar
from toolkit.solvers.static.critical_state import is_stable, soft_motion, softest_motion
from toolkit.solvers.static.equilibrium import Equilibrium, find_equilibrium, inputs_at
from toolkit.solvers.static.path_equations import GrowingLoads, PathEquations, parts
from toolkit.solvers.static.path_steps import Arc, Corrected, arcs, correct, first_point, measure
from toolkit.system.solution import LimitPoint, StaticPath
from toolkit.system.system import System

ARC_TOLERANCE = 1e-12
"""Part of an arc to which a place on it is found; at a limit point the load is exact to the square of it."""
LARGEST_CUBIC_CORRECTION = 0.1
"""Part of an arc by which Newton may correct a point of the cubic through its ends."""
FULL_LOAD = 1 - 1e-12
"""Load factor that is the full load to round-off."""


class PathPlace(NamedTuple):
    """Point z of the path by its distance from the beginning of an arc, across its planes, and dz by that distance."""

    length: float
    z: np.ndarray
    slope: np.ndarray

    @property
    def loaded(self) -> bool:
        """Whether the point bears the full load, or more."""
        return bool(self.z[-1] >= FULL_LOAD)


def ends(arc: Arc) -> tuple[PathPlace, PathPlace]:
    """Places at both ends of an arc."""
    cubic = arc.cubic
    return PathPlace(0.0, cubic.begin, cubic.begin_slope), PathPlace(arc.length, cubic.end, cubic.end_slope)


def limit_point(equations: PathEquations, arc: Arc) -> PathPlace | None:
    """Place of an arc where the load turns back, None without one; about that of an arc that is too short to look into."""
    if not arc.turns:
        return None
    if arc.branching:
        return ends(arc)[1]._replace(length=arc.length / 2)
    return _where(equations, arc, *ends(arc), _rate)


def full_load(equations: PathEquations, arc: Arc, first: PathPlace, last: PathPlace) -> PathPlace | None:
    """Place between two of an arc where the load factor is one, if they lie on both sides of it."""
    if first.loaded == last.loaded:
        return None
    near = [place for place in (first, last) if abs(place.z[-1] - 1) <= 1 - FULL_LOAD]
    return near[0] if near else _where(equations, arc, first, last, _missing_load)


def _rate(place: PathPlace) -> float:
    return float(place.slope[-1])


def _missing_load(place: PathPlace) -> float:
    return float(place.z[-1] - 1)


def _where(
    equations: PathEquations, arc: Arc, first: PathPlace, last: PathPlace, vanishing: Callable[[PathPlace], float]
) -> PathPlace:
    found = {first.length: first, last.length: last}

    def value(length: float) -> float:
        if length not in found:
            found[length] = _place(equations, arc, length)
        return vanishing(found[length])

    from scipy.optimize import brentq  # for limit points alone: it takes longer to import than a wing to solve

    length = brentq(value, first.length, last.length, xtol=ARC_TOLERANCE * arc.length, rtol=ARC_TOLERANCE)
    value(length)
    return found[length]


def _place(equations: PathEquations, arc: Arc, length: float) -> PathPlace:
    """Place on the path at a distance across the planes of an arc, to round-off."""
    cubic = arc.cubic
    allowed = LARGEST_CUBIC_CORRECTION * measure(equations, cubic.end - cubic.begin)
    point: Corrected = correct(equations, arc.border, cubic.at(length), allowed, exact=True)
    return PathPlace(length, point.z, point.crossing.ahead())


FULL_LOAD_MOVE = 1e-6
"""Distance, in parts of the model size (or rad), that Newton may move a point of the path that is under the full load to
round-off."""

LEAST_LOAD_GROWTH = 1e-6
"""Part of the path's way by which the load grows at least; its square is the part of the load by which a limit point is missed."""


class Arrival(NamedTuple):
    """Equilibrium under the full load, with the path from the first one, and what it cost."""

    state: Equilibrium
    path: StaticPath
    iterations: int
    steps: int


@dataclass
class Trail:
    """Record of the path so far: points z (n + 1,), limit points, unstable equilibria under the full load."""

    points: list[np.ndarray]
    limits: list[LimitPoint] = field(default_factory=list)
    unstable: int = 0
    iterations: int = 0

    def path(self, n_q: int) -> StaticPath:
        """Path of equilibria through the points so far."""
        points = np.array(self.points)
        return StaticPath(points[:, -1], points[:, :n_q], points[:, n_q:-1], tuple(self.limits), self.unstable)


def to_full_load(
    system: System,
    options: RunOptions,
    state: Equilibrium,
    factor: float,
    past_limits: bool,
    progress: Callable[[int, int], None] | None = None,
) -> Arrival:
    """Follow the path from a stable equilibrium to the first stable one under the full load.

    Raises
    ------
    LimitPointError
        The load turns back before, and the path is not to be followed past limit points.
    BifurcationError
        The path is unstable before its first limit point.
    ConvergenceError
        The path ends, or does not come to a stable equilibrium in `options.path_steps` steps.
    """
    equations = PathEquations(system, options, GrowingLoads(system, options))
    trail = Trail([np.real(np.concatenate([state.q[: system.n_q], state.acc[system.n_q :], [factor]]))])
    if factor >= FULL_LOAD:
        return Arrival(state, trail.path(system.n_q), 0, 0)
    start = first_point(equations, trail.points[0])
    for step, arc in enumerate(islice(arcs(equations, start, 1.0 / options.load_steps), options.path_steps), 1):
        trail.iterations += arc.iterations
        if arc.branching and not arc.turns and not trail.limits:
            here = Equilibrium(*equations.padded(arc.begin.z), arc.begin.direction)
            raise bifurcation(system, arc.begin.factor, soft_motion(system, options, here, arc.begin.factor))
        for begin, end in pairwise(_places(equations, arc)):
            crossing = full_load(equations, arc, begin, end)
            found = _stable_end(equations, trail, crossing) if crossing else None
            if crossing and found:
                trail.points.append(np.append(crossing.z[:-1], 1.0))
                return Arrival(found, trail.path(system.n_q), trail.iterations, step)
            trail.points.append(end.z)
            if end.length < arc.length:
                _add_limit(system, trail, end, past_limits)
        if progress:
            progress(min(99, round(100 * max(point[-1] for point in trail.points))), 100)
    raise _no_arrival(options, trail)


def _stable_end(equations: PathEquations, trail: Trail, place: PathPlace) -> Equilibrium | None:
    """Point of the path under the full load, to round-off, if it is stable."""
    system, options = equations.system, equations.options
    q, acc = equations.padded(place.z)
    try:
        state, count = find_equilibrium(system, options, 1.0, q, acc, FULL_LOAD_MOVE)
    except ConvergenceError as error:
        if place.slope[-1] > 0 and not _turns_here(equations, trail, q, place.slope / place.slope[-1]):
            raise _rounded_off(options, error) from error
        raise _critical_full_load(system, place, error) from error
    except SingularSystemError as error:
        raise _critical_full_load(system, place, error) from error
    trail.iterations += count
    if _turns_here(equations, trail, state.q, state.tangent):
        raise _critical_full_load(system, place, "the smallest load more would move it far")
    if is_stable(system, options, state, 1.0):
        return state
    trail.unstable += 1
    return None


def _add_limit(system: System, trail: Trail, place: PathPlace, past_limits: bool) -> None:
    """Add the last point as a limit point; the first one is refused if nobody asked to pass it."""
    trail.limits.append(LimitPoint(float(place.z[-1]), system.most_moved(place.slope), len(trail.points) - 1))
    if not past_limits:
        raise _end_of_path(trail.limits[0])


def _places(equations: PathEquations, arc: Arc) -> list[PathPlace]:
    """Beginning and end of an arc, and the limit point between them."""
    (first, last), limit = ends(arc), limit_point(equations, arc)
    return [first, *([limit] if limit else []), last]


def _end_of_path(limit: LimitPoint) -> LimitPointError:
    return LimitPointError(
        f"the static path ends at {limit.percent} of the load at a limit point (snap-through): more load finds no "
        f"equilibrium nearby, and {limit.coordinate} runs away. Stay below with a smaller load, follow the snap with a transient run in "
        'fine steps, or follow the path past it with solver.continuation = "arc-length" (ffrf statics --past-limit).',
        limit.load_factor,
        limit.coordinate,
    )


def _turns_here(equations: PathEquations, trail: Trail, q: np.ndarray, tangent: np.ndarray) -> bool:
    """Whether the load grows by nothing but round-off along the path, whose direction is dq by its factor, compared with the way so far."""
    n_b = equations.system.n_b
    way = np.real(np.ptp([*np.array(trail.points)[:, :n_b], np.real(q[:n_b])], axis=0))
    weights = equations.system.weights[:n_b]
    return bool(LEAST_LOAD_GROWTH * parts(weights * np.real(tangent[:n_b]), weights * way) >= 1)


def _rounded_off(options: RunOptions, error: Exception) -> ConvergenceError:
    return ConvergenceError(
        f"round-off keeps statics from an equilibrium under the full load to solver.tolerance = {options.tolerance:g} ({error}). Nothing "
        "is critical there, the path goes on: the scene is too stiff for so small a tolerance, as a skin of very short elements is. Use "
        "fewer elements or a reduced basis, or a tolerance above that correction."
    )


def _critical_full_load(system: System, place: PathPlace, error: Exception | str) -> CriticalPointError:
    coordinate = system.most_moved(place.slope)
    return CriticalPointError(
        f"the full load is that of a limit point or bifurcation to round-off, where nothing holds {coordinate} ({error}). Use a little "
        "less load.",
        float(place.z[-1]),
        coordinate,
    )


def _no_arrival(options: RunOptions, trail: Trail) -> ConvergenceError:
    passed = ", ".join(limit.percent for limit in trail.limits) or "none"
    return ConvergenceError(
        f"the path of equilibria meets no stable one under the full load in {options.path_steps} steps: limit points at {passed} of "
        f"the load, {trail.unstable} unstable equilibria under the full load, and it goes on at {100 * trail.points[-1][-1]:.6g} %. "
        "Raise solver.path_steps, use less load, or follow the motion with a transient run."
    )


def bifurcation(system: System, factor: float, motion: np.ndarray) -> BifurcationError:
    """Error of a bifurcation at a critical load, with the motion (n,) that loses its stiffness.

    At a limit point the stiffness vanishes against a motion on which the load does work, so that the load turns back. Where it vanishes
    while the load goes on, the load does no work on the motion: other branches of equilibria begin there.
    """
    coordinate = system.most_moved(motion)
    return BifurcationError(
        f"the equilibrium is unstable beyond a bifurcation (buckling) at {100 * factor:.6g} % of the load: the load does no work on a "
        f"motion of {coordinate}, which loses its stiffness there, and the smallest disturbance sets it off. Use less "
        "load, add stiffness there, or follow the motion with a transient run from a slightly disturbed start.",
        factor,
        coordinate,
    )


def next_limit_point(system: System, options: RunOptions, begin: np.ndarray, up_to: float) -> np.ndarray:
    """First limit point z = [q; lam; factor] on the path of equilibria beyond a stable one.

    Raises
    ------
    BifurcationError
        The path loses its stability at a bifurcation before.
    NoLimitPointError
        There is no limit point below the load factor `up_to`, or in `options.path_steps` steps.
    """
    equations = PathEquations(system, options, GrowingLoads(system, options))
    factor = float(begin[-1])
    for arc in islice(arcs(equations, first_point(equations, begin), 1.0 / options.load_steps), options.path_steps):
        place = limit_point(equations, arc)
        if place is not None:
            return place.z
        if arc.branching:
            here = Equilibrium(*equations.padded(arc.begin.z), arc.begin.direction)
            raise bifurcation(system, arc.begin.factor, soft_motion(system, options, here, arc.begin.factor))
        factor = arc.end.factor
        if factor > up_to:
            break
    raise NoLimitPointError(
        f"the path of equilibria has no limit point up to {factor:.4g} times the load: nothing snaps through there. Raise `up_to` (and "
        "solver.path_steps), or leave the load margin out.",
        factor,
    )


def factor_of_limit_point(system: System, options: RunOptions, z: np.ndarray) -> tuple[Scalar, np.ndarray]:
    """Load factor at a limit point z (n + 1,) and its design derivatives (n_x,).

    The limit point is that of the real parts of the system's numbers.

    Of a system with a complex step the factor follows that step.
    """
    equations = PathEquations(system, options, GrowingLoads(system, options))
    residual, matrix = equations.linearised(z)
    left = softest_motion(system, matrix.T)[1]
    left = left / (left @ equations.load(z, residual))
    q, acc = equations.padded(z)
    terms = system.evaluate(inputs_at(system, options, float(z[-1])), q, np.zeros_like(q), acc, design=True)
    value = z[-1] - left @ (terms.inertial + terms.applied)
    return value, -left @ np.real(terms.I_x + terms.A_x)
