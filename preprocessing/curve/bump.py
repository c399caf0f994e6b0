"""Bumps of a contour: smooth displacements along its outward normal n, the design variables of its shape.

    r(s) = r_0(s) + B(s) n(s),    B(s) = sum_j h_j b((s - c_j) / w_j),    b(q) = (1 - q^2)^4 for |q| < 1, and 0 outside

s is the arc length of the curve without bumps, c the centre, w the half width, h the height; b has three continuous derivatives.
With the unit tangent t, the curvature k of that curve (positive where convex) and dt/ds = -k n, dn/ds = k t follow

    dr/ds - dr_0/ds = k B t + B' n
    d2r/ds2 - d2r_0/ds2 = (2 k B' + k' B) t + (B'' - k^2 B) n

The parameter of the curve without bumps stays the parameter, whatever the heights are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from preprocessing.curve.arc_length_spline import ArcLengthSpline, Number, norm
from preprocessing.curve.contour import Contour
from toolkit.foundation.errors import InputError

NARROWEST = 1e-6
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
        if np.real(self.half_width) < NARROWEST * length:
            raise InputError(
                f"half_width {np.real(self.half_width):g} is less than {NARROWEST:g} of the contour's length {length:g}. Give a "
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

    def __call__(self, u: np.ndarray, order: int = 0) -> np.ndarray:
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
