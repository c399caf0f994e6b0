"""Motions that hold because nothing disturbs them: tops, spins about a middle axis, upright pendulums, sudden loads.

Free rigid bodies that spin about the axis of their middle moment of inertia: what turns them over is hardly there at the start.

With the principal moments I_1 < I_2 < I_3 a spin omega about the second axis is unstable, and a small part of it across grows as

    exp(omega t sqrt((I_2 - I_1) (I_3 - I_2) / (I_1 I_3)))

A part that is written as zero, or as 1e-12, grows from round-off, or nearly so: nothing that is meant decides when the body turns over.

The motion q(t) of a scene stays in a subspace, often one of symmetry, whose complement P holds all directions in which nothing has moved.
A disturbance there follows the equations, linearised about the states of the run,

    M y'' + C y' + K y + J^T mu = 0,    J y = 0,    P y(0) = y(0)

by the theta rule with theta = 0.51, which the fast vibrations do not survive that steps do not show. How large P y becomes tells how much
of the motion is decided by round-off.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from toolkit.components.bodies.body import QUATERNION, Body
from toolkit.components.bodies.rigid import SpatialRigidBody
from toolkit.description.run_options import RunOptions
from toolkit.foundation.kinematics.orientation import angular_velocity
from toolkit.foundation.near_ties import first_largest, spread
from toolkit.foundation.verdict import MOTION, Caution, check
from toolkit.responses.flutter import UNSTABLE
from toolkit.scene.scene import Scene
from toolkit.solvers.free_motions import free_motions
from toolkit.solvers.static.equilibrium import LEVELS, static_matrix
from toolkit.system.solution import Solution, deforming
from toolkit.validity.components import told_frictions

MOST_NAMED = 3
"""Largest number of loads, and of times, that one sentence names."""


def sudden_loads(scene: Scene) -> list[str]:
    """Names of the loads that a motion meets at t = 0 and whose size is written: forces, torques, pressures, gravity."""
    return [name for name, load in scene.loads.items() if any(_written(load)) and _at_start(load) != 0]


def _written(load) -> Iterator[bool]:
    """Whether each field that a load is proportional to is not zero."""
    return (bool(np.any(np.real(getattr(load, field)) != 0)) for field in load.proportional)


def _at_start(load) -> float:
    """Value of a load's time curve at t = 0; one without a curve."""
    curve = getattr(load, "curve", None)
    return 1.0 if curve is None else float(np.real(curve.evaluate(np.zeros(1))[0, 0]))


def told_loads(scene: Scene, options: RunOptions) -> str:
    """Sentences on loads that begin at once at t = 0; empty where none does, or a motion starts in their equilibrium."""
    names = sudden_loads(scene)
    if not names or options.start != "given" or options.quasi_static:
        return ""
    more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
    return (
        f"At t = 0 {', '.join(map(repr, names[:MOST_NAMED]))}{more} {'sets' if len(names) == 1 else 'set'} in at once, with a blow. "
        'solver.start = "equilibrium" begins in the equilibrium under the loads at t = 0; or let them grow by a curve.'
    )


def _padded(solution: Solution) -> np.ndarray:
    """Coordinates (n,) of the start, with zeros for the multipliers."""
    return np.append(np.real(solution.q[0]), np.zeros(solution.system.n - solution.system.n_q))


@check("halved-steps", (MOTION,))
def halved_steps(solution: Solution) -> Iterator[Caution]:
    """Steps in which Newton did not converge, or that threw the joints open, were taken in halves; gradients are those of these steps.

    Limit: any.
    Fix: a smaller `solver.step`; `solver.start = "equilibrium"` or a load curve where loads set in at t = 0; a wider friction.
    """
    if not solution.halved:
        return
    options = solution.options or solution.system.scene.solver
    lengths, count = np.diff(solution.whole_run), len(solution.halved)
    when = ", ".join(f"{time:.4g}" for time in solution.halved[:MOST_NAMED])
    more = f" and {count - MOST_NAMED} more" if count > MOST_NAMED else ""
    why = told_loads(solution.system.scene, options) if solution.halved[0] == 0 and not solution.own_start else ""
    why = told_frictions(solution.system, _padded(solution), float(lengths.max())) or why
    yield halved_steps.caution(
        f"{count} {'step was' if count == 1 else 'steps were'} halved, because Newton did not converge in a whole one: at "
        f"t = {when}{more}. "
        f"{solution.steps} steps were taken, from {lengths.min():.2g} to {lengths.max():.2g}; gradients are those of these steps. "
        f"{why or 'Fix: a smaller solver.step.'}",
        doubt=False,
    )


