"""The contour of an airfoil in the user's length unit, and bumps of it: a spline in arc length.

The contour of an airfoil in the user's length unit: a spline in arc length that knows its leading edge and two sides.

A contour that carries a complex step is searched by its real part; what is found is then polished by Newton's iteration on the
complex condition, so that its derivative is exact.

    r(s) = r_0(s) + B(s) n(s),    B(s) = sum_j h_j b((s - c_j) / w_j),    b(q) = (1 - q^2)^4 for |q| < 1, and 0 outside

s is the arc length of the curve without bumps, c the centre, w the half width, h the height; b has three continuous derivatives.
With the unit tangent t, the curvature k of that curve (positive where convex) and dt/ds = -k n, dn/ds = k t follow

    dr/ds - dr_0/ds = k B t + B' n
    d2r/ds2 - d2r_0/ds2 = (2 k B' + k' B) t + (B'' - k^2 B) n

The parameter of the curve without bumps stays the parameter, whatever the heights are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from preprocessing.airfoil.arc_length_spline import ArcLengthSpline, Number, norm
from toolkit.foundation.errors import InputError


def root(f: Callable[[float], float], low: float, high: float, length: float) -> float:
    """Real root of f between two parameters at which it has different signs, on a curve of a given length."""
    return float(brentq(f, low, high, xtol=1e-14 * length))


def polished(f_and_slope: Callable[[Number], tuple[Number, Number]], u: float) -> complex:
    """Complex root whose real part is known: each step of Newton's iteration doubles the right digits, 4 steps are many.

    Parameters
    ----------
    f_and_slope : parameter -> value of an analytic function and of its derivative
    """
    place = complex(u)
    for _ in range(4):
        value, slope = f_and_slope(place)
        place = complex(place - value / slope)
    return place


SIDES = ("upper", "lower")

LEAST_SLOPE = 1e-3
"""Least |dx/ds| at which the derivative of a place found by its x is given; at the nose it is infinite."""


@dataclass(frozen=True, eq=False)
class Contour:
    """Closed or open loop TE, upper side, LE, lower side, TE; arc length s runs from the upper trailing edge.

    Lengths are in the unit of the chord that scaled it, angles in radians.
    """

    curve: ArcLengthSpline

    @classmethod
    def through(cls, points: np.ndarray, chord: float, degree: int = 3) -> Contour:
        """Spline through rows (n, 2) given as fractions of the chord, scaled by `chord`.

        Degree 3 has continuous curvature, degree 5 continuous derivatives of curvature too.

        Raises
        ------
        InputError
            Chord not positive, or rows that no spline can pass (see `ArcLengthSpline.through`).
        """
        if not (np.isfinite(chord) and chord > 0):
            raise InputError(f"chord {chord!r} must be a positive length, for example 550.0 (mm).")
        return cls(ArcLengthSpline.through(np.asarray(points, dtype=float) * chord, degree))

    def stretched(self, x: complex, y: complex) -> Contour:
        """Contour with its x and y multiplied; itself if by 1."""
        return self if x == 1 and y == 1 else Contour(self.curve.stretched(x, y))

    @property
    def is_complex(self) -> bool:
        """Whether the contour carries a complex step."""
        return self.curve.is_complex

    @property
    def length(self) -> Number:
        """Length of the whole loop."""
        return self.curve.length

    def position(self, s) -> np.ndarray:
        """Points (..., 2) at arc lengths s (...)."""
        return self.curve.position(s)

    def tangent_angle(self, s) -> np.ndarray:
        """Continuous angle of the tangent to the x axis, near pi at the start of the loop; shape (...)."""
        return self.curve.tangent_angle(s)

    def curvature(self, s) -> np.ndarray:
        """Signed curvature (1/length), positive where the loop is convex; shape (...)."""
        return self.curve.curvature(s)

    @cached_property
    def outline(self) -> np.ndarray:
        """Points (n, 2) to draw the contour by: the rows, and three between any two, for a nose of few rows is round too."""
        return np.real(self.position(self._between_rows(np.real(self.curve.point_s))))

    @cached_property
    def leading_edge(self) -> float:
        """Arc length of the point farthest from the middle of the trailing edge.

        It only tells the two sides apart, so its real part is enough even where a complex step is taken.
        """
        return float(np.real(self.curve.arc_length(self._nose)))

    @cached_property
    def _nose(self) -> float:
        """Parameter of the leading edge."""
        rows = np.real(self.curve.spline(self.curve.point_u))
        tail = (rows[0] + rows[-1]) / 2
        return self._foot(tail, int(np.argmax(norm(self._samples[1] - tail))))

    def nearest(self, point: np.ndarray) -> Number:
        """Arc length of the point of the contour nearest to `point` (2,); an end of the loop, if that is nearest."""
        place, ends = np.real(point), self.curve.point_u[[0, -1]]
        u = self._foot(place, int(np.argmin(norm(self._samples[1] - place))))
        if u in ends:
            return 0.0 if u == ends[0] else self.length
        stepped = self.is_complex or np.iscomplexobj(point)
        return self.curve.arc_length(polished(lambda t: self._distance_along(point, t), u) if stepped else u).item()

    def at_x(self, x: float, side: str) -> Number:
        """Arc length where the upper or lower side, split at the leading edge, has abscissa x.

        Raises
        ------
        InputError
            Unknown side, x not on that side, or met more than once there (round nose or tail); under a complex step also a
            contour that is upright there, so that no derivative exists.
        """
        if side not in SIDES:
            raise InputError(f"side {side!r} is unknown; available: {', '.join(SIDES)}.")
        spline, u = self.curve.spline, self._found(x, side)
        if not self.is_complex:
            return self.curve.arc_length(u).item()
        along = np.real(spline(u, 1))
        slope = along[0] / norm(along)
        if abs(slope) < LEAST_SLOPE:
            raise InputError(
                f"the {side} side is upright at x = {x:g} (dx/ds = {slope:.1e}), so that the place has no derivative by the shape. "
                "Name the point by its arc length, or choose x away from the nose."
            )
        return self.curve.arc_length(polished(lambda t: (spline(t)[0] - x, spline(t, 1)[0]), u)).item()

    def _found(self, x: float, side: str) -> float:
        """Real part of the parameter that `at_x` looks for."""
        parameters, points = self._samples
        first, last = (parameters[0], self._nose) if side == "upper" else (self._nose, parameters[-1])
        between = (parameters > first) & (parameters < last)
        u = np.concatenate([[first], parameters[between], [last]])
        beginning, end = np.real(self.curve.spline(u[[0, -1]])[:, 0])
        reached = np.concatenate([[beginning], points[between, 0], [end]])
        f = reached - x
        for i in (0, -1):
            if abs(f[i]) < 1e-12 * self.length.real:
                return float(u[i])
        hits = np.flatnonzero((f[:-1] > 0) != (f[1:] > 0))
        if len(hits) != 1:
            how = "does not reach" if len(hits) == 0 else f"meets {len(hits)} times"
            raise InputError(
                f"the {side} side {how} x = {x:g}; it runs from x = {reached.min():g} to {reached.max():g}. "
                "Choose x in this range, or name the point by its arc length."
            )
        return root(lambda t: float(np.real(self.curve.spline(t)[0])) - x, u[hits[0]], u[hits[0] + 1], self.length.real)

    @cached_property
    def _samples(self) -> tuple[np.ndarray, np.ndarray]:
        """Four parameters per interval between rows, the rows among them, and the real points (n, 2) there.

        Places are searched by the parameter, which needs no inverse of the arc length.
        """
        u = self._between_rows(self.curve.point_u)
        return u, np.real(self.curve.spline(u))

    @staticmethod
    def _between_rows(at_rows: np.ndarray) -> np.ndarray:
        """Four numbers per interval between rows."""
        n = len(at_rows)
        return np.interp(np.arange(4 * (n - 1) + 1) / 4, np.arange(n), at_rows)

    def _foot(self, point: np.ndarray, i: int) -> float:
        """Root of (r(u) - point) . r'(u), real parts, next to sample i; the sample itself at an end of the loop."""
        u, spline = self._samples[0], self.curve.spline

        def along(t: float) -> float:
            return float((np.real(spline(t)) - point) @ np.real(spline(t, 1)))

        low, high = u[max(i - 1, 0)], u[min(i + 1, len(u) - 1)]
        if along(low) * along(high) > 0:
            return float(u[i])
        return root(along, low, high, self.length.real)

    def _distance_along(self, point: np.ndarray, u: Number) -> tuple[Number, Number]:
        """Function (r - point) . r' and its derivative by u, r' . r' + (r - point) . r''."""
        place, first, second = (self.curve.spline(u, order) for order in (0, 1, 2))
        return (place - point) @ first, first @ first + (place - point) @ second


