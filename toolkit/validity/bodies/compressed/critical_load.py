"""Critical loads of flexible bodies: linear FFRF has no geometric stiffness, so that a body under compression never buckles in its frame.

Among all states of a run those are looked at in which compression takes most of the elastic stiffness of a body, see
`toolkit.validity.bodies.compressed.missed_deflections`. Where no body loses more than a small part of its elastic stiffness in its own
frame, nothing is missing, and the whole scene need not be looked at: so it is with a column of many short bodies, which buckles in the
equations.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from toolkit.foundation.near_ties import first_largest
from toolkit.system.flexible_bodies import elastic_coordinates
from toolkit.system.solution import Solution
from toolkit.validity.bodies.compressed.geometric_stiffness import Stiffening, stiffening
from toolkit.validity.bodies.compressed.missed_deflections import missed, misses_less
from toolkit.validity.bodies.deformation import flexible_bodies

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
FELT = 1e-3
"""Part of its elastic stiffness that a body may lose in its own frame without the whole scene being looked at: a column of several frames
whose parts lose no more is half as stiff as these equations say within a thousandth of its critical load."""
AMONG = 5000
"""The meter looks for the largest compression among at most so many states of a run."""
STATES = 3
"""Of so many the whole scene is looked at."""
BOUNDLESS = 1e9
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
    while max(parts, default=0.0) > FELT and len(found) < STATES:
        largest = first_largest(np.array(parts))
        found.setdefault(*places.pop(largest))
        parts.pop(largest)
    return found


def most_compressed(law: Stiffening, elastic: np.ndarray) -> list[int]:
    """Numbers of the states (n_t, n_f) whose compression softens the whole body most, and one element of it; in space, where bending and
    twist soften it too, that of the largest elastic energy besides."""
    stride = -(-len(elastic) // AMONG)
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