INTENDED_SPIN = 1e-6
"""Part of a spin across its axis from which it is taken as meant: round-off is a tenth of a billionth of it."""
SMALL_SPIN_ACROSS = 0.1
"""Part of the spin across the axis up to which the growth is that of a small one."""


@check("middle-axis", each_design=True)
def middle_spins(solution: Solution) -> Iterator[Caution]:
    """A free rigid body spins about the axis of its middle moment of inertia, and what turns it over is as small as round-off.

    Limit: growth by 100, and less than 1e-6 of the spin across the axis at the start.
    Fix: a disturbance that is meant in the body's `angular_velocity`, such as a thousandth of it.
    """
    scene = solution.system.scene
    held = {body for joint in scene.joints.values() for body, _ in joint.grips}
    for name, body in scene.bodies.items():
        if isinstance(body, SpatialRigidBody) and name not in held and body.turns == QUATERNION:
            aside, growth = _growth(solution, name, body)
            if aside < INTENDED_SPIN and growth > np.log(DOUBTED_GROWTH):
                yield middle_spins.caution(
                    f"{name} spins about the axis of its middle moment of inertia. A disturbance grows {np.exp(growth):.2g} times in this "
                    f"motion, and {aside:.1g} of the spin lies across this axis at the start. Round-off decides whether and when it turns "
                    f"over. {middle_spins.fix}",
                )


def _growth(solution: Solution, name: str, body: SpatialRigidBody) -> tuple[float, float]:
    """Part of the spin that lies across the middle axis at the start, and the exponent by which it grows while it is small."""
    moments, axes = np.linalg.eigh(np.real(body.mass_properties(solution.system.scene)[2]))
    first, middle, last = moments.sum() - moments[::-1]
    where = solution.coordinates(name)
    turned = slice(where.start + body.moves, where.start + body.moves + QUATERNION)
    omega = angular_velocity(np.real(solution.q[:, turned]), np.real(solution.v[:, turned])) @ axes
    speed = np.linalg.norm(omega, axis=1)
    across = np.hypot(omega[:, 0], omega[:, 2])
    aside = np.divide(across, speed, out=np.ones(len(speed)), where=speed > 0)
    small = len(aside) if np.all(aside < SMALL_SPIN_ACROSS) else int(np.argmax(aside >= SMALL_SPIN_ACROSS))
    rate = speed * np.sqrt(max((middle - first) * (last - middle), 0.0) / (first * last)) if first > 0 else 0 * speed
    return float(aside[0]), float(np.trapezoid(rate[:small], solution.times[:small])) if small > 1 else 0.0


UNMOVED_PART = 1e-6
"""Move in a direction, relative to the model size or in rad, up to which nothing has moved there."""
DOUBTED_GROWTH = 100.0
"""Growth of a disturbance above which there is a doubt, as of other motions that hardly anything sets off."""
PARTS = (1.0, 0.5, 0.25)
"""Parts of the motion up to which its directions are examined: what round-off sets off has moved at the end."""
MOST_COORDINATES, MOST_STATES, DIRECTION_STATES = 60, 1000, 200
"""Largest number of coordinates of a scene that is examined, and of states (of longer motions every second or third one); and
number of states that directions are found from."""
TURN_PER_STATE = 0.25
"""Angle between two states, rad, from which on growth may be that of the steps: of a top just fast enough to stand a tilt seems to grow
four million times in 8 s with 0.63 rad in a step, and 1300 times with 0.31."""
STATES_PER_COORDINATE = 3
"""Least number of states per coordinate: fewer leave directions open by their number alone."""
SAMPLES, GOLDEN = 12, (5**0.5 - 1) / 2
"""Number of states in which the equations of disturbances are compared; spread by the golden section, in no step with
vibrations."""
IMPLICITNESS = 0.51
SOLUTION_RESIDUAL = 1e-6
"""Largest residual, relative to the right-hand side, of a solution where a matrix is regular."""


class Course(NamedTuple):
    """Largest growth of disturbances of unit size, the time at which it is reached, and the coordinate."""

    growth: float
    until: float
    coordinate: str
    resolved: bool = True