NARROWEST_BUMP = 1e-6
"""Least half width of a bump, in lengths of the contour."""

_SAMPLES = 201  # of a bump, in search of a fold: it is smooth, and the contour between rows is too


@dataclass(frozen=True)
class Bump:
    """Bump of a contour; its lengths are in the unit of the contour, and real or complex."""

    centre: Number  # arc length on the contour without bumps, from its upper trailing edge
    half_width: Number
    height: Number

    @property
    def ends(self) -> tuple[Number, Number]:
        """Arc lengths between which the bump acts."""
        return self.centre - self.half_width, self.centre + self.half_width

    def checked(self, contour: Contour) -> Bump:
        """Bump itself, refused if it does not fit on the contour.

        Raises
        ------
        InputError
            It reaches off the contour, or is too narrow to be told from a point of it.
        """
        (low, high), length = np.real(self.ends), contour.length.real
        if np.real(self.half_width) < NARROWEST_BUMP * length:
            raise InputError(
                f"half_width {np.real(self.half_width):g} is less than {NARROWEST_BUMP:g} of the contour's length {length:g}. Give a "
                "bump that several nodes lie in."
            )
        if not 0 <= low < high <= length:
            widest = max(min(np.real(self.centre), length - np.real(self.centre)), 0.0)
            remedy = f"Give a half_width of at most {widest:g}, or another place." if widest > 0 else "Give another place."
            raise InputError(
                f"the bump would reach from {low:g} to {high:g} along the contour, which runs from 0 (upper trailing edge) to "
                f"{length:g}. {remedy}"
            )
        return self


