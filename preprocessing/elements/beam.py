"""Planar Euler-Bernoulli beam elements, straight between their two nodes, linear along and Hermite cubic across.

Nodal coordinates of an element: x, y, rotation at its first end, then at its second, all in the global axes. With r in [0, 1]
along the element, L its length, e its direction and n = e turned by +90 degrees,

    displacement  u(r) = S(r) u_e = e a(r) u_e + n w(r) u_e,    rotation  (1/L) w'(r) u_e

    a: (1 - r) u_1 + r u_2
    w: (1 - 3r^2 + 2r^3) v_1 + L (r - 2r^2 + r^3) th_1 + (3r^2 - 2r^3) v_2 + L (r^3 - r^2) th_2

Every function returns polynomial coefficients or matrices of all elements at once (first axis), for unit parameters of the
section; `section.py` holds the powers of the parameters that multiply them. No rotary inertia, no shear deformation. The
textbook matrices: Przemieniecki, Theory of Matrix Structural Analysis (1968), chapters 5 and 11.
"""

from __future__ import annotations

import numpy as np

from toolkit.kinematics.beam_functions import AXIAL, HERMITE, POWERS


def length(ends: np.ndarray) -> np.ndarray:
    """Lengths (n_e,) of elements with ends (n_e, 2, 2)."""
    return np.sqrt(((ends[:, 1] - ends[:, 0]) ** 2).sum(axis=1))


def directions(ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors e along the elements and n = e turned by +90 degrees, both (n_e, 2)."""
    along = (ends[:, 1] - ends[:, 0]) / length(ends)[:, None]
    return along, np.column_stack([-along[:, 1], along[:, 0]])


def axial(ends: np.ndarray) -> np.ndarray:
    """Coefficients of r^k in the displacement a(r) along the element, (n_e, 4, 6)."""
    along, _ = directions(ends)
    coefficients = np.zeros((len(ends), 4, 6), dtype=ends.dtype)
    coefficients[:, :, 0:2] = AXIAL[:, 0, None] * along[:, None, :]
    coefficients[:, :, 3:5] = AXIAL[:, 1, None] * along[:, None, :]
    return coefficients


def transverse(ends: np.ndarray) -> np.ndarray:
    """Coefficients of r^k in the displacement w(r) across the element, (n_e, 4, 6)."""
    _, across = directions(ends)
    coefficients = np.zeros((len(ends), 4, 6), dtype=ends.dtype)
    coefficients[:, :, 0:2] = HERMITE[:, 0, None] * across[:, None, :]
    coefficients[:, :, 3:5] = HERMITE[:, 2, None] * across[:, None, :]
    coefficients[:, :, 2] = HERMITE[:, 1] * length(ends)[:, None]
    coefficients[:, :, 5] = HERMITE[:, 3] * length(ends)[:, None]
    return coefficients


def shape(ends: np.ndarray) -> np.ndarray:
    """Coefficients of r^k in the displacement S(r) in global axes, (n_e, 4, 2, 6)."""
    along, across = directions(ends)
    return along[:, None, :, None] * axial(ends)[:, :, None, :] + across[:, None, :, None] * transverse(ends)[:, :, None, :]


def rotation(ends: np.ndarray) -> np.ndarray:
    """Coefficients of r^k in the rotation w'(r) / L of the beam, (n_e, 4, 6)."""
    coefficients = np.zeros_like(transverse(ends))
    coefficients[:, :-1] = POWERS[1:, None] * transverse(ends)[:, 1:]
    return coefficients / length(ends)[:, None, None]


def component_mass(ends: np.ndarray) -> np.ndarray:
    """Component mass matrices M_ab = L int S_a^T S_b dr for unit mass per length, (n_e, 2, 2, 6, 6).

    Exact, because int r^j r^k dr = 1 / (j + k + 1) on [0, 1].
    """
    moments = 1 / (POWERS[:, None] + POWERS + 1)
    functions = shape(ends)
    integral = np.einsum("ejap,jk,ekbq->eabpq", functions, moments, functions)
    return length(ends)[:, None, None, None, None] * integral


def strain(ends: np.ndarray) -> np.ndarray:
    """Row eps = a'(r) / L of the axial strain, constant along the element, (n_e, 6)."""
    return axial(ends)[:, 1] / length(ends)[:, None]


def curvature(ends: np.ndarray) -> np.ndarray:
    """Rows kappa = w''(r) / L^2 of the curvature change at both ends, (n_e, 2, 6); positive turns anticlockwise."""
    functions = transverse(ends)
    at_ends = np.stack([2 * functions[:, 2], 2 * functions[:, 2] + 6 * functions[:, 3]], axis=1)
    return at_ends / length(ends)[:, None, None] ** 2


def stretching_stiffness(ends: np.ndarray) -> np.ndarray:
    """Stiffness L eps^T eps for unit E A, (n_e, 6, 6)."""
    row = strain(ends)
    return length(ends)[:, None, None] * row[:, :, None] * row[:, None, :]


def stretching(ends: np.ndarray) -> np.ndarray:
    """Rows F (n_e, 1, 6) of the stiffness F^T F for unit E A."""
    return np.sqrt(length(ends))[:, None, None] * strain(ends)[:, None]


def bending(ends: np.ndarray) -> np.ndarray:
    """Rows F (n_e, 2, 6) of the stiffness F^T F for unit E I: of the curvature's mean and of its difference between the ends.

    The integral of the square of a linear curvature is L (mean^2 + difference^2 / 12).
    """
    at_ends = curvature(ends)
    rows = [at_ends.mean(axis=1), (at_ends[:, 1] - at_ends[:, 0]) / np.sqrt(12)]
    return np.sqrt(length(ends))[:, None, None] * np.stack(rows, axis=1)


def bending_stiffness(ends: np.ndarray) -> np.ndarray:
    """Stiffness L int kappa^T kappa dr for unit E I, (n_e, 6, 6).

    The curvature is linear along the element, so the integral of its square is [1/3, 1/6; 1/6, 1/3] in its values at the ends.
    """
    moments = np.array([[2, 1], [1, 2]]) / 6
    rows = curvature(ends)
    return length(ends)[:, None, None] * np.einsum("ejp,jk,ekq->epq", rows, moments, rows)
