"""A smooth plane curve through given points, addressed by its true arc length.

The curve may be complex, and so may arc lengths: every formula is analytic, with |r'| = sqrt(x'^2 + y'^2), so that a complex step
in a parameter of the shape carries exact derivatives through. Only the choice of an interval looks at real parts.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, TypeAlias

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from toolkit.foundation.errors import InputError


@dataclass(frozen=True, eq=False)
class Interpolant:
    """Interpolating curve r(u) and its derivatives, called like a spline of scipy."""

    derivatives: tuple[BSpline, ...]  # of r_0, from order 0 to the degree
    stretch: np.ndarray | None = None  # (2,) the diagonal of D, real or complex; none for 1

    @classmethod
    def through(cls, u: np.ndarray, points: np.ndarray, degree: int) -> Interpolant:
        """Spline with r(u_i) = point i and not-a-knot ends."""
        spline = make_interp_spline(u, points, k=degree)
        return cls((spline, *(spline.derivative(order) for order in range(1, degree + 1))))

    def __call__(self, u: Number | np.ndarray, order: int = 0) -> np.ndarray:
        """Derivative of an order up to 3, not above the degree, at parameters u (...), real or complex; shape (..., 2)."""
        value = self.derivatives[order](np.real(u))
        if np.iscomplexobj(u):
            step = 1j * np.imag(u)
            factor = np.ones_like(step)
            for k, derivative in enumerate(self.derivatives[order + 1 :], start=1):
                factor = factor * step / k
                value = value + factor[..., None] * derivative(np.real(u))
        return value if self.stretch is None else value * self.stretch

    def stretched(self, x: complex, y: complex) -> Interpolant:
        """Curve with both coordinates multiplied, which leaves its parametrisation as it is."""
        before = np.ones(2) if self.stretch is None else self.stretch
        return Interpolant(self.derivatives, before * np.array([x, y]))


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


Number: TypeAlias = float | complex
"""A float, or a complex number where a complex step is taken."""

_SETTLED = 1e-9
"""Step of Newton's iteration, in parts of the whole curve, whose square is below round-off."""
_PASSES = 3  # arc-length passes: they even out the speed |r'(u)|; exact arc length comes from `parameter`
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(10)


class Parametric(Protocol):
    """Curve r(u) with its derivatives; an `Interpolant`, or one with bumps."""

    def __call__(self, u: Number | np.ndarray, order: int = 0) -> np.ndarray: ...


