"""Critical loads of flexible bodies: linear FFRF has no geometric stiffness, so that a body under compression never buckles in its frame.

With the stiffness K_0 of the unloaded scene at a state, what the forces of that state add to it in the equations, K_1, and the geometric
stiffness G of its elements, which the equations lack, the state is critical at lambda times its forces, where

    (K_0 + lambda (K_1 + G)) x = 0,    phi_q x = 0,    mu = 1 / lambda

The meter is by how much the equations miss the deflections that small lateral loads add at the state, at most over all such loads:

    max kappa - 1,    (K_0 + K_1) x = kappa (K_0 + K_1 + G) x,    without bound from mu = 1 on

which is mu / (1 - mu) where the frames do not turn, so that K_1 = 0. Where they turn, K_1 without G can take stiffness away under tension,
too: a hinged bar whose frame is tied to its one end gives way at 3 EI / L^2. With mu_1 of K_1 alone an equilibrium's deflections are
feigned by the part (mu_1 - mu) / (1 - mu_1); of motions it is not said, because spinning bodies have forces of inertia in K_1.

Motions without any stiffness in K_0, those of a mechanism, follow the others: at rest so that they stay in balance, in a motion so that
their momentum is zero. Where no body loses more than a small part of its elastic stiffness in its own frame, nothing is missing, and
the whole scene need not be looked at: so it is with a column of many short bodies, which buckles in the equations.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from toolkit.foundation.near_ties import first_largest
from toolkit.solvers.free_motions import free_motions
from toolkit.solvers.static.equilibrium import LEVELS, static_matrix
from toolkit.system.flexible_bodies import elastic_coordinates
from toolkit.system.solution import Solution
from toolkit.validity.bodies.deformation import flexible_bodies
from toolkit.validity.bodies.geometric_stiffness import Stiffening, stiffening

LIMIT = 0.05
"""Part of a deflection that the equations may miss without a word; the same as that of the meter of large deformation."""
DOUBTFUL = 0.5
"""The same from which it is a doubt: a third of the critical load in a fixed frame. Below, what a run was asked for may not feel it."""
AMONG = 5000
"""The meter looks for the largest compression among at most so many states of a run."""
STATES = 3
"""Of so many the whole scene is looked at."""
BOUNDLESS = 1e9
"""Stands for a missed part without bound where states are compared."""
STILL = 1e-12
"""Stiffness of a motion, in coordinates of unit stiffness, below which it has none: a column of 20 bodies and 400 elements has 7e-11, a
free motion 1e-17."""
UNSYMMETRIC = 1e-9
"""Part of the largest entry by which following forces make the stiffness unsymmetric at least."""


class Compression(NamedTuple):
    """How near to its critical load the body is that compression softens most."""

    body: str
    time: float
    load: float  # mu: the forces in parts of the critical ones; zero if none are critical
    missed: float  # part of deflections by small lateral loads that the equations miss, at most
    feigned: float  # of an equilibrium: part by which they are too large at least, where the equations are softer than the body


def compression(solution: Solution) -> Compression | None:
    """The state nearest to a critical load; None where nothing is missing, or nothing is known."""
    scene = solution.system.scene
    known = {body: found for body in flexible_bodies(scene) if (found := stiffening(scene, body))}
    states = [
        Compression(body, float(solution.times[n]), *_missed(solution, known, n)) for n, body in _softest(solution, known).items()
    ]
    if not states:
        return None
    return states[first_largest(np.array([min(max(each.missed, each.feigned), BOUNDLESS) + each.load for each in states]))]


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
    while max(parts, default=0.0) > LIMIT and len(found) < STATES:
        largest = first_largest(np.array(parts))
        found.setdefault(*places.pop(largest))
        parts.pop(largest)
    return found


def most_compressed(law: Stiffening, elastic: np.ndarray) -> list[int]:
    """Numbers of the states (n_t, n_f) whose compression softens the whole body most, and one element of it."""
    stride = -(-len(elastic) // AMONG)
    lost = -(elastic[::stride] @ law.forces.T) * law.compliances
    found = {stride * first_largest(measure) for measure in (lost.sum(axis=1), lost.max(axis=1)) if measure.max() > 0}
    return sorted(found)


def _missed(solution: Solution, known: dict[str, Stiffening], n: int) -> tuple[float, float, float]:
    """Forces in parts of the critical ones, and parts of deflections that the equations miss and feign, at one state."""
    at_rest, forces, geometric, inertia = _stiffnesses(solution, known, n)
    stiffness, motions = _stiff_motions(at_rest)

    def change(of_forces: np.ndarray) -> np.ndarray:
        follow = _followed(motions, of_forces if inertia is None else inertia) / np.sqrt(stiffness)
        found: np.ndarray = follow.T @ of_forces @ follow
        return found

    true, captured = change(forces + geometric), change(forces)
    load, own, unit = _largest(-true), _largest(-captured), np.eye(len(stiffness))
    missed = max(_largest(np.linalg.solve(unit + true, unit + captured)) - 1, 0.0) if load < 1 else np.inf
    feigned = 0.0 if solution.steps or own <= load else (own - load) / (1 - own) if own < 1 else np.inf
    return load, missed, feigned


def _stiffnesses(
    solution: Solution, known: dict[str, Stiffening], n: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray | None]:
    """K_0, K_1, G and, of a motion, M at one state against the motions that joints allow, in coordinates of unit stiffness."""
    system, n_q = solution.system, solution.system.n_q
    pad, rest = np.zeros(system.n - n_q), np.zeros(system.n)
    q, v = (np.append(np.real(state[n]), pad) for state in (solution.q, solution.v))
    acc = np.real(np.append(solution.a[n], solution.multipliers[n]))
    inputs = system.inputs(float(solution.times[n]), LEVELS)
    bare = system.evaluate(system.inputs(float(solution.times[n]), LEVELS, 0.0), q, rest, rest)
    loaded = system.evaluate(inputs, q, v, acc)
    of_bare, of_loaded = (np.real(system.dense(static_matrix(system, terms)))[:n_q, :n_q] for terms in (bare, loaded))
    I_acc = np.real(system.dense(loaded.I_acc))
    geometric = np.zeros((n_q, n_q))
    for body, law in known.items():
        where = elastic_coordinates(solution, body)
        geometric[where, where] = law.matrix(np.real(solution.q[n, where]))
    weights = system.weights[:n_q]
    diagonal = np.diag(of_bare) / weights**2
    stiff = diagonal > STILL * diagonal.max()
    scale = weights * np.sqrt(np.where(stiff, diagonal, diagonal[stiff].min(initial=np.inf)))
    free = free_motions(I_acc[:n_q, n_q:].T, scale)
    reduced = [free.T @ each @ free for each in (of_bare, of_loaded - of_bare, geometric, I_acc[:n_q, :n_q])]
    return reduced[0], reduced[1], reduced[2], reduced[3] if solution.steps else None


def _stiff_motions(at_rest: np.ndarray) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """Positive stiffnesses (n,), their motions, and all others."""
    values, vectors = np.linalg.eigh((at_rest + at_rest.T) / 2)
    stiff = values > STILL
    return values[stiff], (vectors[:, stiff], vectors[:, ~stiff])


def _followed(motions: tuple[np.ndarray, np.ndarray], form: np.ndarray) -> np.ndarray:
    """Stiff motions, with as much of those without stiffness as makes them orthogonal to these in a form."""
    stiff, loose = motions
    if not loose.shape[1]:
        return stiff
    return stiff - loose @ np.linalg.lstsq(loose.T @ form @ loose, loose.T @ form @ stiff, rcond=STILL)[0]


def _largest(matrix: np.ndarray) -> float:
    """The largest positive real eigenvalue, zero if there is none."""
    if not len(matrix):
        return 0.0
    if np.abs(matrix - matrix.T).max() <= UNSYMMETRIC * np.abs(matrix).max():
        return max(float(np.linalg.eigvalsh((matrix + matrix.T) / 2)[-1]), 0.0)
    values = np.linalg.eigvals(matrix)
    return float(values.real[np.abs(values.imag) <= UNSYMMETRIC * np.abs(values)].max(initial=0.0))


def critical_compressions(solution: Solution) -> Iterator[tuple[Compression, bool]]:
    """The state nearest to a critical load, if deflections there are off by more than `LIMIT`, and whether to doubt."""
    found = compression(solution)
    if found is not None and (worst := max(found.missed, found.feigned)) > LIMIT:
        yield found, not worst <= DOUBTFUL
