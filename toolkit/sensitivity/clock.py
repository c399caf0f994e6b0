"""Time that an analysis takes: by the way, or measured so well that it can be printed as a price."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from statistics import median

from toolkit.foundation.compiled.compile_watch import CompileWatch

Progress = Callable[[int, int], None]

REPEATS, WORTH_REPEATING = 5, 1.0
"""A run is repeated so often, as long as all together take less than this, in s."""


def price(watch: CompileWatch, timed: bool, work: Callable[[], object]) -> float:
    """Time of work that was watched once, in s, without the compilation of formulas.

    The first time also loads compiled code; if the work is `timed`, a short one is repeated and the median of the repetitions taken.
    """
    if not timed:
        return watch.rest
    first, times = watch.rest + watch.seconds, list[float]()
    while (watch.functions and not times) or (len(times) < REPEATS and first + sum(times) < WORTH_REPEATING):
        begun = clock.perf_counter()
        work()
        times.append(clock.perf_counter() - begun)
    return median(times or [first])
