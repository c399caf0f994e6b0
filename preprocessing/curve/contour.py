"""The contour of an airfoil in the user's length unit: a spline in arc length that knows its leading edge and two sides.

A contour that carries a complex step is searched by its real part; what is found is then polished by Newton's iteration on the
complex condition, so that its derivative is exact.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from preprocessing.curve.arc_length_spline import ArcLengthSpline, Number, norm
from preprocessing.curve.roots import polished, root
from toolkit.foundation.errors import InputError

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
        """This contour with its x and y multiplied; itself if by 1."""
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
        return np.real(self.position(self._samples()))

    @cached_property
    def leading_edge(self) -> float:
        """Arc length of the point farthest from the middle of the trailing edge.

        It only tells the two sides apart, so its real part is enough even where a complex step is taken.
        """
        rows = np.real(self.curve.spline(self.curve.point_u))
        tail = (rows[0] + rows[-1]) / 2
        return self._foot(tail, int(np.argmax(norm(self.outline - tail))))

    def nearest(self, point: np.ndarray) -> Number:
        """Arc length of the point of the contour nearest to `point` (2,); an end of the loop, if that is nearest."""
        place = np.real(point)
        s = self._foot(place, int(np.argmin(norm(self.outline - place))))
        if not (self.is_complex or np.iscomplexobj(point)):
            return s
        if s in (0.0, self.length.real):
            return 0.0 if s == 0.0 else self.length
        return polished(lambda t: self._distance_along(point, t), s)

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
        s = self._found(x, side)
        if not self.is_complex:
            return s
        slope = self.curve.direction(s)[0].real
        if abs(slope) < UPRIGHT:
            raise InputError(
                f"the {side} side is upright at x = {x:g} (dx/ds = {slope:.1e}), so that the place has no derivative by the shape. "
                "Name the point by its arc length, or choose x away from the nose."
            )
        return polished(lambda t: (self.position(t)[0] - x, self.curve.direction(t)[0]), s)

    def _found(self, x: float, side: str) -> float:
        """`at_x` of the real part."""
        first, last = (0.0, self.leading_edge) if side == "upper" else (self.leading_edge, self.length.real)
        samples = self._samples()
        between = (samples > first) & (samples < last)
        s = np.concatenate([[first], samples[between], [last]])
        beginning, end = np.real(self.position([first, last])[:, 0])
        reached = np.concatenate([[beginning], self.outline[between, 0], [end]])
        f = reached - x
        for i in (0, -1):
            if abs(f[i]) < 1e-12 * self.length.real:
                return float(s[i])
        hits = np.flatnonzero((f[:-1] > 0) != (f[1:] > 0))
        if len(hits) != 1:
            how = "does not reach" if len(hits) == 0 else f"meets {len(hits)} times"
            raise InputError(
                f"the {side} side {how} x = {x:g}; it runs from x = {reached.min():g} to {reached.max():g}. "
                "Choose x in this range, or name the point by its arc length."
            )
        return root(lambda t: float(np.real(self.position(t)[0])) - x, s[hits[0]], s[hits[0] + 1], self.length.real)

    def _samples(self) -> np.ndarray:
        """Four arc lengths per interval between rows, the rows among them."""
        n = len(self.curve.point_s)
        return np.interp(np.arange(4 * (n - 1) + 1) / 4, np.arange(n), np.real(self.curve.point_s))

    def _foot(self, point: np.ndarray, i: int) -> float:
        """Root of (r(s) - point) . r'(s), real parts, next to sample i; the sample itself at an end of the loop."""
        s = self._samples()

        def along(t: float) -> float:
            angle = np.real(self.tangent_angle(t))
            return float((np.real(self.position(t)) - point) @ np.array([np.cos(angle), np.sin(angle)]))

        low, high = s[max(i - 1, 0)], s[min(i + 1, len(s) - 1)]
        if along(low) * along(high) > 0:
            return float(s[i])
        return root(along, low, high, self.length.real)

    def _distance_along(self, point: np.ndarray, s: Number) -> tuple[Number, Number]:
        """(r - point) . t and its derivative by s, 1 + (r - point) . dt/ds, with dt/ds = curvature times t turned by +90 degrees."""
        miss, (x, y) = self.position(s) - point, self.curve.direction(s)
        return miss @ np.array([x, y]), 1 + self.curvature(s) * (miss @ np.array([-y, x]))
