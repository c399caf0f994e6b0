"""Critical loads of flexible bodies: linear FFRF has no geometric stiffness, so that a body under compression never buckles in its frame.

What the equations miss of deflections where forces compress flexible bodies, at one state of a scene.

With the stiffness K_0 of the unloaded scene at a state, what the forces of that state add to it in the equations, K_1, and the geometric
stiffness G of its elements, which the equations lack, the state is critical at lambda times its forces, where

    (K_0 + lambda (K_1 + G)) x = 0,    phi_q x = 0,    mu = 1 / lambda

The meter is by how much the equations miss the deflections that small lateral loads add at the state, at most over all such loads:

    max kappa - 1,    (K_0 + K_1) x = kappa (K_0 + K_1 + G) x,    without bound from mu = 1 on

which is mu / (1 - mu) where the frames do not turn, so that K_1 = 0. Where they turn, K_1 without G can take stiffness away under tension,
too: a hinged bar whose frame is tied to its one end gives way at 3 EI / L^2. With mu_1 of K_1 alone an equilibrium's deflections are
feigned by the part (mu_1 - mu) / (1 - mu_1); of motions and steady spins it is not said, because spinning bodies have forces of inertia in
K_1.

Motions without any stiffness in K_0, those of a mechanism, follow the others: at rest so that they stay in balance, in a motion so that
their momentum is zero.

Among all states of a run those are looked at in which compression takes most of the elastic stiffness of a body, see
`toolkit.validity.bodies.critical_load`. Where no body loses more than a small part of its elastic stiffness in its own
frame, nothing is missing, and the whole scene need not be looked at: so it is with a column of many short bodies, which buckles in the
equations.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
import scipy

from toolkit.foundation.near_ties import first_largest
from toolkit.solvers.direct_solve import SPARSE_FROM_UNKNOWNS
from toolkit.solvers.free_motions import UNSYMMETRIC_PART, free_motions, is_symmetric
from toolkit.solvers.static.equilibrium import LEVELS
from toolkit.solvers.static.static_matrix import StaticArray, as_dense, is_positive, static_array, whole_array
from toolkit.system.solution import Solution, elastic_coordinates
from toolkit.system.system import System
from toolkit.validity.bodies.deformation import flexible_bodies
from toolkit.validity.bodies.geometric_stiffness import Flexibility, Stiffening, flexibility, largest_ratio, stiffening

NO_STIFFNESS = 1e-12
"""Stiffness of a motion, in coordinates of unit stiffness, below which it has none: a column of 20 bodies and 400 elements has 7e-11, a
free motion 1e-17."""


def missed(solution: Solution, known: dict[str, Stiffening], n: int) -> tuple[float, float, float]:
    """Forces in parts of the critical ones, and parts of deflections that the equations miss and feign, at one state."""
    state = _state(solution, known, n)
    load, own, found = _of_many(state) or _of_few(state)
    feigned = 0.0 if solution.steps or solution.spins or own <= load else (own - load) / (1 - own) if own < 1 else np.inf
    return load, found, feigned


def misses_less(solution: Solution, known: dict[str, Stiffening], n: int, part: float) -> bool:
    """Whether the equations are known to miss a smaller part of deflections at a state of a motion, for the price of one factorisation.

    They do if, against all motions that joints allow, part (K_0 + K_1) + (1 + part) G is positive definite: then kappa - 1 is below it.
    Where matrices are large or not symmetric, or loads have states, nothing is known.
    """
    system, n_q = solution.system, solution.system.n_q
    if not (solution.steps or solution.spins) or system.n >= SPARSE_FROM_UNKNOWNS or n_q > system.n_b:
        return False
    q, v = (np.append(np.real(state[n]), np.zeros(system.n - n_q)) for state in (solution.q, solution.v))
    acc = np.real(np.append(solution.a[n], solution.multipliers[n]))
    matrix = as_dense(static_array(system, system.evaluate(system.inputs(float(solution.times[n]), LEVELS), q, v, acc)))
    matrix[:n_q, :n_q] *= part
    for body, law in known.items():
        where = elastic_coordinates(solution, body)
        matrix[where, where] += (1 + part) * as_dense(law.matrix(np.real(solution.q[n, where])))
    return is_positive(system, matrix)


class _State(NamedTuple):
    """Static matrices [K, G; J, 0] of a state without its forces and with them, (n, n), and geometric stiffness and mass (n_q, n_q)."""

    system: System
    bare: StaticArray
    loaded: StaticArray
    geometric: StaticArray
    mass: StaticArray | None  # of a motion


def _state(solution: Solution, known: dict[str, Stiffening], n: int) -> _State:
    system, n_q = solution.system, solution.system.n_q
    pad, rest = np.zeros(system.n - n_q), np.zeros(system.n)
    q, v = (np.append(np.real(state[n]), pad) for state in (solution.q, solution.v))
    acc = np.real(np.append(solution.a[n], solution.multipliers[n]))
    inputs = system.inputs(float(solution.times[n]), LEVELS)
    bare = static_array(system, system.evaluate(system.inputs(float(solution.times[n]), LEVELS, 0.0), q, rest, rest))
    terms = system.evaluate(inputs, q, v, acc)
    geometric = np.zeros((n_q, n_q)) if isinstance(bare, np.ndarray) else scipy.sparse.lil_array((n_q, n_q))
    for body, law in known.items():
        where = elastic_coordinates(solution, body)
        geometric[where, where] = law.matrix(np.real(solution.q[n, where]))
    mass = whole_array(system, np.real(terms.I_acc))[:n_q, :n_q] if solution.steps else None
    return _State(system, bare, static_array(system, terms), geometric, mass)


def _of_many(state: _State) -> tuple[float, float, float] | None:
    """mu with and without what the equations miss, and the part of deflections that they do; None of few coordinates, or where it takes
    dense matrices to tell: of mechanisms, of following forces, and where nothing is compressed.

    Of mu without it is told only whether it is the larger one, and then how large it is.
    """
    if isinstance(state.bare, np.ndarray):
        return None
    n_q, geometric = state.system.n_q, scipy.sparse.csr_array(state.geometric)
    at_rest, softened = state.bare[:n_q, :n_q], state.loaded[:n_q, :n_q]
    forces = softened - at_rest
    if not (is_symmetric(forces) and (yielding := _flexibility(state, at_rest))):
        return None
    load = largest_ratio(-(forces + geometric), at_rest, yielding)
    if load is None or load <= 0:
        return None
    own = 0.0 if _flexibility(state, load * at_rest + forces) else largest_ratio(-forces, at_rest, yielding)
    soft = _flexibility(state, softened + geometric) if load < 1 else None
    found = np.inf if load >= 1 else largest_ratio(-geometric, softened + geometric, soft) if soft else None
    return None if own is None or found is None else (load, own, max(found, 0.0))


def _flexibility(state: _State, stiffness: StaticArray) -> Flexibility | None:
    """What yields to forces where the joints are as they are, and the stiffness (n_q, n_q) is another one."""
    n_q = state.system.n_q
    columns, rows = state.bare[:n_q, n_q:], state.bare[n_q:, :n_q]
    return flexibility(
        state.system, scipy.sparse.csr_array(scipy.sparse.block_array([[stiffness, columns], [rows, state.bare[n_q:, n_q:]]]))
    )


def _of_few(state: _State) -> tuple[float, float, float]:
    """The same by dense matrices."""
    at_rest, forces, geometric, inertia = _among_free(state)
    stiffness, motions = _stiff_motions(at_rest)

    def change(of_forces: np.ndarray) -> np.ndarray:
        follow = _followed(motions, of_forces if inertia is None else inertia) / np.sqrt(stiffness)
        found: np.ndarray = follow.T @ of_forces @ follow
        return found

    true, captured = change(forces + geometric), change(forces)
    load, own, unit = _largest(-true), _largest(-captured), np.eye(len(stiffness))
    missed = max(_largest(np.linalg.solve(unit + true, unit + captured)) - 1, 0.0) if load < 1 else np.inf
    return load, own, missed


def _among_free(state: _State) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray | None]:
    """K_0, K_1, G and, of a motion, M against the motions that joints allow, in coordinates of unit stiffness."""
    system, n_q = state.system, state.system.n_q
    bare, loaded = as_dense(state.bare), as_dense(state.loaded)
    at_rest, weights = bare[:n_q, :n_q], system.weights[:n_q]
    diagonal = np.diag(at_rest) / weights**2
    stiff = diagonal > NO_STIFFNESS * diagonal.max()
    scale = weights * np.sqrt(np.where(stiff, diagonal, diagonal[stiff].min(initial=np.inf)))
    free = free_motions(loaded[:n_q, n_q:].T, scale)
    parts = [at_rest, loaded[:n_q, :n_q] - at_rest, as_dense(state.geometric)]
    of_rest, of_forces, geometric = (free.T @ each @ free for each in parts)
    return of_rest, of_forces, geometric, None if state.mass is None else free.T @ as_dense(state.mass) @ free


def _stiff_motions(at_rest: np.ndarray) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """Positive stiffnesses (n,), their motions, and all others."""
    values, vectors = np.linalg.eigh((at_rest + at_rest.T) / 2)
    stiff = values > NO_STIFFNESS
    return values[stiff], (vectors[:, stiff], vectors[:, ~stiff])


def _followed(motions: tuple[np.ndarray, np.ndarray], form: np.ndarray) -> np.ndarray:
    """Stiff motions, with as much of those without stiffness as makes them orthogonal to these in a form."""
    stiff, loose = motions
    if not loose.shape[1]:
        return stiff
    return stiff - loose @ np.linalg.lstsq(loose.T @ form @ loose, loose.T @ form @ stiff, rcond=NO_STIFFNESS)[0]


def _largest(matrix: np.ndarray) -> float:
    """The largest positive real eigenvalue, zero if there is none."""
    if not len(matrix):
        return 0.0
    if is_symmetric(matrix):
        return max(float(np.linalg.eigvalsh((matrix + matrix.T) / 2)[-1]), 0.0)
    values = np.linalg.eigvals(matrix)
    return float(values.real[np.abs(values.imag) <= UNSYMMETRIC_PART * np.abs(values)].max(initial=0.0))


ROUND_OFF = 1e-6
"""Part of the largest of q, in units of the model size, below which the deflection K^-1 G q is that of round-off: forces along a hinged
bar bend it by 4e-11 of what they shorten it with 20 elements, by 7e-8 with 300. What is there still is as small, and ten times that
at 0.9 of the critical load."""


def stays_straight(solution: Solution, known: Mapping[str, Stiffening]) -> bool:
    """Whether no body feels in an equilibrium, nor in the derivatives that it was solved with, what the equations lack of its stiffness."""
    if solution.steps or solution.spins:
        return False
    for body, law in known.items():
        where = elastic_coordinates(solution, body)
        weights, elastic = solution.system.weights[where], np.real(solution.q[0, where])
        moved = np.column_stack([elastic, np.real(solution.dq[0, where])])
        felt, size = (np.abs(weights[:, None] * each).max(axis=0) for each in (law.deflections(elastic, moved), moved))
        if not np.all(felt <= ROUND_OFF * size):
            return False
    return True


LIMIT = 0.05
"""Part of a deflection that the equations may miss; the same as that of the meter of large deformation, which does not know by how much a
whole near its critical load makes what its parts miss larger."""
STIFFNESS_LOSS = 1e-3
"""Part of its elastic stiffness that a body may lose in its own frame without the whole scene being looked at: a column of several frames
whose parts lose no more is half as stiff as these equations say within a thousandth of its critical load."""
MOST_COMPARED_STATES = 5000
"""The meter looks for the largest compression among at most so many states of a run."""
EXAMINED_STATES = 3
"""Of so many the whole scene is looked at."""
UNBOUNDED_PART = 1e9
"""Stands for a missed part without bound where states are compared."""


class Compression(NamedTuple):
    """How near to its critical load the body is that compression softens most."""

    body: str
    time: float
    load: float  # mu: the forces in parts of the critical ones; zero if none are critical
    missed: float  # part of deflections by small lateral loads that the equations miss, at most
    feigned: float  # of an equilibrium: part by which they are too large at least, where the equations are softer than the body
    straight: bool  # whether it is an equilibrium that no lateral load bends, so that nothing of this is in it


def compression(solution: Solution, of_interest: float = 0.0) -> Compression | None:
    """The state nearest to a critical load; None where nothing is missing, or nothing is known.

    So it is, too, where less than a part of interest is known to be missing in all states: to know that takes less time.
    """
    scene = solution.system.scene
    known = {body: found for body in flexible_bodies(scene) if (found := stiffening(scene, body))}
    softest = _softest(solution, known)
    if of_interest and all(misses_less(solution, known, n, of_interest) for n in softest):
        return None
    straight = bool(softest) and stays_straight(solution, known)
    states = [Compression(body, float(solution.times[n]), *missed(solution, known, n), straight) for n, body in softest.items()]
    if not states:
        return None
    return states[first_largest(np.array([min(max(each.missed, each.feigned), UNBOUNDED_PART) + each.load for each in states]))]


def _softest(solution: Solution, known: dict[str, Stiffening]) -> dict[int, str]:
    """Numbers of the states in which compression takes most of the elastic stiffness of a body, and this body."""
    places, parts = [], []
    for body, law in known.items():
        elastic = np.real(solution.q[:, elastic_coordinates(solution, body)])
        for sense in (1.0,) if solution.steps else (1.0, -1.0):
            for n in most_compressed(law, sense * elastic):
                places.append((n, body))
                parts.append(law.softening(sense * elastic[n]))
    found: dict[int, str] = {}
    while max(parts, default=0.0) > STIFFNESS_LOSS and len(found) < EXAMINED_STATES:
        largest = first_largest(np.array(parts))
        found.setdefault(*places.pop(largest))
        parts.pop(largest)
    return found


def most_compressed(law: Stiffening, elastic: np.ndarray) -> list[int]:
    """Numbers of the states (n_t, n_f) whose compression softens the whole body most, and one element of it; in space, where bending and
    twist soften it too, that of the largest elastic energy besides."""
    stride = -(-len(elastic) // MOST_COMPARED_STATES)
    lost = -(elastic[::stride] @ law.forces.T) * law.compliances
    measures = [lost.sum(axis=1), lost.max(axis=1)]
    if law.behind.stiffening.shape[1] > 1:
        measures.append(np.sum(elastic[::stride] @ law.stiffness * elastic[::stride], axis=1))
    return sorted({stride * first_largest(measure) for measure in measures if measure.max() > 0})


def critical_compressions(solution: Solution) -> Iterator[Compression]:
    """The state nearest to a critical load, if deflections there are off by more than `LIMIT`."""
    found = solution.known[Compression] = compression(solution, of_interest=LIMIT)
    if found is not None and max(found.missed, found.feigned) > LIMIT:
        yield found
