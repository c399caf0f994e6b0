"""Positions and velocities at the start: joints closed, what is written holds or is refused, what is not is found.

Closing the joints before a run starts: the positions next to the given ones that satisfy every joint, and how they follow the design.

    [M(q) + (1 s)^2 K] (q - q_given) + phi_q(q)^T mu = 0,    phi(q, t) = 0

Mass measures "next to", as it does for the velocities at the start, and strain energy keeps flexible bodies from being bent where
they can just as well be moved (both systems of units count time in seconds). Solved by Newton's method; the same matrix gives dq/dx.

    minimise (v - g)^T A (v - g) / 2,   A = M + (1 s)^2 K,   with phi_q v + phi_t = 0 and v_W = g_W

g are the given velocities, those of W are written. Mass measures the least motion among those that fit, and strain energy keeps flexible
bodies from being bent where they can just as well be moved, as in `assembly`. Of the written velocities only some are independent, the
joints imply the others: those are found like all the rest, and have to come out as they are written.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from toolkit.components.bodies.body import QUATERNION, Body
from toolkit.components.bodies.kernels.constant_kernel import together
from toolkit.components.bodies.model_body import ModelBody
from toolkit.foundation.errors import ConvergenceError, InputError, SingularSystemError
from toolkit.foundation.kinematics.orientation import angular_velocity, quaternion_rate
from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.units import unit
from toolkit.solvers.direct_solve import solve_linear
from toolkit.solvers.start.open_joints import repeat_each_other, search, told_gap
from toolkit.solvers.start.rigid_bodies import RigidBodies
from toolkit.system.equations import Terms
from toolkit.system.quantities import STEP
from toolkit.system.system import System

LAST_CORRECTION = 1e-13
"""Last correction, as a part of the model size: Newton's method is quadratic, so that round-off is left."""
ROUND_OFF = 1e-13
"""Correction, per distance of the bodies from the origin, that is round-off if it does not shrink any more."""
LONGEST_MOVE = 0.3
"""Furthest move that is an adjustment, as a part of the model size; more is another configuration, or a mistake. Of a rotation half the
angle counts, as it does in the quaternions of bodies in space: bodies turn by up to 0.6 rad."""
MOST_CORRECTIONS = 30
LEVELS = np.array([0.0, 0.0, 1.0])
WHERE_CLOSED = "closing of the joints at the start"


