"""The contour of an airfoil in the user's length unit: a spline in arc length that knows its leading edge and two sides."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from preprocessing.arc_length_spline import ArcLengthSpline
from toolkit.errors import InputError

SIDES = ("upper", "lower")


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

    @property
    def length(self) -> float:
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

    def at_row(self, i: int) -> float:
        """Arc length of row i of the points, counted from 0.

        Raises
        ------
        InputError
            There is no such row.
        """
        n = len(self.curve.point_s)
        if not 0 <= i < n:
            raise InputError(f"row {i} is not on the contour: its rows count from 0 to {n - 1}.")
        return float(self.curve.point_s[i])

    @property
    def outline(self) -> np.ndarray:
        """Points (n, 2) to draw the contour by: the rows, and three between any two, for a nose of few rows is round too."""
        return self.position(self._samples())

    @cached_property
    def leading_edge(self) -> float:
        """Arc length of the point farthest from the middle of the trailing edge."""
        rows = self.curve.spline(self.curve.point_u)
        tail = (rows[0] + rows[-1]) / 2
        s = self._samples()
        return self._foot(tail, s, int(np.argmax(np.linalg.norm(self.position(s) - tail, axis=1))))

    def nearest(self, point: np.ndarray) -> float:
        """Arc length of the point of the contour nearest to `point` (2,)."""
        s = self._samples()
        return self._foot(np.asarray(point), s, int(np.argmin(np.linalg.norm(self.position(s) - point, axis=1))))

    def at_x(self, x: float, side: str) -> float:
        """Arc length where the upper or lower side, split at the leading edge, has abscissa x.

        Raises
        ------
        InputError
            Unknown side, x not on that side, or met more than once there (round nose or tail).
        """
        if side not in SIDES:
            raise InputError(f"side {side!r} is unknown; available: {', '.join(SIDES)}.")
        first, last = (0.0, self.leading_edge) if side == "upper" else (self.leading_edge, self.length)
        samples = self._samples()
        s = np.concatenate([[first], samples[(samples > first) & (samples < last)], [last]])
        reached = self.position(s)[:, 0]
        f = reached - x
        for end in (0, -1):
            if abs(f[end]) < 1e-12 * self.length:
                return float(s[end])
        hits = np.flatnonzero((f[:-1] > 0) != (f[1:] > 0))
        if len(hits) != 1:
            how = "does not reach" if len(hits) == 0 else f"meets {len(hits)} times"
            raise InputError(
                f"the {side} side {how} x = {x:g}; it runs from x = {reached.min():g} to {reached.max():g}. "
                "Choose x in this range, or name the point by its arc length."
            )
        return float(brentq(lambda t: self.position(t)[0] - x, s[hits[0]], s[hits[0] + 1], xtol=1e-14 * self.length))

    def _samples(self) -> np.ndarray:
        """Four arc lengths per interval between rows, the rows among them."""
        n = len(self.curve.point_s)
        return np.interp(np.arange(4 * (n - 1) + 1) / 4, np.arange(n), self.curve.point_s)

    def _foot(self, point: np.ndarray, s: np.ndarray, i: int) -> float:
        """Root of (r(s) - point) . r'(s) next to sample i; the sample itself at an end of the loop."""

        def along(t: float) -> float:
            angle = self.tangent_angle(t)
            return float((self.position(t) - point) @ np.array([np.cos(angle), np.sin(angle)]))

        low, high = s[max(i - 1, 0)], s[min(i + 1, len(s) - 1)]
        if along(low) * along(high) > 0:
            return float(s[i])
        return float(brentq(along, low, high, xtol=1e-14 * self.length))
