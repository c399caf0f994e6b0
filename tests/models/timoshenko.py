"""Timoshenko's beam by transfer matrices: a reference without finite elements."""

from __future__ import annotations

import numpy as np
import scipy


def cantilever_frequency(near: float, modulus: float, density: float, thickness: float, shear: float) -> float:
    """The frequency of a cantilever of unit length and width next to one that is given; `shear` is kappa G / E."""
    found = scipy.optimize.brentq(
        _clamped, 0.93 * near, 1.07 * near, args=(modulus, density, thickness, shear), xtol=1e-10 * near
    )
    return float(found)


def _clamped(frequency: float, modulus: float, density: float, thickness: float, shear: float) -> float:
    """Zero where w = theta = 0 at one end leaves M = V = 0 at the other, w' = theta + V / kappa G A, M' = -V - rho I omega^2 theta."""
    area, second, square = thickness, thickness**3 / 12, (2 * np.pi * frequency) ** 2
    along = np.array(
        [
            [0, 1, 0, 1 / (shear * modulus * area)],
            [0, 0, 1 / (modulus * second), 0],
            [0, -density * second * square, 0, -1],
            [-density * area * square, 0, 0, 0],
        ]
    )
    scale = np.array([1, 1, modulus * second, modulus * second])
    return float(np.linalg.det(scipy.linalg.expm(along * scale / scale[:, None])[2:, 2:]))