def assemble(system: System, given: np.ndarray, dgiven: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions (n,) that satisfy every joint, and their design derivatives (n, n_x), from given ones.

    Raises
    ------
    ConvergenceError
        The joints do not close near the given positions; names the coordinate that would move furthest.
    SingularSystemError
        Joints are redundant.
    """
    stiff = stiffened(system)
    try:
        q, acc = _closed(stiff, given, time)
    except (ConvergenceError, SingularSystemError) as error:
        told = _told_by_search(system, given, time)
        if told:
            raise ConvergenceError(told) from error
        raise
    return q, _change(stiff, q, acc, dgiven, time) if system.n_x else dgiven


def _closed(system: System, given: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions, and [q - q_given; mu] there, (n,) each; of a system of `stiffened`."""
    is_q, q, acc, largest, before = np.arange(system.n) < system.n_q, given.copy(), np.zeros_like(given), np.inf, np.inf
    counted = _counted(system)
    far = (system.weights * np.abs(np.real(given)))[: system.n_q].max()
    for _ in range(MOST_CORRECTIONS):
        stagnated = largest <= ROUND_OFF * far and largest > 0.5 * before
        closed = largest <= LAST_CORRECTION or stagnated  # once more then: an imaginary part is as exact as the last solve
        terms = _evaluate(system, q, acc, time)
        step = solve_linear(system, _closing_matrix(system, terms), -np.where(is_q, terms.inertial, terms.applied), WHERE_CLOSED)
        q, acc = q + np.where(is_q, step, 0), acc + step
        near = np.all(counted * np.abs(np.real(q - given))[: system.n_q] <= LONGEST_MOVE)
        if closed and near:
            return q, acc
        if closed or not near:
            break
        before, largest = largest, (system.weights * np.abs(np.real(step)))[: system.n_q].max()
    raise ConvergenceError(_far(system, given, q))


def _change(system: System, q: np.ndarray, acc: np.ndarray, dgiven: np.ndarray, time: float) -> np.ndarray:
    """Design derivatives (n, n_x) of positions that `_closed` has found."""
    is_q, terms = np.arange(system.n)[:, None] < system.n_q, _evaluate(system, q, acc, time)
    change = np.where(is_q, terms.I_x - system.matrix(terms.I_acc + system.unit_of_states) @ dgiven, terms.A_x)
    return np.where(is_q, solve_linear(system, _closing_matrix(system, terms), -change, WHERE_CLOSED), 0)


def _counted(system: System) -> np.ndarray:
    """Weights (n_q,) that make moves of coordinates comparable, as `LONGEST_MOVE` counts them."""
    first, found = system.numbering.first, system.weights[: system.n_q].copy()
    found[[first[name] + body.moves for name, body in system.scene.all_bodies().items() if body.turns == 1]] /= 2  # in the plane
    return found


def _far(system: System, given: np.ndarray, q: np.ndarray) -> str:
    """A sentence on joints that close in other positions (n,) than next to the given ones."""
    i = first_largest(_counted(system) * np.abs(np.real(q - given))[: system.n_q])
    return (
        f"the joints do not close near the given positions: {system.numbering.names[i]} would move by "
        f"{system.weights[i] * abs(np.real(q - given)[i]):.2g} of the model size (or rad). Give positions, a length or a curve that fit "
        "together better."
    )


def _told_by_search(system: System, given: np.ndarray, time: float) -> str:
    """Sentence on why open joints do not close, by a search among all positions; empty if the search does not tell."""
    bodies, inputs = RigidBodies(system), system.inputs(time, LEVELS)
    found = search(bodies, inputs, given)
    if found is None:
        return ""
    if not found.closes:
        return told_gap(bodies, inputs, found)
    if repeat_each_other(bodies, inputs, found.q):
        return ""
    moved = _counted(system) * np.abs(np.real(found.q - given))[: system.n_q]
    if moved.max() > LONGEST_MOVE:
        return _far(system, given, found.q)
    name = system.numbering.names[first_largest(moved)]
    return (
        "the joints close near the given positions, but Newton's method does not come there (it cannot from a dead point): with "
        f"{name} moved by {np.real(found.q - given)[first_largest(moved)]:+.3g} they do. Give positions nearer to those."
    )


def stiffened(system: System) -> System:
    """System with M + (1 s)^2 K in the place of M."""
    part = system.plan.constant
    everywhere = np.ones_like(part.segment_damped)  # there is a mass where there is stiffness alone otherwise
    mass = {
        "mass": part.mass + part.stiffness,
        "M": part.M + part.K,
        "design_mass": together(part.design_mass, part.design_stiffness),
        "segment_damped": everywhere,
    }
    return replace(system, plan=system.plan._replace(constant=part._replace(**mass)))


def _evaluate(system: System, q: np.ndarray, acc: np.ndarray, time: float) -> Terms:
    """Terms of the equations of assembly.

    Inertial: [M + K] (q - q_given) + phi_q^T mu with acc = [q - q_given; mu]. Applied, below: phi.
    """
    return system.evaluate(system.inputs(time, LEVELS), q, np.zeros_like(q), acc, design=True)


def _closing_matrix(system: System, terms: Terms) -> np.ndarray:
    """Derivative by [q; mu] of the equations, values on the pattern."""
    below = np.repeat(np.arange(system.n), np.diff(system.plan.indptr)) >= system.n_q
    return terms.I_acc + system.unit_of_states + np.where(below, terms.A_q, terms.I_q)


ELASTIC = "elastic_velocity"
"""Key of a flexible body's table that writes velocities of its points in its own axes."""
VELOCITY_TOLERANCE = 1e-6
"""Part of the fastest velocity of the start by which a written one may miss what the joints allow: it was written with seven digits."""
DERIVATIVE_TOLERANCE = 1e-8
"""Part of the fastest derivative by a design variable by which one may miss what the joints allow; it has no written digits."""
NEARLY_LARGEST_MISS = 0.9
"""Part of the largest miss from which the first one is named, so that no round-off decides."""


def written_velocities(system: System) -> dict[int, str]:
    """Coordinates whose velocity the scene writes -> path that says so, rotations of a body first, and its shape last."""
    bodies, first = system.scene.bodies.items(), system.numbering.first
    found = {first[name] + k: f"bodies.{name}.{key}" for name, body in bodies for k, key in body.written_velocities().items()}
    return found | {i: f"bodies.{name}.{ELASTIC}" for name, body in bodies if writes_shape(body) for i in _elastic(system, name)}


def writes_shape(body: Body) -> bool:
    """Whether velocities of points of a flexible body are written, and with them those of all its elastic coordinates."""
    return isinstance(body, ModelBody) and bool(body.deflected[ELASTIC])


def _elastic(system: System, name: str) -> range:
    """Numbers of a body's elastic coordinates."""
    body, first = system.scene.bodies[name], system.numbering.first[name]
    return range(first + body.frame_size, first + len(body.coordinate_names(system.scene)))


def refuse_own_velocities(system: System, given: np.ndarray, found: np.ndarray) -> None:
    """Refuse given velocities (n,) of all coordinates that the joints do not allow, where `found` are the nearest that they do.

    Raises
    ------
    InputError
        Names the coordinate with both velocities.
    """
    missed, fastest = _missed(system, np.real(given), np.real(found))
    if missed.max(initial=0) > VELOCITY_TOLERANCE * fastest:
        i = int(np.argmax(missed >= NEARLY_LARGEST_MISS * missed.max()))
        raise InputError(
            f"the velocities that were given as a start contradict the joints: that of {system.numbering.names[i]} is "
            f"{np.real(given[i]):.9g}, and {np.real(found[i]):.9g} in the nearest motion that the joints allow. Give velocities that fit, "
            "or none."
        )


def refuse_contradictions(system: System, q: np.ndarray, given: np.ndarray, found: np.ndarray, written: dict[int, str]) -> None:
    """Refuse velocities (n,) of written coordinates that did not come out as they were given; and, in a complex step, their derivatives.

    Raises
    ------
    InputError
        Names the path with both velocities.
    """
    missed, fastest = _missed(system, np.real(given), np.real(found))
    wrong = [i for i in written if missed[i] > VELOCITY_TOLERANCE * fastest]
    if wrong:
        first = next(i for i in wrong if missed[i] >= NEARLY_LARGEST_MISS * missed[wrong].max())
        path, wish, allowed = _in_numbers(system, first, written[first], q, given, found)
        raise InputError(
            f"{path} is written as {wish} at the start, but the joints, with what else is written, allow {allowed}. Write what fits, or "
            f"leave velocities out: those that are not written are found by the joints.{_advice(system, path)}"
        )
    changed, largest = _missed(system, np.imag(given), np.imag(found))
    moved = [i for i in written if changed[i] > DERIVATIVE_TOLERANCE * max(largest, STEP * fastest)]
    if moved:
        raise InputError(_contradiction(system, "the design variable of the complex step", written[moved[0]]))


def refuse_variables_that_contradict(
    system: System, found: np.ndarray, dgiven: np.ndarray, dfound: np.ndarray, written: dict[int, str]
) -> None:
    """Refuse design variables that move what the joints imply, but not what is written.

    Raises
    ------
    InputError
        Names the variable and the path.
    """
    weights, n_q = system.weights[: system.n_q, None], system.n_q
    fastest = float((weights[:, 0] * np.abs(np.real(found))[:n_q]).max(initial=0))
    sizes = np.array([abs(x.value) or (system.scene.size if x.path.startswith("points.") else 1.0) for x in system.design])
    missed = weights * np.abs(dfound - dgiven)[:n_q]
    largest = np.maximum(fastest / sizes, (weights * np.abs(dfound)[:n_q]).max(axis=0, initial=0))
    for i, path in written.items():
        for x in np.flatnonzero(missed[i] > DERIVATIVE_TOLERANCE * largest):
            raise InputError(_contradiction(system, f"design variable {system.design.names[x]!r}", path))


def _contradiction(system: System, variable: str, path: str) -> str:
    key = ".".join(path.split(".")[:3])
    return (
        f"{variable} would make {path} contradict the joints at the start: more velocities are written than the joints leave free, so that "
        f"there is no derivative by it. Leave {key} or another velocity out: those that are not written are found by the joints."
        f"{_advice(system, path)}"
    )


def _missed(system: System, given: np.ndarray, found: np.ndarray) -> tuple[np.ndarray, float]:
    """Differences (n_q,) of velocities from given ones, and the fastest of all, in parts of the model size (or rad) per time."""
    weights, n_q = system.weights[: system.n_q], system.n_q
    fastest = (weights * np.maximum(np.abs(found), np.abs(given))[:n_q]).max(initial=0)
    return weights * np.abs(found - given)[:n_q], float(fastest)


def _in_numbers(system: System, i: int, path: str, q: np.ndarray, given: np.ndarray, found: np.ndarray) -> tuple[str, str, str]:
    """Path, written and found number of a coordinate's velocity, in the numbers that a scene writes."""
    name = path.split(".")[1]
    body, first = system.scene.bodies[name], system.numbering.first[name]
    at = slice(first, first + len(body.coordinate_names(system.scene)))
    if i in _elastic(system, name):
        length, label = float(body.coordinate_lengths(system.scene)[i - first]), f"{unit(system.scene.units, 'length')}/s"
        of = f"{label} of {system.numbering.names[i]} (RMS of its points)"
        wish, allowed = (f"{_listed(length * v[i : i + 1])} {of}" for v in (given, found))
        return path, wish, allowed
    turns = i >= first + body.frame_size - body.turns
    label = "rad/s" if turns else f"{unit(system.scene.units, 'length')}/s"
    pair = (body.frame_motion(q[at], v[at])["angular_velocity"] if turns else v[i : i + 1] for v in (given, found))
    wish, allowed = (f"{_listed(each)} {label}" for each in pair)
    return path, wish, allowed


def _listed(numbers: np.ndarray) -> str:
    """Text of one number, or of several in brackets."""
    shown = ", ".join(f"{x:.9g}" for x in np.real(numbers))
    return shown if len(numbers) == 1 else f"[{shown}]"


def _advice(system: System, path: str) -> str:
    name, key = path.split(".")[1:3]
    if key == ELASTIC:
        return (
            " What is written of the points of a body decides the motion of all of it: write also those points that joints hold."
        )
    if key == "velocity" and system.scene.bodies[name].turns:
        return f" `angular_velocity` alone, in the place of `velocity`, gives {name!r} a rotation about whatever holds it."
    return ""


INDEPENDENT_SINE_SQUARED = 1e-10
"""Square of the sine between a velocity and those that the joints and other written ones determine, above which it is its own."""
NEARLY_MOST_INDEPENDENT = 0.1
"""Part of the most independent velocity's square of the sine from which the first one is taken, so that no round-off decides."""
WHERE = "velocities at the start"


def carried_along(system: System, q: np.ndarray, v: np.ndarray, dv: np.ndarray, dq: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Velocities (n,) and derivatives (n, n_x) of the scene's start for other coordinates q: quaternions turn with the same omega."""
    given, _, dgiven, _ = system.start()
    if np.array_equal(q, given) and (dq is dgiven or np.array_equal(dq, dgiven)):
        return v, dv
    v, dv = v.copy(), dv.copy()
    for name in system.numbering.length:
        first = system.numbering.first[name] + system.scene.body(name).frame_size - QUATERNION
        at = slice(first, first + QUATERNION)
        omega = angular_velocity(given[at], v[at])
        domega = np.real(angular_velocity(dgiven[at].T, v[at]) + angular_velocity(given[at], dv[at].T))
        dv[at] = np.real(quaternion_rate(dq[at], omega[:, None] + 0 * dq[at][:3]) + quaternion_rate(q[at], domega.T))
        v[at] = quaternion_rate(q[at], omega)
    return v, dv


def project_velocities(
    system: System,
    q: np.ndarray,
    v: np.ndarray,
    dq: np.ndarray,
    dv: np.ndarray,
    time: float,
    written: dict[int, str] | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Velocities that satisfy the joints, nearest to the given ones, (n,), and their design derivatives, (n, n_x).

    Parameters
    ----------
    written : coordinates whose velocity holds -> path that says so, those first that tell most

    Raises
    ------
    InputError
        A written velocity contradicts the joints, or moving a design variable would make it do so.
    SingularSystemError
        Joints are redundant.
    """
    if not (np.any(v) or np.any(dv) or np.any(system.plan.joints.curve >= 0)):
        return v, dv
    system, n_q, written = stiffened(system), system.n_q, written or {}
    terms = _joints(system, q, v, np.zeros_like(v), time)
    if not np.any(terms.applied[n_q:]) and not np.any(_total(system, terms, dq, dv)[n_q:]):
        return v, dv
    held = independent(system, terms, list(written))
    matrix, free = _without(system, _matrix(system, terms), held), ~np.isin(np.arange(system.n), held)
    below = np.arange(system.n) >= n_q
    impulse = solve_linear(system, matrix, np.where(below, -terms.applied, 0), WHERE)
    found = v + np.where(below, 0, impulse)
    refuse_contradictions(system, q, v, found, written)
    if not system.n_x:
        return found, dv
    terms = _joints(system, q, found, impulse, time)
    change = np.where(below[:, None], _total(system, terms, dq, dv), system.matrix(terms.I_q) @ dq + terms.I_x)
    dfound = dv + np.where(below[:, None], 0, solve_linear(system, matrix, np.where(free[:, None], -change, 0), WHERE))
    refuse_variables_that_contradict(system, found, dv, dfound, written)
    return found, dfound


def _joints(system: System, q: np.ndarray, v: np.ndarray, acc: np.ndarray, time: float) -> Terms:
    """Terms of the equations for velocities at the start.

    Applied, below: phi_q v + phi_t. Inertial, with acc = [v - g; mu]: A (v - g) + phi_q^T mu.
    """
    return system.evaluate(system.inputs(time, np.array([0, 1.0, 0])), q, v, acc, design=True)


def _total(system: System, terms: Terms, dq: np.ndarray, dv: np.ndarray) -> np.ndarray:
    """Total derivative of `applied` by the design, (n, n_x)."""
    return system.matrix(terms.A_q) @ dq + system.matrix(terms.A_v) @ dv + terms.A_x


def _matrix(system: System, terms: Terms) -> np.ndarray:
    """Matrix [[A, phi_q^T], [phi_q, 0]], by its values on the pattern."""
    return terms.I_acc + system.unit_of_states + np.where(_rows(system) >= system.n_q, terms.A_v, 0)


def _rows(system: System) -> np.ndarray:
    return np.repeat(np.arange(system.n), np.diff(system.plan.indptr))


def _without(system: System, matrix: np.ndarray, held: list[int]) -> np.ndarray:
    """Matrix with rows and columns of the unit matrix for the held coordinates."""
    rows, columns = _rows(system), system.plan.indices
    crossed = np.isin(rows, held) | np.isin(columns, held)
    return np.where(crossed, np.where(rows == columns, 1.0, 0.0), matrix)


def independent(system: System, terms: Terms, coordinates: list[int]) -> list[int]:
    """First of the given coordinates whose velocities can be chosen at will; the joints then imply those of the others.

    P, the projection on the motions that the joints allow, of coordinates divided by their weights, has the squares of the sines on
    its diagonal; choosing a coordinate takes its motion out of P.
    """
    if not coordinates:
        return []
    n_q, rows, columns = system.n_q, _rows(system), system.plan.indices
    weights = np.concatenate([system.weights[:n_q], np.zeros(system.n - n_q)])
    unit = np.where(rows == columns, weights[rows] ** 2, 0.0)
    matrix = np.where((rows < n_q) & (columns < n_q), unit, np.real(_matrix(system, terms)))
    impulses = np.zeros((system.n, len(coordinates)))
    impulses[coordinates, np.arange(len(coordinates))] = weights[coordinates]
    P = np.real(weights[coordinates, None] * solve_linear(system, matrix, impulses, WHERE)[coordinates])
    chosen: list[int] = []
    while (squares := np.diag(P)).max(initial=0) > INDEPENDENT_SINE_SQUARED:
        k = int(np.argmax(squares >= NEARLY_MOST_INDEPENDENT * squares.max()))
        P = P - np.outer(P[:, k], P[k]) / P[k, k]
        P[k], P[:, k] = 0, 0
        chosen.append(coordinates[k])
    return chosen
