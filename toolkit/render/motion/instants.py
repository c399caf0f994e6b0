"""Which instants of a motion are drawn, if nobody asks for others: those at which something happens."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.spread import spread

ALIKE = 0.1
"""Two instants look alike if no point is further from its other place than this part of the longest way between any two instants,
and their largest stresses do not differ by this part of the largest of all."""
STILL = 1e-9
"""A motion that nobody sees, relative to the largest coordinate."""
LOOKED_AT = 120
"""Instants of a motion at most that are compared, beside that of the largest stress, which is sought among all."""


def telling_steps(count: int, points: Callable[[int], np.ndarray], stress: np.ndarray) -> list[int]:
    """Numbers of steps of a motion to draw.

    These are the last one, that of the largest stress, the one at which a point is furthest from where it started, and the start, without
    those that look like another; where there are fewer than wanted, more that are each as different from the others as can be.

    Parameters
    ----------
    count : int
        How many are wanted at most.
    points : callable
        Number of a step -> where what is drawn is, (n, d), the same points at all steps.
    stress : (n_t,)
        Largest stress at every step; zero where there is none.

    Returns
    -------
    chosen : list of int
        Rising numbers, at most `count`; the last step is among them.
    """
    last, peak = len(stress) - 1, first_largest(stress)
    steps = sorted({*spread(last, LOOKED_AT), peak})
    places, end = np.array([points(step) for step in steps]), len(steps) - 1
    if not places.size:
        return spread(last, count)
    apart, loud = _apart(places), stress[steps]

    def alike(a: int, b: int) -> bool:
        return apart(a)[b] <= near and abs(loud[a] - loud[b]) <= ALIKE * loud.max()

    near = max(ALIKE * apart(end).max(), STILL * np.abs(places).max())  # twice the first bounds the way between any two instants
    chosen = [end]
    for k in (steps.index(peak), first_largest(apart(0)), 0):
        if len(chosen) < count and not any(alike(k, other) for other in chosen):
            chosen.append(k)
    while len(chosen) < count:
        nearest = np.min([apart(k) for k in chosen], axis=0)
        k = first_largest(nearest)
        if nearest[k] <= near:
            break
        chosen.append(k)
    return sorted(steps[k] for k in chosen)


def _apart(places: np.ndarray) -> Callable[[int], np.ndarray]:
    """Function from an instant's number to the longest displacement of any point from there to every instant, (n_t,)."""
    return lambda k: np.asarray(np.linalg.norm(places - places[k], axis=-1).max(axis=1))
