"""Read an airfoil file of any common format into one normal form, or say what is wrong with it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from preprocessing.airfoil.airfoil_format import Loop, read_text, recognise, split_table
from preprocessing.airfoil.contour import Contour
from toolkit.foundation.errors import InputError, retold

MIN_ROWS, MAX_ROWS = 10, 3000  # the crossing test takes the square of them: 2 s and half a GB at the limit
MIN_NOSE_ROWS, NOSE = 9, 0.05  # rows wanted ahead of this fraction of the chord
TAIL = 0.98  # behind it crossing surfaces and caps are a matter of rounding
LARGEST_GAP = 0.3  # chord
SHARPEST_TURN = 30.0  # degrees, behind the nose
SHARPEST_NOSE, HOLLOW_NOSE = 90.0, 10.0  # degrees to the left and right; noses of real files, some of few rows, reach 68 and 2
LARGEST_TILT = 3.0  # degrees between the chord line and the x-axis; real sections have 0.06, one with a drooped nose 0.9
FOLD_ANGLE = 120.0  # degrees; no rounded nose turns so far at one row, only a sharp one: up to 156 in real files of few rows
_ROUNDING = 1e-5  # chord; the usual files hold five decimals


def check(loop: Loop) -> tuple[str, ...]:
    """Warnings of a loop in fractions of the chord.

    Raises
    ------
    InputError
        The loop cannot be a section.
    """
    if len(loop.points) < MIN_ROWS:
        raise InputError(f"only {len(loop.points)} rows; at least {MIN_ROWS} are needed. Complete the file.")
    if len(loop.points) > MAX_ROWS:
        raise InputError(
            f"{len(loop.points)} rows; at most {MAX_ROWS} are accepted. Keep every n-th row, more of them at the nose."
        )
    _refuse_gaps(loop)
    _refuse_reversals(loop)
    warnings = _crossings(loop)
    _refuse_negative_thickness(loop)
    return warnings + _kinks(loop) + _coarse_nose(loop) + _tilt(loop)


def _refuse_gaps(loop: Loop) -> None:
    gaps = np.linalg.norm(np.diff(loop.points, axis=0, append=loop.points[:1]), axis=1)
    i = int(np.argmax(gaps))
    if gaps[i] > LARGEST_GAP:
        after = loop.lines[(i + 1) % len(loop.lines)]
        raise InputError(
            f"gap of {gaps[i]:.3g} chord between lines {loop.lines[i]} and {after}; at most {LARGEST_GAP} is accepted. "
            "Add the rows that are missing there."
        )


def _refuse_reversals(loop: Loop) -> None:
    """Refuse x that rises before the leading edge or falls behind it, apart from rounding and a cap at the tail."""
    x = loop.points[:, 0]
    nose = int(np.argmin(x))
    back_up = x[: nose + 1] - np.minimum.accumulate(x[: nose + 1])
    back_down = np.maximum.accumulate(x[nose:]) - x[nose:]
    back = np.concatenate([back_up, back_down[1:]])
    bad = np.flatnonzero((back > _ROUNDING) & (x < TAIL))
    if bad.size:
        raise InputError(
            f"x turns back at line {loop.lines[bad[0]]} (x = {x[bad[0]]:g}), away from the leading edge. The rows are out of "
            "order or belong to several sections; give one loop trailing edge, upper side, leading edge, lower side."
        )


def _crossings(loop: Loop) -> tuple[str, ...]:
    """Warnings for surfaces that cross at the tail; segments of a loop that cross elsewhere are refused."""
    pairs = _crossing_segments(loop.points)
    where = [(loop.points[i], f"near x = {loop.points[i, 0]:g} (lines {loop.lines[i]} and {loop.lines[j]})") for i, j in pairs]
    for point, text in where:
        if point[0] < TAIL:
            raise InputError(f"the contour crosses itself {text}. Fix the rows; only behind {TAIL} chord this is tolerated.")
    return tuple(f"the surfaces cross at the tail {text}" for _, text in where)


def _crossing_segments(points: np.ndarray) -> list[tuple[int, int]]:
    """Pairs i < j of segments (row i to i + 1) that properly cross: the ends of each lie on both sides of the other."""
    a, b = points[:-1], points[1:]
    side_a, side_b = _cross(b - a, a[None] - a[:, None]), _cross(b - a, b[None] - a[:, None])
    split = side_a * side_b < 0  # [i, j]: line i separates the ends of segment j
    i, j = np.nonzero(np.triu(split & split.T, k=2))
    return [(int(k), int(m)) for k, m in zip(i, j, strict=True)]


def _cross(direction: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """Cross products direction[i] x offset[i, j], shape (n, n)."""
    return direction[:, None, 0] * offset[..., 1] - direction[:, None, 1] * offset[..., 0]


def _refuse_negative_thickness(loop: Loop) -> None:
    """Refuse a section whose upper side lies below the lower one.

    Surfaces that meet in a common row and change sides escape the crossing test.
    """
    nose = int(np.argmin(loop.points[:, 0]))
    upper, lower = loop.points[nose::-1], loop.points[nose:]
    x = np.unique(loop.points[:, 0])
    x = x[x < TAIL]
    thickness = np.interp(x, *upper.T) - np.interp(x, *lower.T)
    if thickness.max() <= _ROUNDING:
        raise InputError("the section has no thickness: upper and lower side are one line. Check the column of y.")
    i = int(np.argmin(thickness))
    if thickness[i] < -_ROUNDING:
        raise InputError(
            f"negative thickness {thickness[i]:.2g} chord at x = {x[i]:g}: the upper side lies below the lower. Fix these rows."
        )


def _kinks(loop: Loop) -> tuple[str, ...]:
    """Warnings for sharp turns ahead of the tail, and a refusal where the contour folds back upon itself.

    The nose turns sharply between few rows, but only to the left: there a turn to the right is what gives a wrong row away.
    """
    turn, x = _turns(loop.points), loop.points[1:-1, 0]
    sharp = np.where(x > NOSE, np.abs(turn) > SHARPEST_TURN, (turn > SHARPEST_NOSE) | (turn < -HOLLOW_NOSE))
    warnings = []
    for i in np.flatnonzero(sharp & (x < TAIL)):
        degrees, line, nose = abs(turn[i]), loop.lines[i + 1], _is_sharp_nose(loop.points, turn, int(i))
        if degrees > FOLD_ANGLE and not nose:
            raise InputError(
                f"line {line}: the contour folds back by {degrees:.0f} degrees at x = {x[i]:g}. Fix or remove that row."
            )
        what = "sharp nose: the contour turns by" if degrees > FOLD_ANGLE else "kink of"
        warnings.append(f"line {line}: {what} {degrees:.0f} degrees at x = {x[i]:g}")
    return tuple(warnings)


def _turns(points: np.ndarray) -> np.ndarray:
    """Degrees (n - 2,) by which the contour turns at each row between its ends, positive to the left, where it is convex."""
    step = np.diff(points, axis=0)
    angle = np.degrees(np.arctan2(step[:, 1], step[:, 0]))
    return (np.diff(angle) + 180) % 360 - 180


def _is_sharp_nose(points: np.ndarray, turn: np.ndarray, i: int) -> bool:
    """Whether the foremost row turns to the left between rows that do so too.

    Where a single row is drawn out, the contour is hollow at both rows beside it, by 13 degrees and more at one of them.
    """
    beside = turn[max(i - 1, 0) : i + 2]
    return i + 1 == np.argmin(points[:, 0]) and turn[i] > 0 and beside.min() > -HOLLOW_NOSE


def _coarse_nose(loop: Loop) -> tuple[str, ...]:
    rows = int(np.sum(loop.points[:, 0] < NOSE))
    text = f"only {rows} rows ahead of {NOSE:g} chord; {MIN_NOSE_ROWS} or more give a trustworthy nose"
    return (text,) if rows < MIN_NOSE_ROWS else ()


def _tilt(loop: Loop) -> tuple[str, ...]:
    """Warning of a section that is turned in its file: nothing turns it back."""
    tail = (loop.points[0] + loop.points[-1]) / 2
    chord = tail - loop.points[np.argmax(np.linalg.norm(loop.points - tail, axis=1))]
    tilt = np.degrees(np.arctan2(chord[1], chord[0]))
    text = (
        f"the chord line is turned by {tilt:.1f} degrees from the x-axis, and stays so: turn the coordinates if that is not meant"
    )
    return (text,) if abs(tilt) > LARGEST_TILT else ()


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