def undisturbed(solution: Solution) -> Iterator[Caution]:
    """A doubt about a motion in which nothing moves in a direction where a disturbance would grow."""
    found = largest_growth(solution)
    if found is not None and not found.resolved:
        yield Caution(
            UNSTABLE,
            "whether a small disturbance of this motion grows is not known: the states of these steps are too far apart for it. Fix: a "
            "smaller solver.step.",
            doubt=False,
        )
    elif found is not None and found.growth > DOUBTED_GROWTH:
        yield Caution(
            UNSTABLE,
            f"a small disturbance of this motion becomes {found.growth:.2g} times as large until t = {found.until:.4g}, most of all in "
            f"{found.coordinate}, and nothing sets it off there: round-off or symmetry decides when the motion leaves this way. Fix: write "
            "the disturbance that is meant into the start, a thousandth of the motion say.",
        )


def largest_growth(solution: Solution) -> Course | None:
    """Growth of disturbances in the first part of the motion in which it exceeds `DOUBTED_GROWTH`; None where it does not.

    Scenes with bodies that deform are not examined: their vibrations are. None stands for these and other unknown cases, too.
    """
    system, options = solution.system, solution.options or solution.system.scene.solver
    few = system.n_q == system.n_b <= MOST_COORDINATES and not deforming(system.scene)
    if not solution.steps or options.quasi_static or solution.run_times is not None or not few or not system.compiled:
        return None
    last, known = len(solution.times) - 1, 0
    for part in PARTS:
        end = int(part * last)
        if end < STATES_PER_COORDINATE * system.n_q:
            break
        still = _still(solution, end)
        begin = _disturbances(solution, still)
        look = begin.shape[1] > known and not _stays_small(solution, still, begin, end)
        course = _course(solution, still, begin, end) if look else None
        if course is not None and course.growth > DOUBTED_GROWTH:
            return course._replace(resolved=_turned(solution, end) <= TURN_PER_STATE)
        known = max(known, begin.shape[1])
    return None


def _turned(solution: Solution, end: int) -> float:
    """Largest angle by which a body turns from one looked-at state to the next."""
    bodies, first = solution.system.scene.bodies, solution.system.numbering.first
    states = np.real(solution.q[spread(end, MOST_STATES)])
    angles = [0.0]
    for name, body in bodies.items():
        if isinstance(body, Body):
            begin = first[name] + body.moves
            change = np.linalg.norm(np.diff(states[:, begin : begin + body.turns], axis=0), axis=1).max(initial=0.0)
            angles.append(change if body.turns == 1 else 2 * change)  # quaternions have half of the angle
    return float(max(angles))


def _still(solution: Solution, end: int) -> np.ndarray:
    """Orthonormal directions (n_q, n) of weighted coordinates in which nothing moves until a state."""
    moved = solution.q[spread(end, DIRECTION_STATES)] - solution.q[0]
    _, sizes, rows = np.linalg.svd(np.real(moved) * solution.system.weights[: solution.system.n_q])
    directions: np.ndarray = rows[np.count_nonzero(sizes > UNMOVED_PART) :].T
    return directions


def _disturbances(solution: Solution, still: np.ndarray) -> np.ndarray:
    """Motions (n_q, n) of unit size in still directions that joints leave free at the start."""
    system, n_q = solution.system, solution.system.n_q
    weights, rows = system.weights[:n_q], _matrices(solution, 0)[3]
    moving = np.eye(n_q) - still @ still.T
    free = free_motions(np.concatenate([rows / weights, moving]), np.ones(n_q)) if still.shape[1] else np.zeros((n_q, 0))
    found: np.ndarray = free / weights[:, None]
    return found


def _matrices(solution: Solution, n: int) -> tuple[np.ndarray, ...]:
    """Matrices M, C, K (n_q, n_q) and J (n_c, n_q) of the linearised equations about a state of a motion."""
    system, n_q = solution.system, solution.system.n_q
    q, v, acc = (np.zeros(system.n) for _ in range(3))
    q[:n_q], v[:n_q], acc[:n_q], acc[n_q:] = solution.q[n], solution.v[n], solution.a[n], solution.multipliers[n]
    terms = system.evaluate(system.inputs(float(solution.times[n]), LEVELS), q, v, acc)
    mass, damping, whole = (system.dense(each) for each in (terms.I_acc, terms.A_v, static_matrix(system, terms)))
    return mass[:n_q, :n_q], damping[:n_q, :n_q], whole[:n_q, :n_q], whole[n_q:, :n_q]


