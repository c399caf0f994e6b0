"""Velocities at the start: what is written holds or is refused, what is not is found.

    minimise (v - g)^T A (v - g) / 2,   A = M + (1 s)^2 K,   with phi_q v + phi_t = 0 and v_W = g_W

g are the given velocities, those of W are written. Mass measures the least motion among those that fit, and strain energy keeps flexible
bodies from being bent where they can just as well be moved, as in `assembly`. Of the written velocities only some are independent, the
joints imply the others: those are found like all the rest, and have to come out as they are written.
"""

from __future__ import annotations

import numpy as np

from toolkit.equations import Terms
from toolkit.errors import InputError
from toolkit.solvers.assembly import stiffened
from toolkit.solvers.direct_solve import solve_linear
from toolkit.spatial import angular_velocity, quaternion_rate
from toolkit.system import System
from toolkit.units import unit
from toolkit.validity.frame_motion import QUATERNION, frame_motion

HOLDS = 1e-6
"""Part of the fastest velocity of the start by which a written one may miss what the joints allow: it was written with seven digits."""
DERIVATIVE_HOLDS = 1e-8
"""The same of the derivative by a design variable, which has no written digits."""
INDEPENDENT = 1e-10
"""Square of the sine between a velocity and those that the joints and other written ones determine, above which it is its own."""
NEARLY_LARGEST = 0.1
"""Part of the most independent velocity's square of the sine from which the first one is taken, so that no round-off decides."""
WHERE = "velocities at the start"


def written_velocities(system: System) -> dict[int, str]:
    """Coordinates whose velocity the scene writes -> path that says so, rotations of a body first."""
    bodies, first = system.scene.bodies.items(), system.numbering.first
    return {first[name] + k: f"bodies.{name}.{key}" for name, body in bodies for k, key in body.written_velocities().items()}


