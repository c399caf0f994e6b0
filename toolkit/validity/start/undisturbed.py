"""Motions that a small disturbance would end, and that hold because nothing disturbs them: tops too slow to stand, bodies that spin about
their middle axis at a joint, pendulums whose pivot or load alternates.

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

from toolkit.bodies.body import Body
from toolkit.foundation.near_ties import first_largest, spread
from toolkit.foundation.verdict import Caution
from toolkit.responses.flutter import UNSTABLE
from toolkit.solvers.free_motions import free_motions
from toolkit.solvers.static.equilibrium import LEVELS, static_matrix
from toolkit.system.flexible_bodies import deforming
from toolkit.system.solution import Solution

STILL = 1e-6
"""Move in a direction, relative to the model size or in rad, up to which nothing has moved there."""
GROWTH = 100.0
"""Growth of a disturbance above which there is a doubt, as of other motions that hardly anything sets off."""
PARTS = (1.0, 0.5, 0.25)
"""Parts of the motion up to which its directions are examined: what round-off sets off has moved at the end."""
MOST_COORDINATES, MOST_STATES, SEEN = 60, 1000, 200
"""Largest number of coordinates of a scene that is examined, and of states (of longer motions every second or third one); and
number of states that directions are found from."""
TURNED = 0.25
"""Angle between two states, rad, from which on growth may be that of the steps: of a top just fast enough to stand a tilt seems to grow
four million times in 8 s with 0.63 rad in a step, and 1300 times with 0.31."""
ENOUGH = 3
"""Least number of states per coordinate: fewer leave directions open by their number alone."""
SAMPLES, GOLDEN = 12, (5**0.5 - 1) / 2
"""Number of states in which the equations of disturbances are compared; spread by the golden section, in no step with
vibrations."""
THETA = 0.51
CLOSED = 1e-6
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
    elif found is not None and found.growth > GROWTH:
        yield Caution(
            UNSTABLE,
            f"a small disturbance of this motion becomes {found.growth:.2g} times as large until t = {found.until:.4g}, most of all in "
            f"{found.coordinate}, and nothing sets it off there: round-off or symmetry decides when the motion leaves this way. Fix: write "
            "the disturbance that is meant into the start, a thousandth of the motion say.",
        )


def largest_growth(solution: Solution) -> Course | None:
    """Growth of disturbances in the first part of the motion in which it exceeds `GROWTH`; None where it does not.

    Scenes with bodies that deform are not examined: their vibrations are. None stands for these and other unknown cases, too.
    """
    system, options = solution.system, solution.options or solution.system.scene.solver
    few = system.n_q == system.n_b <= MOST_COORDINATES and not deforming(system.scene)
    if not solution.steps or options.quasi_static or solution.run_times is not None or not few or not system.compiled:
        return None
    last, known = len(solution.times) - 1, 0
    for part in PARTS:
        end = int(part * last)
        if end < ENOUGH * system.n_q:
            break
        still = _still(solution, end)
        begin = _disturbances(solution, still)
        look = begin.shape[1] > known and not _stays_small(solution, still, begin, end)
        course = _course(solution, still, begin, end) if look else None
        if course is not None and course.growth > GROWTH:
            return course._replace(resolved=_turned(solution, end) <= TURNED)
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
    moved = solution.q[spread(end, SEEN)] - solution.q[0]
    _, sizes, rows = np.linalg.svd(np.real(moved) * solution.system.weights[: solution.system.n_q])
    directions: np.ndarray = rows[np.count_nonzero(sizes > STILL) :].T
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
        if max(float(np.abs(each).max()) for each in moving) > STILL * scale or np.abs(rows @ begin).max(initial=0.0) > STILL:
            return False
        seen.append([begin.T @ each for each in forces])
    mass, damping, stiffness = seen[0]
    scales = [float(np.abs(each).max()) for each in seen[0]]
    same = all(np.abs(a - b).max() <= STILL * size for each in seen for a, b, size in zip(each, seen[0], scales, strict=True))
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
    left[:n_q, :n_q] = mass / h + THETA * damping + THETA**2 * h * stiffness
    left[n_q:, :n_q], left[:n_q, n_q:] = rows, rows.T
    known: np.ndarray = np.zeros((n, y.shape[1]))
    known[:n_q] = mass @ v / h - (1 - THETA) * damping @ v - stiffness @ (y + THETA * (1 - THETA) * h * v)
    known[n_q:] = -rows @ (y / h + (1 - THETA) * v) / THETA
    found = _solved(left, known)[:n_q]
    return y + h * ((1 - THETA) * v + THETA * found), found


def _solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solution of linear equations; where joints repeat each other, the smallest of the solutions."""
    try:
        found: np.ndarray = np.linalg.solve(matrix, right)
        if np.abs(matrix @ found - right).max(initial=0.0) <= CLOSED * np.abs(right).max(initial=0.0):
            return found
    except np.linalg.LinAlgError:
        pass
    return np.linalg.lstsq(matrix, right)[0]