def _stays_small(solution: Solution, still: np.ndarray, begin: np.ndarray, end: int) -> bool:
    """Whether disturbances have equations of their own that are equal in some states and let nothing grow: then all is known."""
    weights = solution.system.weights[: solution.system.n_q]
    seen = []
    for n in (int(end * (GOLDEN * k % 1.0)) for k in range(SAMPLES)):
        *matrices, rows = _matrices(solution, n)
        forces = [each @ begin for each in matrices]
        moving = [(each / weights[:, None]) - still @ (still.T @ (each / weights[:, None])) for each in forces]
        scale = max(float(np.abs(each / weights[:, None]).max()) for each in forces)
        if (
            max(float(np.abs(each).max()) for each in moving) > UNMOVED_PART * scale
            or np.abs(rows @ begin).max(initial=0.0) > UNMOVED_PART
        ):
            return False
        seen.append([begin.T @ each for each in forces])
    mass, damping, stiffness = seen[0]
    scales = [float(np.abs(each).max()) for each in seen[0]]
    same = all(
        np.abs(a - b).max() <= UNMOVED_PART * size for each in seen for a, b, size in zip(each, seen[0], scales, strict=True)
    )
    if not same or not scales[0] > 0:
        return False
    none, one = np.zeros_like(mass), np.eye(len(mass))
    grows = np.linalg.eigvals(np.block([[none, one], [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)]]))
    return bool(grows.real.max() * (solution.times[end] - solution.times[0]) < 1.0)


def _course(solution: Solution, still: np.ndarray, begin: np.ndarray, end: int) -> Course:
    """Growth of disturbances by some states of a motion."""
    system, n_q, times = solution.system, solution.system.n_q, solution.times
    look = still.T * _lengths(solution, end)
    none = np.zeros_like(begin)
    y, v = np.hstack([begin, none]), np.hstack([none, begin / (times[end] - times[0])])
    before, largest, where, moved = _matrices(solution, 0), 1.0, 0, y[:, 0]
    states = spread(end, MOST_STATES)
    for last, n in pairwise(states):
        here = _matrices(solution, n)
        y, v = _step(before, here, y, v, float(times[n] - times[last]))
        shown = look @ y
        before, size = here, float(np.linalg.norm(shown, 2))
        if size > largest:
            largest, where, moved = size, n, y[:, first_largest(np.linalg.norm(shown, axis=0))]
    return Course(largest, float(times[where]), system.most_moved(np.append(moved, np.zeros(system.n - n_q))))


def _lengths(solution: Solution, end: int) -> np.ndarray:
    """Weights (n_q,) of coordinates; of a scene that travels by more than its size, relative to the way."""
    system, n_q = solution.system, solution.system.n_q
    weights = system.weights[:n_q]
    way = float((np.ptp(np.real(solution.q[: end + 1]), axis=0) * weights).max())
    found: np.ndarray = weights / max(1.0, way)
    return found


def _step(
    before: tuple[np.ndarray, ...], here: tuple[np.ndarray, ...], y: np.ndarray, v: np.ndarray, h: float
) -> tuple[np.ndarray, np.ndarray]:
    """Disturbances (n_q, n) and their velocities after one step; y meets the joints at its end."""
    mass, damping, stiffness = ((one + other) / 2 for one, other in zip(before[:3], here[:3], strict=True))
    rows, n_q, n = here[3], len(y), len(y) + len(here[3])
    left: np.ndarray = np.zeros((n, n))
    left[:n_q, :n_q] = mass / h + IMPLICITNESS * damping + IMPLICITNESS**2 * h * stiffness
    left[n_q:, :n_q], left[:n_q, n_q:] = rows, rows.T
    known: np.ndarray = np.zeros((n, y.shape[1]))
    known[:n_q] = mass @ v / h - (1 - IMPLICITNESS) * damping @ v - stiffness @ (y + IMPLICITNESS * (1 - IMPLICITNESS) * h * v)
    known[n_q:] = -rows @ (y / h + (1 - IMPLICITNESS) * v) / IMPLICITNESS
    found = _solved(left, known)[:n_q]
    return y + h * ((1 - IMPLICITNESS) * v + IMPLICITNESS * found), found


def _solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solution of linear equations; where joints repeat each other, the smallest of the solutions."""
    try:
        found: np.ndarray = np.linalg.solve(matrix, right)
        if np.abs(matrix @ found - right).max(initial=0.0) <= SOLUTION_RESIDUAL * np.abs(right).max(initial=0.0):
            return found
    except np.linalg.LinAlgError:
        pass
    return np.linalg.lstsq(matrix, right)[0]
