"""What an analysis costs: by the way, or measured so well that it can be printed as a price."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from statistics import median
from typing import Protocol, TypeVar

from toolkit.foundation.compiled.compile_watch import watched_compilation

T = TypeVar("T")
Progress = Callable[[int, int], None]
Work = Callable[[Progress | None], T]

REPEATS, WORTH_REPEATING = 5, 1.0
"""A run is repeated so often, as long as all together take less than this, in s."""


class Clock(Protocol):
    """Does some work, which reports progress, and returns its time in s and what it returned."""

    def __call__(self, work: Work[T], progress: Progress | None = None, /) -> tuple[float, T]:
        """Do it."""


def once(work: Work[T], progress: Progress | None = None, /) -> tuple[float, T]:
    """The work is done once, and its time is what it took, without the compilation of formulas."""
    with watched_compilation() as compiled:
        seconds, found = _clocked(work, progress)
    return seconds - compiled.seconds, found


def repeated(work: Work[T], progress: Progress | None = None, /) -> tuple[float, T]:
    """The first run also loads compiled code, so a short one is repeated and the median of the repetitions taken.

    A repetition that had to compile anything does not count; the first one alone reports progress.
    """
    with watched_compilation() as compiled:
        first, found = _clocked(work, progress)
    times: list[float] = []
    while (compiled.functions and not times) or (len(times) < REPEATS and first + sum(times) < WORTH_REPEATING):
        seconds, found = _clocked(work, None)
        times.append(seconds)
    return median(times or [first]), found


def _clocked(work: Work[T], progress: Progress | None) -> tuple[float, T]:
    begun = clock.perf_counter()
    found = work(progress)
    return clock.perf_counter() - begun, found
