"""Forces along bodies whose bases hold no shape that stretches them: what they do to deflections is in no equation, and is found by hand.

Known are the forces at the interface points, those of loads and joints, and those of weight and inertia. What the basis misses of the
axial forces N of the elements under them has the geometric stiffness G, and deflections z of the equations, with the compliance Y of the
whole scene, should be z + d:

    (1 + Y G) d = -Y G z
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import NamedTuple

import numpy as np

from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.verdict import Caution
from toolkit.solvers.static.static_matrix import as_dense
from toolkit.system.flexible_bodies import elastic_coordinates
from toolkit.system.solution import Solution
from toolkit.validity.bodies.compressed.forces_at_points import forces_at_points
from toolkit.validity.bodies.compressed.geometric_stiffness import Stiffening, stiffening
from toolkit.validity.bodies.compressed.yielding_scene import yielding
from toolkit.validity.bodies.cut.more_frames import divided
from toolkit.validity.bodies.deformation import LIMIT, instants_of

LOOKED_AT = 24
"""Instants, evenly spread over the motion, among which the largest force along a body is looked for."""
MANY = 20.0
"""Times that a number is off above which they are not counted."""


class Unseen(NamedTuple):
    """What forces along a body do that its basis does not see."""

    time: float
    load: float  # in parts of what makes the scene give way; negative in tension
    off: float  # part of the deflection: how much is missing, or too much if negative; inf from the critical load on


def unseen_forces(
    solution: Solution, body: str, missing: Mapping[str, np.ndarray], by_mass: Callable[[np.ndarray], np.ndarray]
) -> Iterator[Caution]:
    """Doubts about one body.

    Parameters
    ----------
    missing
        Interface point -> axial forces (d, n_e) under unit forces there that the basis does not show.
    by_mass
        From numbers of instants (n_t,) to axial forces (n_t, n_e) by weight and inertia that it does not show.
    """
    law = stiffening(solution.system.scene, body)
    if law is not None:
        states = [(n, as_dense(law.of_axial(axial))) for n, axial in _states(solution, body, law, missing, by_mass)]
        yield from doubts_of_unseen(solution, body, states, partial(_distances, law))


def doubts_of_unseen(
    solution: Solution, body: str, states: Iterable[tuple[int, np.ndarray]], distances: Callable[[np.ndarray], np.ndarray]
) -> Iterator[Caution]:
    """A doubt about the worst of some states of one body.

    Parameters
    ----------
    states
        Numbers of states, and the geometric stiffness G (n_f, n_f) there that no equation knows.
    distances
        From elastic coordinates (n_t, n_f) to the largest displacements (n_t,).
    """
    known = [found for n, stiffness in states if (found := _at(solution, body, n, stiffness, distances)) is not None]
    if known:
        worst = known[first_largest(np.array([min(np.abs(each.off), MANY) for each in known]))]
        if not np.abs(worst.off) <= LIMIT:
            part = worst.off if worst.load > 0 else -worst.off / (1 + worst.off) if worst.off > -1 else np.inf
            yield Caution("critical-load" if worst.load > 0 else "tension", _told(solution, body, worst), body=body, part=part)


def _states(
    solution: Solution,
    body: str,
    law: Stiffening,
    missing: Mapping[str, np.ndarray],
    by_mass: Callable[[np.ndarray], np.ndarray],
) -> Iterator[tuple[int, np.ndarray]]:
    """Numbers of the states of most compression and of most tension, and the axial forces (n_e,) there that the basis does not show."""
    instants = np.unique(np.linspace(0, len(solution.times) - 1, LOOKED_AT).astype(int))
    forces = forces_at_points(solution, body, instants) if missing else {}
    axial = sum((forces[name] @ each for name, each in missing.items() if name in forces), by_mass(instants))
    softer = -(axial * law.compliances).sum(axis=1)
    for sign in (1.0, -1.0):
        k = first_largest(sign * softer)
        if sign * softer[k] > LIMIT / 2:
            yield int(instants[k]), axial[k]


def _at(
    solution: Solution, body: str, n: int, stiffness: np.ndarray, distances: Callable[[np.ndarray], np.ndarray]
) -> Unseen | None:
    where, yields = elastic_coordinates(solution, body), yielding(solution, n)
    elastic = np.real(solution.q[:, where])
    largest = elastic[instants_of(solution, body)]
    z = largest[first_largest(distances(largest))]
    size = float(distances(z[None])[0])
    if yields is None or not size > 0:
        return None
    unit = np.zeros((solution.system.n_q, elastic.shape[1]))
    unit[where] = np.eye(elastic.shape[1])
    compliance = np.stack([yields(each)[where] for each in unit.T], axis=1)
    added = compliance @ stiffness
    softened = -np.linalg.eigvals(added).real
    load = float(softened.max() if softened.max() > -softened.min() else softened.min())
    if load >= 1:
        return Unseen(float(solution.times[n]), load, np.inf)
    change = -np.linalg.solve(np.eye(len(added)) + added, added @ z)
    part = float(distances(change[None])[0]) / size
    return Unseen(float(solution.times[n]), load, part if load > 0 else -part)


def _distances(law: Stiffening, elastic: np.ndarray) -> np.ndarray:
    return np.array([law.behind.distances(law.behind.displacements(each[None])).max() for each in elastic])


def _told(solution: Solution, body: str, found: Unseen) -> str:
    when = f" at t = {found.time:.4g}" if solution.steps else ""
    how = "compress" if found.load > 0 else "pull at"
    if found.off == np.inf:
        what = "it buckles if that lasts, which these numbers do not show"
    elif found.load > 0:
        what = f"its deflections lack {found.off:.2g} times themselves, and frequencies are lower"
    else:
        what = _stiffer(found)
    return (
        f"forces {how} {body}{when} with {np.abs(found.load):.2g} times the critical load, which its basis does not show: "
        f"{what}. Linear FFRF has no geometric stiffness of a body in its frame. Fix: "
        f"{divided(solution.system.scene, body, 1.0)}."
    )


def _stiffer(found: Unseen) -> str:
    times = 1 / (1 + found.off) if found.off > -1 else np.inf
    told = f"{times:.3g} times" if times < MANY else "many times"
    return f"its deflections are {told} as large as they should be, and frequencies across it are higher"
