"""Whether a motion that begins at rest passes a state in which it could not rest: a snap-through, and what it means for its numbers.

The stiffness that forces of inertia give a body in a state of a motion, as if they kept their size and direction.

Without them such a state is not in balance, and what its second derivatives say of stability depends on where the frames of its bodies
have their origins: with all of them on the axis, the parts of a beam that spins seem to fall outwards. Held in balance by the force -g on
the centre of mass c of a body, in its frame's axes, a turn meets

    g . A c   in the plane,   -g . d^2 (A c) / dp^2 + 2 (g . A c) 1   in space, with the quaternion p and its length
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import scipy

from toolkit.components.bodies.body import QUATERNION
from toolkit.foundation.compiled.calls import call
from toolkit.foundation.errors import SingularSystemError
from toolkit.foundation.kernel import kernel
from toolkit.foundation.kinematics.orientation import partials_of_quaternion, rotation
from toolkit.foundation.verdict import MOTION, Caution, check
from toolkit.linear.linear_solver import ONE_REFINEMENT_ENOUGH
from toolkit.solvers.direct_solve import SPARSE_FROM_UNKNOWNS
from toolkit.solvers.static.critical_state import StaticEntries, are_positive, has_negative_stiffness, softest_motion
from toolkit.solvers.static.equilibrium import LEVELS, static_matrix
from toolkit.solvers.static.static_matrix import (
    StaticArray,
    balance,
    balanced,
    factorised,
    free_count,
    largest_entry,
    scaled_by,
    whole_array,
)
from toolkit.system.equations import Terms
from toolkit.system.solution import Solution, deforming
from toolkit.system.system import System


class TurningBody(NamedTuple):
    """A flexible body with a frame that moves and turns; of rigid ones the origin is the centre of mass."""

    body: Any
    first: int  # of its coordinates
    elastic: slice  # among them
    centre: np.ndarray  # (d, 1 + n_f) its centre of mass by [1; q_f]

    def stiffness(self, q: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Matrices (k, turns, turns) of states by the body's coordinates (k, size) and what is left of the forces on it (k, d)."""
        centre = self.centre[:, 0] + q[:, self.elastic] @ self.centre[:, 1:].T
        if len(self.centre) == 2:
            angles: Any = q[:, 2]
            axes = np.moveaxis(rotation(angles), -1, 0)
        else:
            axes = np.stack([self.body.frame_axes(each) for each in q])
        return stiffness_of_turns(force, centre, axes, self.body.turns)


