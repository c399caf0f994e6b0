"""A smooth plane curve through given points, addressed by its true arc length."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from toolkit.errors import InputError

_PASSES = 3  # arc-length passes: they even out the speed |r'(u)|; exact arc length comes from `_parameter`
_DETOUR = 2.0  # length of the curve between two points over their distance: a semicircle has 1.6, noses of few rows have 1.05
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(10)


@dataclass(frozen=True, eq=False)
class ArcLengthSpline:
    """Interpolating spline r(u) with the arc length s(u) = integral |r'| du of its points.

    Between points s(u) is a 10-point Gauss rule per interval and its inverse u(s) a Newton iteration, so that
    arc length is true everywhere and not only at the points.
    """

    spline: BSpline  # r(u), values (2,)
    point_u: np.ndarray  # (n,) parameters of the points
    point_s: np.ndarray  # (n,) arc lengths of the points, from 0

    @classmethod
    def through(cls, points: np.ndarray, degree: int = 3) -> ArcLengthSpline:
        """Spline through points (n, 2) in their order; not-a-knot ends, since natural ends force a false zero curvature.

        Raises
        ------
        InputError
            Wrong shape, too few points, numbers that are not finite, the same point twice in a row, or points in such an order
            that a smooth curve through them strays far from them.
        """
        points = _checked(points, degree)
        u = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        for _ in range(_PASSES):
            u = _arc_lengths(make_interp_spline(u, points, k=degree), u)
        spline = make_interp_spline(u, points, k=degree)
        curve = cls(spline, u, _arc_lengths(spline, u))
        _refuse_detours(curve, points)
        return curve

    @property
    def length(self) -> float:
        """Length of the whole curve."""
        return float(self.point_s[-1])

    def position(self, s) -> np.ndarray:
        """Points (..., 2) at arc lengths s (...)."""
        return self.spline(self._parameter(s))

    def tangent_angle(self, s) -> np.ndarray:
        """Angle of the tangent to the x axis, continuous along the curve, in [0, 2 pi) at its start; shape (...)."""
        u = self._parameter(s)
        principal = _angle(self.spline.derivative()(u))
        turns = np.round((np.interp(u, *self._continuous_angles()) - principal) / (2 * np.pi))
        return principal + 2 * np.pi * turns

    def curvature(self, s) -> np.ndarray:
        """Signed curvature (x' y'' - y' x'') / |r'|^3, positive where the curve turns left; shape (...)."""
        u = self._parameter(s)
        first, second = self.spline.derivative()(u), self.spline.derivative(2)(u)
        cross = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
        return cross / np.linalg.norm(first, axis=-1) ** 3

    def _parameter(self, s) -> np.ndarray:
        """Parameter u with s(u) = s, by Newton's iteration with derivative |r'(u)|."""
        s = np.asarray(s, dtype=float)
        i = np.clip(np.searchsorted(self.point_s, s, side="right") - 1, 0, len(self.point_s) - 2)
        start, excess = self.point_u[i], s - self.point_s[i]
        u = start + excess
        for _ in range(8):  # quadratic from an error of some percent of one interval: 4 do, 8 are safe
            u = u - (_arc_between(self.spline, start, u) - excess) / _speed(self.spline, u)
        return u

    def _continuous_angles(self) -> tuple[np.ndarray, np.ndarray]:
        """Unwrapped tangent angles at eight samples per interval, from which the branch of any angle is chosen."""
        u = np.interp(np.arange(8 * (len(self.point_u) - 1) + 1) / 8, np.arange(len(self.point_u)), self.point_u)
        angle = np.unwrap(_angle(self.spline.derivative()(u)))
        return u, angle + (2 * np.pi if angle[0] < 0 else 0.0)


def _checked(points: np.ndarray, degree: int) -> np.ndarray:
    points = np.asarray(points, dtype=float)
    if degree not in (3, 5):
        raise InputError(f"spline degree {degree!r}: available are 3 (cubic, the default) and 5 (quintic).")
    if points.ndim != 2 or points.shape[1] != 2 or len(points) <= degree:
        raise InputError(f"a contour needs at least {degree + 1} points as an array (n, 2), got shape {points.shape}.")
    if not np.isfinite(points).all():
        row = int(np.flatnonzero(~np.isfinite(points).all(axis=1))[0])
        raise InputError(f"contour row {row} (counted from 0) is not finite: {points[row]}. Mend the coordinate.")
    repeated = np.flatnonzero((np.diff(points, axis=0) == 0).all(axis=1))
    if repeated.size:
        raise InputError(f"contour rows {repeated[0]} and {repeated[0] + 1} (counted from 0) are equal: drop one of them.")
    return points


def _refuse_detours(curve: ArcLengthSpline, points: np.ndarray) -> None:
    detour = np.diff(curve.point_s) / np.linalg.norm(np.diff(points, axis=0), axis=1)
    i = int(np.argmax(detour))
    if not detour[i] <= _DETOUR:
        raise InputError(
            f"between contour rows {i} and {i + 1} (counted from 0) the smooth curve is {detour[i]:.3g} times as long as their "
            "distance: rows there are out of order or fold back. Mend or remove them."
        )


def _angle(tangent: np.ndarray) -> np.ndarray:
    return np.arctan2(tangent[..., 1], tangent[..., 0])


def _speed(spline: BSpline, u: np.ndarray) -> np.ndarray:
    return np.linalg.norm(spline.derivative()(u), axis=-1)


def _arc_between(spline: BSpline, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Integral of |r'(u)| from start to end (...), both within one interval between points."""
    half = (np.asarray(end) - start) / 2
    u = start[..., None] + half[..., None] * (1 + _NODES)
    return half * (_speed(spline, u) @ _WEIGHTS)


def _arc_lengths(spline: BSpline, u: np.ndarray) -> np.ndarray:
    """Arc length at every parameter u (n,), zero at the first."""
    return np.concatenate([[0.0], np.cumsum(_arc_between(spline, u[:-1], u[1:]))])
