"""Time curves at the last times that were asked for, because the parts of an analysis ask for the same ones."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

REMEMBERED, SHORT = 4, 100_000
"""Sets of times whose curves a system remembers: the start, the end and the steps of a run; and most numbers of such a set, as longer runs
take so long that curves are nothing beside them."""

Known = dict[tuple[str, bytes], np.ndarray]
"""Times, by their type and bytes -> what curves are there."""


def remembered(known: Known, times: np.ndarray, evaluate: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Values that are known at these times, or else are evaluated and known from now on.

    It is a copy, which may be written to.
    """
    key = times.dtype.str, times.tobytes()
    found = known.get(key)
    if found is None:
        found = evaluate(times)
        if len(known) >= REMEMBERED:
            known.clear()
        if found.size <= SHORT:
            known[key] = found
    return found.copy()