def dead_inertia(system: System, q: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Rows (m,), columns (m,) and values (k, m), each at another place, of what all flexible bodies add to the matrices of some states.

    None if there are no such bodies.

    Parameters
    ----------
    q, residual : (k, n)
        Coordinates of the states, and what is left of their forces without inertia.
    """
    rows, columns, values = [], [], []
    for each in system.scene.once(("turning bodies",), lambda: turning_bodies(system)):
        d, body = len(each.centre), each.body
        own = q[:, each.first : each.first + each.elastic.stop]
        at = each.first + body.moves + np.arange(body.turns)
        rows.append(np.repeat(at, body.turns))
        columns.append(np.tile(at, body.turns))
        values.append(each.stiffness(own, residual[:, each.first : each.first + d]).reshape(len(q), -1))
    return (np.concatenate(rows), np.concatenate(columns), np.concatenate(values, axis=1)) if values else None


def turning_bodies(system: System) -> list[TurningBody]:
    """All of a scene; what they are does not depend on a state."""
    found = []
    for name, body in deforming(system.scene).items():
        if body.moves and body.turns in (1, QUATERNION):
            mass, moment = body.some_invariants(system.scene, "mass", "first_moment")
            elastic = slice(body.frame_size, body.frame_size + moment.shape[1] - 1)
            found.append(TurningBody(body, system.numbering.first[name], elastic, np.real(moment) / np.real(mass)))
    return found


def stiffness_of_turns(force: np.ndarray, centre: np.ndarray, axes: np.ndarray, turns: int) -> np.ndarray:
    """Matrices (..., turns, turns) that forces -g (..., d) on centres (..., d) add, with axes A (..., d, d) that an angle or a quaternion
    turns."""
    along = np.einsum("...i,...ij,...j->...", force, axes, centre)[..., None, None]
    if turns == 1:
        return along
    second = np.stack([partials_of_quaternion(unit) for unit in np.eye(QUATERNION)])  # (4, 4, 3, 3)
    found: np.ndarray = 2 * along * np.eye(QUATERNION) - np.einsum("...a,ijab,...b->...ij", force, second, centre)
    return found


DEPENDENT_COLUMNS = 1e-10
"""Part of the largest entry of a triangle's diagonal below which columns may depend on each other: then singular values have to tell."""


def balancing_forces(system: System, terms: Terms) -> np.ndarray:
    """Multipliers (n_lam,) that balance the forces of a state best, in coordinates of comparable size.

    Parameters
    ----------
    system : System
    terms : Terms
        At this state, with multipliers of zero and derivatives.
    """
    n_q, weights = system.n_q, system.weights[: system.n_q]
    wanted = -(terms.inertial + terms.applied)[:n_q] / weights
    if system.n >= SPARSE_FROM_UNKNOWNS and not len(system.plan.dropped):
        ties = scipy.sparse.csc_array(scipy.sparse.diags_array(1 / weights) @ system.matrix(terms.I_acc)[:n_q, n_q:])
        if (found := _least_squares(ties, wanted)) is not None:
            return found
    forces: np.ndarray = np.linalg.lstsq(system.dense(terms.I_acc)[:n_q, n_q:] / weights[:, None], wanted)[0]
    return forces


def balancing_forces_of(system: System, terms: Sequence[Terms]) -> np.ndarray:
    """The same of several states of a scene that is not large, (k, n_lam), by one factorisation Q R of all their ties at once."""
    n_q, entries = system.n_q, StaticEntries.on_pattern(system, np.stack([each.I_acc for each in terms]))
    tied = np.unique(entries.rows[(entries.rows < n_q) & (entries.columns >= n_q)])  # others feel none of them
    weights = system.weights[tied]
    wanted = np.stack([-(each.inertial + each.applied)[tied] / weights for each in terms])
    ties = entries.block(tied, np.arange(n_q, system.n)) / weights[:, None]
    rows, columns = ties.shape[1:]
    if not 0 < columns <= rows:
        return np.stack([np.linalg.lstsq(each, aim)[0] for each, aim in zip(ties, wanted, strict=True)])
    Q, R = np.linalg.qr(ties)
    sizes = np.abs(np.diagonal(R, axis1=1, axis2=2))
    known = sizes.min(axis=1) > DEPENDENT_COLUMNS * sizes.max(axis=1)
    R[~known] = np.eye(columns)
    found: np.ndarray = np.linalg.solve(R, np.einsum("kij,ki->kj", Q, wanted)[..., None])[..., 0]
    for k in np.flatnonzero(~known):
        found[k] = np.linalg.lstsq(ties[k], wanted[k])[0]
    return found


def _least_squares(ties: scipy.sparse.csc_array, wanted: np.ndarray) -> np.ndarray | None:
    """G^+ b from [r 1, G; G^T, 0], refined once; None where the columns of G depend on each other."""
    rows, columns = ties.shape
    matrix = scipy.sparse.csc_array(
        scipy.sparse.block_array([[largest_entry(ties) * scipy.sparse.eye_array(rows), ties], [ties.T, None]])
    )
    given = np.append(wanted, np.zeros(columns))
    try:
        factors = scipy.sparse.linalg.splu(matrix)
    except RuntimeError:  # exactly singular
        return None
    found = factors.solve(given)
    change = factors.solve(given - matrix @ found)
    return (found + change)[rows:] if abs(change).max() <= ONE_REFINEMENT_ENOUGH * abs(found).max() else None


MOST_EXAMINED_STATES, MOST_COMPARED_STATES = 50, 5000
"""Most states whose stability is looked at, and among how many they are chosen."""
LARGEST_STEPS, BETWEEN = 10, (0.25, 0.5, 0.75)
"""How many of the largest steps are looked into, and where."""
LOSS_TOLERANCE = 0.1
"""Part of a step to which the loss of stability is found."""
REST_MOVE = 0.05
"""Part of the model size (or rad) by which the first velocities would move anything in the whole run, below which it begins at rest."""
NEAR_EQUILIBRIUM = 0.1
"""Part of the model size (or rad) by which the first equilibrium is away, below which the run begins near it."""
ZERO_STIFFNESS = 1e-12
"""Part of the largest stiffness below which another is none: a free mechanism."""
ENTRIES_AT_ONCE = 120_000
"""Entries of the matrices of states that are looked at together: 1 MB, so that they stay near the processor."""

Added: TypeAlias = "tuple[np.ndarray, np.ndarray, np.ndarray] | None"
"""Rows (m,), columns (m,) and values (k, m) that come to matrices on the pattern."""


class StatesAtRest(NamedTuple):
    """Some states of a motion as if they were at rest.

    Attributes
    ----------
    residuals : (k, n)
        What is left of their forces.
    values : (k, n_entries)
        Their static matrices on the common pattern, without what is `added`.
    added
        What forces of inertia add to them.
    forces : (k, n)
        [0; lam] of the joint forces that balance them best.
    """

    system: System
    residuals: np.ndarray
    values: np.ndarray
    added: Added
    forces: np.ndarray

    def matrix(self, k: int) -> StaticArray:
        """The static matrix (n, n) of the k-th one."""
        matrix = whole_array(self.system, self.values[k])
        if self.added is None:
            return matrix
        rows, columns, values = self.added
        if isinstance(matrix, np.ndarray):
            matrix[rows, columns] += values[k]
            return matrix
        return matrix + scipy.sparse.coo_array((values[k], (rows, columns)), shape=matrix.shape).tocsr()

    def is_unstable(self, k: int) -> bool:
        """Whether its stiffness is negative against a motion that the joints allow."""
        return has_negative_stiffness(self.system, self.matrix(k), self.forces[k])

    def are_stable(self) -> bool:
        """Whether all of them are known not to be that."""
        static = StaticEntries.on_pattern(self.system, self.values)
        return are_positive(self.system, static if self.added is None else static.added(*self.added))


@check("snaps", (MOTION,))
def snap_through(solution: Solution) -> Iterator[Caution]:
    """The motion passes states in which it could not rest: what follows depends on inertia, damping and steps.

    Limit: a negative stiffness.
    Fix: compare with half the step.

    At some fifty states of the motion, as different from each other as can be, and between those furthest apart of neighbouring ones, the
    static stiffness against all motions that the joints allow is examined, under the loads of their time, the joint forces that
    balance them best, and forces of inertia that hold what these leave.
    """
    system = solution.system
    if not (system.compiled and solution.steps and free_count(system) and _begins_at_rest(solution)):
        return
    places = _places(solution)
    first = _first_unstable(solution, places)
    if first is not None:
        yield _caution(solution, *_first_loss(solution, places[first - 1] if first else 0.0, places[first]))


def _first_unstable(solution: Solution, places: list[float]) -> int | None:
    """Number of the first of some states that is unstable; those of scenes that are not large are looked at together."""
    system, curves = solution.system, _curves(solution, places)
    together = max(ENTRIES_AT_ONCE // len(system.plan.indices), 1) if system.n < SPARSE_FROM_UNKNOWNS else 1
    for begin in range(0, len(places), together):
        some = range(begin, min(begin + together, len(places)))
        part = slice(some.start, some.stop)
        states = _at_rest(solution, places[part], (curves[0][part], curves[1][part]))
        if len(some) > 1 and states.are_stable():
            continue
        for k in some:
            if states.is_unstable(k - begin):
                return k
    return None


def _places(solution: Solution) -> list[float]:
    """Numbers of states, with fractions for what lies between, in the order of time."""
    n_b = solution.system.n_b
    q = solution.q[:, :n_b] * solution.system.weights[:n_b]
    jumps = ((q[1:] - q[:-1]) ** 2).sum(axis=1)
    largest = np.argsort(jumps, kind="stable")[-LARGEST_STEPS:]
    between = [n + part for n in largest if jumps[n] > 0 for part in BETWEEN]
    return sorted({*map(float, _different(q)), *map(float, between)})


def _different(q: np.ndarray) -> list[int]:
    """Numbers of states (n_t, n_q), the first among them: each was chosen as the one furthest from those before it."""
    stride = -(-len(q) // MOST_COMPARED_STATES)
    q = np.ascontiguousarray(q[::stride])
    chosen = np.zeros(min(MOST_EXAMINED_STATES, len(q)), np.int64)
    call(choose_apart, q, np.full(len(q), np.inf), chosen)
    return [stride * int(n) for n in chosen]


@kernel
def choose_apart(q, distance, chosen):
    """Numbers of states q (n_t, n): after the first one each time that which is furthest from all before; `distance` (n_t,) is infinite."""
    for c in range(1, len(chosen)):
        last, furthest = chosen[c - 1], 0
        for n in range(len(q)):
            square = 0.0
            for i in range(q.shape[1]):
                square += (q[n, i] - q[last, i]) ** 2
            distance[n] = min(distance[n], square)
            if distance[n] > distance[furthest]:
                furthest = n
        chosen[c] = furthest


def _begins_at_rest(solution: Solution) -> bool:
    """Whether the run begins slowly, near an equilibrium that is stable by a stiffness of its own."""
    system = solution.system
    n_b, weights = system.n_b, system.weights[: system.n_b]
    if (weights * np.abs(solution.v[0, :n_b])).max() * (solution.times[-1] - solution.times[0]) > REST_MOVE:
        return False
    state = _one_at_rest(solution, 0.0)
    matrix, residual = state.matrix(0), state.residuals[0]
    scale = balance(system, matrix)
    largest = largest_entry(scaled_by(matrix, scale)[:n_b, :n_b])
    if not softest_motion(system, matrix)[0] > ZERO_STIFFNESS * largest:  # first, as it takes sparse factors alone
        return False
    if has_negative_stiffness(system, matrix, state.forces[0]):
        return False
    try:
        if isinstance(matrix, np.ndarray):
            way = scale * np.linalg.solve(balanced(system, matrix, scale), scale * residual)
        else:
            way = factorised(system, matrix, scale).solve(residual)
    except (SingularSystemError, np.linalg.LinAlgError):
        return False
    return bool((weights * np.abs(way[:n_b])).max() <= NEAR_EQUILIBRIUM)


def _one_at_rest(solution: Solution, place: float) -> StatesAtRest:
    """A state as if it were at rest."""
    return _at_rest(solution, [place], _curves(solution, [place]))


def _curves(solution: Solution, places: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """What acts at some states."""
    return solution.system.curves(np.array([_state(solution, place)[0] for place in places]))


def _at_rest(solution: Solution, places: list[float], curves: tuple[np.ndarray, np.ndarray]) -> StatesAtRest:
    """Several states as if they were at rest, with what acts at them."""
    system, n_q = solution.system, solution.system.n_q
    q, forces, rest = np.zeros((3, len(places), system.n))
    q[:, :n_q] = [_state(solution, place)[1] for place in places]
    terms = system.evaluate_states(curves, LEVELS, q, rest, rest)
    alone = system.n >= SPARSE_FROM_UNKNOWNS or len(places) == 1
    forces[:, n_q:] = balancing_forces(system, terms[0]) if alone else balancing_forces_of(system, terms)
    terms = system.evaluate_states(curves, LEVELS, q, rest, forces)
    residuals = np.stack([each.inertial + each.applied for each in terms])
    values = np.stack([np.real(static_matrix(system, each)) for each in terms])
    return StatesAtRest(system, residuals, values, dead_inertia(system, q, residuals), forces)


def _state(solution: Solution, place: float) -> tuple[float, np.ndarray]:
    """Time and coordinates, half of each neighbour half way between them: their velocities may be of vibrations that no step resolves."""
    n = min(int(place), len(solution.times) - 2)
    part = place - n
    time = (1 - part) * solution.times[n] + part * solution.times[n + 1]
    return float(time), (1 - part) * solution.q[n] + part * solution.q[n + 1]


def _is_unstable(solution: Solution, place: float) -> bool:
    return _one_at_rest(solution, place).is_unstable(0)


def _first_loss(solution: Solution, low: float, high: float) -> tuple[float, float]:
    """Places close together between which stability is lost, from a stable and a later unstable one."""
    while high - low > LOSS_TOLERANCE:
        middle = (low + high) / 2
        low, high = (low, middle) if _is_unstable(solution, middle) else (middle, high)
    return low, high


def _caution(solution: Solution, low: float, high: float) -> Caution:
    coordinate = solution.system.most_moved(softest_motion(solution.system, _one_at_rest(solution, low).matrix(0))[1])
    return snap_through.caution(
        f"the motion snaps through: from t = {_state(solution, high)[0]:.4g} on the stiffness against a motion of {coordinate} is "
        "negative, and the scene could not rest. What follows depends on inertia, damping and steps. Fix: compare with half the step. "
        "ffrf statics --past-limit finds equilibria beyond it.",
        doubt=False,
    )
