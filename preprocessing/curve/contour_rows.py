"""The rows that a contour is laid through: what no smooth curve can pass is refused."""

from __future__ import annotations

import numpy as np

from toolkit.foundation.errors import InputError

_DETOUR = 2.0  # length of the curve between two points over their distance: a semicircle has 1.6, noses of few rows have 1.05


def checked_rows(points: np.ndarray, degree: int) -> np.ndarray:
    """The rows (n, 2) as numbers; refused if no spline of the degree can pass them."""
    points = np.asarray(points, dtype=float)
    if degree not in (3, 5):
        raise InputError(f"spline degree {degree!r}: available are 3 (cubic, the default) and 5 (quintic).")
    if points.ndim != 2 or points.shape[1] != 2 or len(points) <= degree:
        raise InputError(f"a contour needs at least {degree + 1} points as an array (n, 2), got shape {points.shape}.")
    if not np.isfinite(points).all():
        row = int(np.flatnonzero(~np.isfinite(points).all(axis=1))[0])
        raise InputError(f"contour row {row} (counted from 0) is not finite: {points[row]}. Fix the coordinate.")
    repeated = np.flatnonzero((np.diff(points, axis=0) == 0).all(axis=1))
    if repeated.size:
        raise InputError(f"contour rows {repeated[0]} and {repeated[0] + 1} (counted from 0) are equal: drop one of them.")
    return points


def refuse_detours(lengths: np.ndarray, points: np.ndarray) -> None:
    """Refuse a curve whose pieces between rows, of these lengths (n - 1,), stray far from the rows (n, 2)."""
    detour = lengths / np.linalg.norm(np.diff(points, axis=0), axis=1)
    i = int(np.argmax(detour))
    if not detour[i] <= _DETOUR:
        raise InputError(
            f"between contour rows {i} and {i + 1} (counted from 0) the smooth curve is {detour[i]:.3g} times as long as their "
            "distance: rows there are out of order or fold back. Fix or remove them."
        )
