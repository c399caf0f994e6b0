"""What an airfoil loop in normal form must fulfil to be one section: refusals, and warnings for what only looks odd."""

from __future__ import annotations

import numpy as np

from preprocessing.airfoil.format import Loop
from toolkit.foundation.errors import InputError

MIN_ROWS, MAX_ROWS = 10, 3000  # the crossing test takes the square of them: 2 s and half a GB at the limit
MIN_NOSE_ROWS, NOSE = 9, 0.05  # rows wanted ahead of this fraction of the chord
TAIL = 0.98  # behind it crossing surfaces and caps are a matter of rounding
LARGEST_GAP = 0.3  # chord
SHARPEST_TURN = 30.0  # degrees, behind the nose
SHARPEST_NOSE, HOLLOW_NOSE = 90.0, 10.0  # degrees to the left and right; noses of real files, some of few rows, reach 68 and 2
TILT = 3.0  # degrees between the chord line and the x-axis; real sections have 0.06, one with a drooped nose 0.9
FOLD = 120.0  # degrees; no rounded nose turns so far at one row, only a sharp one: up to 156 in real files of few rows
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
        if degrees > FOLD and not nose:
            raise InputError(
                f"line {line}: the contour folds back by {degrees:.0f} degrees at x = {x[i]:g}. Fix or remove that row."
            )
        what = "sharp nose: the contour turns by" if degrees > FOLD else "kink of"
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
    return (text,) if abs(tilt) > TILT else ()