def carried_along(system: System, q: np.ndarray, v: np.ndarray, dv: np.ndarray, dq: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Velocities (n,) and derivatives (n, n_x) of the scene's start for other coordinates q: quaternions turn with the same omega."""
    given, _, dgiven, _ = system.start()
    if np.array_equal(q, given) and np.array_equal(dq, dgiven):
        return v, dv
    v, dv = v.copy(), dv.copy()
    for name in system.numbering.length:
        first = system.numbering.first[name] + system.scene.bodies[name].frame_size - QUATERNION
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
    _refuse_contradictions(system, q, v, found, written)
    if not system.n_x:
        return found, dv
    terms = _joints(system, q, found, impulse, time)
    change = np.where(below[:, None], _total(system, terms, dq, dv), system.matrix(terms.I_q) @ dq + terms.I_x)
    dfound = dv + np.where(below[:, None], 0, solve_linear(system, matrix, np.where(free[:, None], -change, 0), WHERE))
    _refuse_variables_that_contradict(system, found, dv, dfound, written)
    return found, dfound


def _joints(system: System, q: np.ndarray, v: np.ndarray, acc: np.ndarray, time: float) -> Terms:
    """Applied, below: phi_q v + phi_t. Inertial, with acc = [v - g; mu]: A (v - g) + phi_q^T mu."""
    return system.evaluate(system.inputs(time, np.array([0, 1.0, 0])), q, v, acc, design=True)


def _total(system: System, terms: Terms, dq: np.ndarray, dv: np.ndarray) -> np.ndarray:
    """Derivative of `applied` by the design, (n, n_x)."""
    return system.matrix(terms.A_q) @ dq + system.matrix(terms.A_v) @ dv + terms.A_x


def _matrix(system: System, terms: Terms) -> np.ndarray:
    """[[A, phi_q^T], [phi_q, 0]], values on the pattern."""
    return terms.I_acc + np.where(_rows(system) >= system.n_q, terms.A_v, 0)


def _rows(system: System) -> np.ndarray:
    return np.repeat(np.arange(system.n), np.diff(system.plan.indptr))


def _without(system: System, matrix: np.ndarray, held: list[int]) -> np.ndarray:
    """The matrix with rows and columns of the unit matrix for the held coordinates."""
    rows, columns = _rows(system), system.plan.indices
    crossed = np.isin(rows, held) | np.isin(columns, held)
    return np.where(crossed, np.where(rows == columns, 1.0, 0.0), matrix)


def independent(system: System, terms: Terms, coordinates: list[int]) -> list[int]:
    """Those of the coordinates whose velocities can be chosen at will, the first ones that are; the joints then imply the others.

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
    while (squares := np.diag(P)).max(initial=0) > INDEPENDENT:
        k = int(np.argmax(squares >= NEARLY_LARGEST * squares.max()))
        P = P - np.outer(P[:, k], P[k]) / P[k, k]
        P[k], P[:, k] = 0, 0
        chosen.append(coordinates[k])
    return chosen


def refuse_own_velocities(system: System, given: np.ndarray, found: np.ndarray) -> None:
    """Refuse given velocities (n,) of all coordinates that the joints do not allow, where `found` are the nearest that they do.

    Raises
    ------
    InputError
        Names the coordinate with both velocities.
    """
    missed, fastest = _missed(system, given, found)
    if missed.max(initial=0) > HOLDS * fastest:
        i = int(np.argmax(missed))
        raise InputError(
            f"the velocities that were given as a start contradict the joints: that of {system.numbering.names[i]} is "
            f"{np.real(given[i]):.9g}, and {np.real(found[i]):.9g} in the nearest motion that the joints allow. Give velocities that fit, "
            "or none."
        )


def _missed(system: System, given: np.ndarray, found: np.ndarray) -> tuple[np.ndarray, float]:
    """By how much velocities differ from given ones, (n_q,), and the fastest of all, in parts of the scene's size (or rad) per time."""
    weights, n_q = system.weights[: system.n_q], system.n_q
    fastest = (weights * np.maximum(np.abs(np.real(found)), np.abs(np.real(given)))[:n_q]).max(initial=0)
    return weights * np.abs(np.real(found - given))[:n_q], float(fastest)


def _refuse_contradictions(system: System, q: np.ndarray, given: np.ndarray, found: np.ndarray, written: dict[int, str]) -> None:
    """Refuse written velocities that did not come out."""
    missed, fastest = _missed(system, given, found)
    wrong = [i for i in written if missed[i] > HOLDS * fastest]
    if wrong:
        worst = max(wrong, key=lambda i: missed[i])
        path, wish, allowed = _in_numbers(system, worst, written[worst], q, given, found)
        raise InputError(
            f"{path} is written as {wish} at the start, but the joints, with what else is written, allow {allowed}. Write what fits, or "
            f"leave velocities out: those that are not written are found by the joints.{_advice(system, path)}"
        )


def _in_numbers(system: System, i: int, path: str, q: np.ndarray, given: np.ndarray, found: np.ndarray) -> tuple[str, str, str]:
    """Path, written and found number of a coordinate's velocity, in the numbers that a scene writes."""
    name = path.split(".")[1]
    body, first = system.scene.bodies[name], system.numbering.first[name]
    at = slice(first, first + len(body.coordinate_names(system.scene)))
    turns = i >= first + body.frame_size - body.turns
    label = "rad/s" if turns else f"{unit(system.scene.units, 'length')}/s"
    if not turns or system.scene.dimension == 2:
        return path, f"{np.real(given[i]):.9g} {label}", f"{np.real(found[i]):.9g} {label}"
    wish, allowed = (np.real(frame_motion(body, q[at], v[at])["angular_velocity"]) for v in (given, found))
    return path, *("[" + ", ".join(f"{x:.9g}" for x in each) + f"] {label}" for each in (wish, allowed))  # type: ignore[return-value]


def _advice(system: System, path: str) -> str:
    name, key = path.split(".")[1:3]
    if key == "velocity" and system.scene.bodies[name].turns:
        return f" `angular_velocity` alone, in the place of `velocity`, gives {name!r} a rotation about whatever holds it."
    return ""


def _refuse_variables_that_contradict(
    system: System, found: np.ndarray, dgiven: np.ndarray, dfound: np.ndarray, written: dict[int, str]
) -> None:
    """Refuse design variables that move what the joints imply, but not what is written."""
    weights, n_q = system.weights[: system.n_q, None], system.n_q
    fastest = float((weights[:, 0] * np.abs(np.real(found))[:n_q]).max(initial=0))
    sizes = np.array([abs(x.value) or (system.scene.size if x.path.startswith("points.") else 1.0) for x in system.design])
    missed = weights * np.abs(dfound - dgiven)[:n_q]
    largest = np.maximum(fastest / sizes, (weights * np.abs(dfound)[:n_q]).max(axis=0, initial=0))
    for i, path in written.items():
        for x in np.flatnonzero(missed[i] > DERIVATIVE_HOLDS * largest):
            key = ".".join(path.split(".")[:3])
            raise InputError(
                f"design variable {system.design.names[x]!r} would make {path} contradict the joints at the start: more velocities are "
                f"written than the joints leave free, so that there is no derivative by it. Leave {key} or another velocity out: those "
                f"that are not written are found by the joints.{_advice(system, path)}"
            )
