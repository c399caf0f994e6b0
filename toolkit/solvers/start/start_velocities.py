"""Velocities at the start: what is written holds or is refused, what is not is found.

    minimise (v - g)^T A (v - g) / 2,   A = M + (1 s)^2 K,   with phi_q v + phi_t = 0 and v_W = g_W

g are the given velocities, those of W are written. Mass measures the least motion among those that fit, and strain energy keeps flexible
bodies from being bent where they can just as well be moved, as in `assembly`. Of the written velocities only some are independent, the
joints imply the others: those are found like all the rest, and have to come out as they are written.
"""

from __future__ import annotations

import numpy as np

from toolkit.bodies.body import QUATERNION
from toolkit.equations.equations import Terms
from toolkit.kinematics.spatial import angular_velocity, quaternion_rate
from toolkit.solvers.direct_solve import solve_linear
from toolkit.solvers.start.assembly import stiffened
from toolkit.solvers.start.written_velocities import refuse_contradictions, refuse_variables_that_contradict
from toolkit.system.system import System

INDEPENDENT = 1e-10
"""Square of the sine between a velocity and those that the joints and other written ones determine, above which it is its own."""
NEARLY_LARGEST = 0.1
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
    while (squares := np.diag(P)).max(initial=0) > INDEPENDENT:
        k = int(np.argmax(squares >= NEARLY_LARGEST * squares.max()))
        P = P - np.outer(P[:, k], P[k]) / P[k, k]
        P[k], P[:, k] = 0, 0
        chosen.append(coordinates[k])
    return chosen
