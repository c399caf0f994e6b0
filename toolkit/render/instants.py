"""Which instants of a motion are drawn, if nobody asks for others: a few whose pictures differ."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.spread import spread

ALIKE = 0.1
"""Two instants look alike if no point is further from its other place than this part of the longest way between any two instants."""
LOOKED_AT = 120
"""Instants of a motion at most that are compared."""


def telling_steps(last: int, count: int, points: Callable[[int], np.ndarray]) -> list[int]:
    """Numbers of steps of a motion to draw, the last among them.

    They are spread evenly over time; where two of them would look alike, because the motion rests or repeats itself, evenly over the way
    that the points go; and where that repeats itself, each is as different from the others as can be.

    Parameters
    ----------
    last : int
        Number of the last step; the first is 0.
    count : int
        How many are wanted at most.
    points : callable
        Number of a step -> where what is drawn is, (n, d), the same points at all steps.

    Returns
    -------
    chosen : list of int
        Rising numbers, at most `count`; 0 is among them only where there is no other step.
    """
    evenly = sorted({int(step) for step in np.linspace(0, last, count + 1).round()[1:]})
    if len(evenly) < count:
        return evenly
    steps = sorted({*spread(last, LOOKED_AT), *evenly} - {0})
    places = np.array([points(step) for step in steps])
    if not places.size:
        return evenly
    way = np.cumsum([0.0, *(_furthest(now - before) for before, now in pairwise(places))])
    along = [int(np.searchsorted(way, part * way[-1] * (1 - 1e-9))) for part in np.arange(1, count) / count]
    for chosen in ([steps.index(step) for step in evenly], [*along, len(steps) - 1]):
        apart = [_furthest(places[a] - places[b]) for a in chosen for b in chosen if a < b]
        if len(set(chosen)) == count and min(apart) >= ALIKE * _longest(places):
            return sorted(steps[k] for k in chosen)
    return sorted({steps[k] for k in _most_different(places, count)})


def _furthest(moved: np.ndarray) -> float:
    """The longest of displacements (n, d)."""
    return float(np.linalg.norm(moved, axis=-1).max())


def _longest(places: np.ndarray) -> float:
    """Between any two instants, to a factor of two: twice the longest way from the last one bounds it."""
    return max(_furthest(each - places[-1]) for each in places)


def _most_different(places: np.ndarray, count: int) -> list[int]:
    """The last instant, then always the one that is furthest from all that are chosen."""
    chosen = [len(places) - 1]
    for _ in range(count - 1):
        apart = np.min([[_furthest(each - places[k]) for each in places] for k in chosen], axis=0)
        chosen.append(first_largest(apart))
    return chosen
