"""The contour of an airfoil in the user's length unit: a spline in arc length that knows its leading edge and two sides.

A contour that carries a complex step is searched by its real part; what is found is then polished by Newton's iteration on the
complex condition, so that its derivative is exact.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from preprocessing.curve.arc_length_spline import ArcLengthSpline, Number, norm
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

UPRIGHT = 1e-3
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

    def at_row(self, i: int) -> Number:
        """Arc length of row i of the points, counted from 0.

        Raises
        ------
        InputError
            There is no such row.
        """
        n = len(self.curve.point_s)
        if not 0 <= i < n:
            raise InputError(f"row {i} is not on the contour: its rows count from 0 to {n - 1}.")
        return self.curve.point_s[i].item()

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
        u: Number = self._foot(place, int(np.argmin(norm(self._samples[1] - place))))
        if u in ends:
            return 0.0 if u == ends[0] else self.length
        if self.is_complex or np.iscomplexobj(point):
            u = polished(lambda t: self._distance_along(point, t), u)
        return self.curve.arc_length(u).item()

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
        if abs(slope) < UPRIGHT:
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