@dataclass(frozen=True, eq=False)
class ArcLengthSpline:
    """Interpolating spline r(u) with the arc length s(u) = integral |r'| du of its points.

    Between breaks s(u) is a 10-point Gauss rule per interval and its inverse u(s) a Newton iteration, so that
    arc length is true everywhere and not only at the points.
    """

    spline: Parametric  # r(u), values (2,)
    point_u: np.ndarray  # (n,) parameters of the points, always real
    point_s: np.ndarray  # (n,) arc lengths of the points, from 0
    break_u: np.ndarray  # (m,) the points, and between them the ends of bumps: the curve is smooth between two breaks
    break_s: np.ndarray  # (m,)

    @classmethod
    def through(cls, points: np.ndarray, degree: int = 3) -> ArcLengthSpline:
        """Spline through points (n, 2) in their order; not-a-knot ends, since natural ends force a false zero curvature.

        Raises
        ------
        InputError
            Wrong shape, too few points, numbers that are not finite, the same point twice in a row, or points in such an order
            that a smooth curve through them strays far from them.
        """
        points = checked_rows(points, degree)
        u = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        for _ in range(_PASSES):
            u = _arc_lengths(Interpolant.through(u, points, degree), u)
        curve = cls.of(Interpolant.through(u, points, degree), u)
        refuse_detours(np.diff(curve.point_s), points)
        return curve

    @classmethod
    def of(cls, spline: Parametric, point_u: np.ndarray, kinks: np.ndarray | None = None) -> ArcLengthSpline:
        """Spline on a curve r(u) with points at `point_u` (n,); at the parameters `kinks` higher derivatives jump."""
        u = point_u if kinks is None else np.concatenate([point_u, kinks])
        order = np.argsort(u.real, kind="stable")
        s = _arc_lengths(spline, u[order])
        return cls(spline, point_u, s[order < len(point_u)], u[order], s)

    def stretched(self, x: complex, y: complex) -> ArcLengthSpline:
        """Curve with its x and y multiplied by positive numbers, or by complex ones with a positive real part."""
        if not isinstance(self.spline, Interpolant):
            raise TypeError("stretch a curve before it gets bumps; their lengths do not stretch with it")
        return ArcLengthSpline.of(self.spline.stretched(x, y), self.point_u)

    @property
    def is_complex(self) -> bool:
        """Whether the curve carries a complex step."""
        return np.iscomplexobj(self.point_s)

    @property
    def length(self) -> Number:
        """Length of the whole curve."""
        return self.point_s[-1].item()

    def position(self, s) -> np.ndarray:
        """Points (..., 2) at arc lengths s (...)."""
        return self.spline(self.parameter(s))

    def tangent_angle(self, s) -> np.ndarray:
        """Angle of the tangent to the x axis, continuous along the curve, in [0, 2 pi) at its start; shape (...)."""
        u = self.parameter(s)
        principal = _angle(self.spline(u, 1))
        turns = np.round((np.interp(np.real(u), *self._continuous_angles) - np.real(principal)) / (2 * np.pi))
        return principal + 2 * np.pi * turns

    def direction(self, s) -> np.ndarray:
        """Unit tangents (..., 2) at arc lengths s (...)."""
        first = self.spline(self.parameter(s), 1)
        return first / norm(first)[..., None]

    def curvature(self, s) -> np.ndarray:
        """Signed curvature (x' y'' - y' x'') / |r'|^3, positive where the curve turns left; shape (...)."""
        u = self.parameter(s)
        first, second = self.spline(u, 1), self.spline(u, 2)
        cross = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
        return cross / norm(first) ** 3

    def arc_length(self, u: Number | np.ndarray) -> np.ndarray:
        """Arc lengths (...) at parameters u (...)."""
        i = self._interval(self.break_u, u)
        return self.break_s[i] + _arc_between(self.spline, self.break_u[i], u)

    def parameter(self, s) -> np.ndarray:
        """Parameter u with s(u) = s, by Newton's iteration with derivative |r'(u)|."""
        s = np.asarray(s) + 0.0
        i = self._interval(self.break_s, s)
        start, excess = self.break_u[i], s - self.break_s[i]
        rise = self.break_s[i + 1] - self.break_s[i]
        u = start + excess * np.divide(self.break_u[i + 1] - start, rise, out=np.ones_like(rise), where=rise != 0)
        settled, last = _SETTLED * abs(self.break_u[-1]), np.inf
        for _ in range(8):  # quadratic from an error of some percent of one interval: 4 do, 8 are safe
            step = (_arc_between(self.spline, start, u) - excess) / _speed(self.spline, u)
            before, last, u = last, float(np.abs(step).max(initial=0)), u - step
            if before < settled:  # the step after it is round-off, and what a complex step adds, which lags behind, is right too
                break
        return u

    @cached_property
    def _continuous_angles(self) -> tuple[np.ndarray, np.ndarray]:
        """Unwrapped tangent angles at eight samples per interval, from which the branch of any angle is chosen."""
        u = np.interp(np.arange(8 * (len(self.point_u) - 1) + 1) / 8, np.arange(len(self.point_u)), self.point_u)
        angle = np.unwrap(np.real(_angle(self.spline(u, 1))))
        return u, angle + (2 * np.pi if angle[0] < 0 else 0.0)

    @staticmethod
    def _interval(breaks: np.ndarray, at: Number | np.ndarray) -> np.ndarray:
        """Numbers (...) of the intervals in which real parts lie; what is off the curve belongs to its first or last one."""
        return np.clip(np.searchsorted(breaks.real, np.real(at), side="right") - 1, 0, len(breaks) - 2)


def norm(vectors: np.ndarray) -> np.ndarray:
    """Length sqrt(x^2 + y^2) of vectors (..., 2), analytic where they are complex."""
    return np.sqrt((vectors * vectors).sum(axis=-1))


def _angle(tangent: np.ndarray) -> np.ndarray:
    """Angle to the x axis; that of the real part, and what a complex step adds to it, atan((x_r y - y_r x) / (x_r x + y_r y))."""
    x, y = np.real(tangent[..., 0]), np.real(tangent[..., 1])
    angle = np.arctan2(y, x)
    if not np.iscomplexobj(tangent):
        return angle
    return angle + np.arctan((x * tangent[..., 1] - y * tangent[..., 0]) / (x * tangent[..., 0] + y * tangent[..., 1]))


def _speed(spline: Parametric, u: np.ndarray) -> np.ndarray:
    return norm(spline(u, 1))


def _arc_between(spline: Parametric, start: np.ndarray, end: Number | np.ndarray) -> np.ndarray:
    """Integral of |r'(u)| from start to end (...), both within one interval between points."""
    half = (np.asarray(end) - start) / 2
    u = start[..., None] + half[..., None] * (1 + _NODES)
    return half * (_speed(spline, u) @ _WEIGHTS)


def _arc_lengths(spline: Parametric, u: np.ndarray) -> np.ndarray:
    """Arc length at every parameter u (n,), zero at the first."""
    return np.concatenate([[0.0], np.cumsum(_arc_between(spline, u[:-1], u[1:]))])
