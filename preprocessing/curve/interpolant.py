"""A spline curve stretched along both axes, at real and complex parameters.

    r(u) = D r_0(u),    D = diag(d_x, d_y)

The knots belong to the real curve r_0 and stay, whatever D is. A complex parameter u = a + i b means the polynomial of the piece
that a lies in, r_0(u) = sum_k r_0^(k)(a) (i b)^k / k!.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline


@dataclass(frozen=True, eq=False)
class Interpolant:
    """The curve r(u) and its derivatives, addressed like a spline of scipy."""

    derivatives: tuple[BSpline, ...]  # of r_0, from order 0 to the degree
    stretch: np.ndarray | None = None  # (2,) the diagonal of D, real or complex; none for 1

    @classmethod
    def through(cls, u: np.ndarray, points: np.ndarray, degree: int) -> Interpolant:
        """The spline with r(u_i) = point i, with not-a-knot ends."""
        spline = make_interp_spline(u, points, k=degree)
        return cls((spline, *(spline.derivative(order) for order in range(1, degree + 1))))

    def __call__(self, u: np.ndarray, order: int = 0) -> np.ndarray:
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
        """This curve with both coordinates multiplied, by which its parametrisation does not change."""
        before = np.ones(2) if self.stretch is None else self.stretch
        return Interpolant(self.derivatives, before * np.array([x, y]))
