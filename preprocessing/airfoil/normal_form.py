"""Normal form of an airfoil loop: trailing edge, upper side, leading edge, lower side, anticlockwise, no row twice."""

from __future__ import annotations

import numpy as np

from preprocessing.airfoil.format import Loop
from toolkit.foundation.errors import InputError

SAME_POINT = 1e-9  # chord; closer rows are one row written twice
CLOSED_TAIL = 1e-6  # chord
_LONGEST_MISSING_TAIL = 0.05  # chord; more than one row is missing beyond it


def normal_form(loop: Loop) -> Loop:
    """The loop, in fractions of the chord, in normal form; every change is listed in its repairs.

    Raises
    ------
    InputError
        One surface ends far ahead of the trailing edge.
    """
    return _anticlockwise(_with_tail_row(_without_repeated_rows(loop)))


def _without_repeated_rows(loop: Loop) -> Loop:
    repeated = np.concatenate([[False], np.linalg.norm(np.diff(loop.points, axis=0), axis=1) < SAME_POINT])
    notes = [f"line {loop.lines[i]}: repeats line {loop.lines[i - 1]}, dropped" for i in np.flatnonzero(repeated)]
    return loop.take(~repeated, *notes)


def _with_tail_row(loop: Loop) -> Loop:
    """If one side stops ahead of the other at the tail, its last row is missing: the other side's row stands for it."""
    first, last = loop.points[0], loop.points[-1]
    dx, dy = np.abs(last - first)
    if dx <= max(dy, CLOSED_TAIL):
        return loop
    short, tail = (-1, 0) if last[0] < first[0] else (0, -1)
    if dx > _LONGEST_MISSING_TAIL:
        raise InputError(
            f"line {loop.lines[short]}: one side ends at x = {loop.points[short, 0]:g} chord, the other at "
            f"{loop.points[tail, 0]:g} (line {loop.lines[tail]}). Complete the rows up to the trailing edge."
        )
    note = f"line {loop.lines[short]}: trailing-edge row missing here, line {loop.lines[tail]} stands for it"
    n = len(loop.points)
    return loop.take(np.r_[0:n, 0] if short == -1 else np.r_[n - 1, 0:n], note)


def _anticlockwise(loop: Loop) -> Loop:
    """Turn a clockwise loop round; the area decides, since the mean height of one half fails on reflexed tails."""
    x, y = loop.points.T
    twice_area = np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)
    return loop if twice_area > 0 else loop.take(slice(None, None, -1), "the loop ran clockwise: reversed")
