"""Functions along a straight beam between its two ends: linear along it, Hermite's cubics across it.

With r in [0, 1] along the element and L its length, the displacements along it and across it are

    a(r) = (1 - r) u_1 + r u_2
    w(r) = (1 - 3r^2 + 2r^3) v_1 + L (r - 2r^2 + r^3) th_1 + (3r^2 - 2r^3) v_2 + L (r^3 - r^2) th_2
"""

from __future__ import annotations

import numpy as np

AXIAL = np.array([[1, 0], [-1, 1], [0, 0], [0, 0]])
"""Powers of r (rows) in the functions of u_1, u_2."""
HERMITE = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [-3, -2, 3, -1], [2, 1, -2, 1]])
"""Powers of r (rows) in the functions of v_1, L th_1, v_2, L th_2."""
POWERS = np.arange(4)


def slope(coefficients: np.ndarray) -> np.ndarray:
    """Coefficients of the derivative by r, (4, ...), from those of a function, (4, ...)."""
    found = np.zeros_like(coefficients)
    found[:-1] = (coefficients[1:].T * POWERS[1:]).T
    return found


def values(coefficients: np.ndarray, r: np.ndarray) -> np.ndarray:
    """Functions given by their coefficients (4, n) at places r (m,), (n, m)."""
    return (r[:, None] ** POWERS @ coefficients).T