def bumped(contour: Contour, bumps: Sequence[Bump]) -> Contour:
    """Contour with all bumps at once; itself if none has a height.

    Raises
    ------
    InputError
        The bumps are so deep that the contour would fold.
    """
    bumps = [bump for bump in bumps if bump.height != 0]
    if not bumps:
        return contour
    base = contour.curve
    ends = base.parameter([bump.ends for bump in bumps])
    curve = _Bumped(base, tuple(bumps), np.real(ends))
    curve.refuse_folds()
    return Contour(ArcLengthSpline.of(curve, base.point_u, ends.ravel()))


@dataclass(frozen=True, eq=False)
class _Bumped:
    """Curve r(u) with bumps, where u is the parameter of the curve without them."""

    base: ArcLengthSpline
    bumps: tuple[Bump, ...]
    ends: np.ndarray  # (n_bumps, 2) real parts of the parameters between which the bumps act

    def __call__(self, u: Number | np.ndarray, order: int = 0) -> np.ndarray:
        """Derivative of order 0, 1 or 2 at parameters u (...), shape (..., 2); outside all bumps that of the curve without them."""
        flat = np.reshape(u, -1)
        value, inside = self.base.spline(flat, order), self._inside(flat)
        if inside.any():
            displacement = self._displacement(flat[inside], order)
            value = value.astype(np.result_type(value, displacement))
            value[inside] += displacement
        return value.reshape(*np.shape(u), 2)

    def refuse_folds(self) -> None:
        """Refuse heights at which the curve would turn back on itself, 1 + k B <= 0."""
        for bump in self.bumps:
            low, high = np.real(bump.ends)
            s = np.linspace(low, high, _SAMPLES)
            left = 1 + np.real(self.base.curvature(s) * self._heights(s, 0))
            if left.min() <= 0:
                at = s[left.argmin()]
                raise InputError(
                    f"a height of {np.real(bump.height):g} folds the contour at its arc length {at:g}, where the radius of curvature "
                    f"is {1 / abs(np.real(self.base.curvature(at))):g}. Choose a smaller height."
                )

    def _inside(self, u: np.ndarray) -> np.ndarray:
        """Which of the parameters (n,) lie in a bump, by their real parts."""
        return np.any((self.ends[:, :1] < u.real) & (u.real < self.ends[:, 1:]), axis=0)

    def _displacement(self, u: np.ndarray, order: int) -> np.ndarray:
        """Derivative of B n by u, (n, 2)."""
        s, first = self.base.arc_length(u), self.base.spline(u, 1)
        speed, normal = norm(first)[:, None], np.stack([first[:, 1], -first[:, 0]], axis=1) / norm(first)[:, None]
        tangent, height = first / speed, self._heights(s, 0)[:, None]
        if order == 0:
            return height * normal
        curvature, curvature_s = self._curvature(u)
        slope = self._heights(s, 1)[:, None]
        by_s = curvature * height * tangent + slope * normal
        if order == 1:
            return speed * by_s
        by_ss = (2 * curvature * slope + curvature_s * height) * tangent
        by_ss = by_ss + (self._heights(s, 2)[:, None] - curvature**2 * height) * normal
        return speed**2 * by_ss + (first * self.base.spline(u, 2)).sum(axis=1, keepdims=True) / speed * by_s

    def _curvature(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Curvature of the curve without bumps and its derivative by s, both (n, 1)."""
        first, second, third = (self.base.spline(u, order) for order in (1, 2, 3))
        speed, turn = norm(first), _cross(first, second)
        by_u = _cross(first, third) / speed**3 - 3 * turn * (first * second).sum(axis=1) / speed**5
        return (turn / speed**3)[:, None], (by_u / speed)[:, None]

    def _heights(self, s: np.ndarray, order: int) -> np.ndarray:
        """Derivative of B of order 0, 1 or 2 at arc lengths s (n,)."""
        parts = [bump.height / bump.half_width**order * _bell((s - bump.centre) / bump.half_width, order) for bump in self.bumps]
        return np.sum(parts, axis=0)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _bell(q: np.ndarray, order: int) -> np.ndarray:
    """Bell function b(q) = (1 - q^2)^4 and its first two derivatives for |q| < 1 by its real part, 0 outside."""
    p = np.where(np.abs(np.real(q)) < 1, 1 - q * q, 0.0)
    return (p**4, -8 * q * p**3, 48 * q * q * p**2 - 8 * p**3)[order]
