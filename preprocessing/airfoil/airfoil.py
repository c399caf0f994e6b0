"""Read an airfoil file of any common format into one normal form, or say what is wrong with it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from preprocessing.airfoil.checks import check
from preprocessing.airfoil.format import Loop, recognise
from preprocessing.airfoil.table import read_text, split_table
from preprocessing.curve.contour import Contour
from toolkit.foundation.errors import InputError, retold

SAME_POINT = 1e-9  # chord; closer rows are one row written twice
CLOSED_TAIL = 1e-6  # chord
_LONGEST_MISSING_TAIL = 0.05  # chord; more than one row is missing beyond it


def normal_form(loop: Loop) -> Loop:
    """Loop in normal form, in fractions of the chord; every change is listed in its repairs.

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


UNITS = ("chord", "percent", "mm", "m")
WORDS = {"chord": "fractions of the chord", "percent": "percent of the chord"}
_CHORD_RANGE = (0.9, 1.1)  # largest x of a section in fractions of its chord


@dataclass(frozen=True, eq=False)
class Airfoil:
    """A section as rows in fractions of the chord, in the frame of its file: neither shifted, turned nor normalised.

    `points` (n, 2) run trailing edge, upper side, leading edge, lower side, trailing edge, anticlockwise. An open
    trailing edge stays open. `repairs` and `warnings` tell what was changed and what looks odd, with line numbers.
    """

    name: str
    points: np.ndarray
    format: str
    repairs: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def trailing_edge_gap(self) -> float:
        """Distance between the first and the last row, in chords."""
        return float(np.linalg.norm(self.points[0] - self.points[-1]))

    @property
    def closed(self) -> bool:
        return self.trailing_edge_gap < CLOSED_TAIL

    @cached_property
    def leading_edge(self) -> np.ndarray:
        """Point (2,) of the spline farthest from the middle of the trailing edge."""
        return self._contour.position(self._contour.leading_edge)

    @cached_property
    def thickness(self) -> tuple[float, float]:
        """Largest thickness normal to the chord line, and its place along it, both as fractions of the chord.

        The chord line runs from the leading edge to the middle of the trailing edge; 2000 samples of the spline per side.
        """
        chord = (self.points[0] + self.points[-1]) / 2 - self.leading_edge
        frame = np.array([chord, [-chord[1], chord[0]]]) / (chord @ chord)
        nose, end = self._contour.leading_edge, self._contour.length
        upper, lower = (
            frame @ (self._contour.position(np.linspace(nose, tail, 2000)) - self.leading_edge).T for tail in (0.0, end)
        )
        thickness = upper[1] - np.interp(upper[0], *lower)
        i = int(np.argmax(thickness))
        return float(thickness[i]), float(upper[0, i])

    @cached_property
    def _contour(self) -> Contour:
        return Contour.through(self.points, 1.0)


class ScaleError(InputError):
    """Numbers of an airfoil file that cannot be in the units that were given."""


def read_airfoil(path: str | Path, units: str | None = None, chord: float | None = None) -> Airfoil:
    """Read a Selig, XFOIL plain, Lednicer (with or without header), OpenVSP .af, single-element MSES or OpenFAST file.

    Parameters
    ----------
    path : str or Path
        File of coordinates.
    units : str
        "chord" (default) for fractions of the chord, "percent" of the chord, or "mm" or "m" together with `chord`.
    chord : float
        Chord length in the stated length unit, for "mm" and "m" only.

    Raises
    ------
    InputError
        The message names the file and, where there is one, the line, and says what to do: unreadable file,
        unclear scale, several elements, rows missing or out of order, surfaces that cross.
    """
    path = Path(path)
    divisor = _divisor(units, chord)
    try:
        loop = recognise(split_table(read_text(path)))
        loop = normal_form(_scaled(loop, divisor, units))
        warnings = loop.warnings + check(loop)
    except InputError as error:
        raise retold(error, f"airfoil {path.name}: {error}") from error
    loop.points.flags.writeable = False
    return Airfoil(loop.name or path.stem, loop.points, loop.format, loop.repairs, warnings)


def largest_x(path: str | Path) -> float:
    """Largest x in a file of coordinates, in whatever it is in; raises as `read_airfoil`."""
    path = Path(path)
    try:
        return float(recognise(split_table(read_text(path))).points[:, 0].max())
    except InputError as error:
        raise InputError(f"airfoil {path.name}: {error}") from error


def _divisor(units: str | None, chord: float | None) -> float:
    """Divisor that makes fractions of the chord of the file's numbers."""
    if units is not None and units not in UNITS:
        raise InputError(f"airfoil units {units!r} are unknown; available: {', '.join(UNITS)}.")
    if units not in ("mm", "m"):
        if chord is not None:
            raise InputError(f"a chord length ({chord:g}) goes with units 'mm' or 'm' only; here units are {units or 'chord'!r}.")
        return 100.0 if units == "percent" else 1.0
    if chord is None or not (np.isfinite(chord) and chord > 0):
        raise InputError(f"airfoil units {units!r} need chord=<length of the chord in {units}>, got {chord!r}.")
    return float(chord)


def _scaled(loop: Loop, divisor: float, units: str | None) -> Loop:
    """Points in fractions of the chord; refuses to guess if the largest x is not about one."""
    largest = float(loop.points[:, 0].max())
    low, high = _CHORD_RANGE
    if not low <= largest / divisor <= high:
        if units is None:
            remedy = "Say what its numbers are in, percent, or mm or m with the length of the chord, or scale the file"
        else:
            read = f"{units} with a chord of {divisor:g} {units}" if units in ("mm", "m") else WORDS[units]
            remedy = f"Its numbers were read as {read}: say what they are in"
        raise ScaleError(
            f"x reaches {largest:g}, that is {largest / divisor:g} chord where {low:g} to {high:g} is expected. {remedy}."
        )
    return replace(loop, points=loop.points / divisor)
