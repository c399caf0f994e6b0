"""Planar beam elements, with shear or without: those of space whose nodes, displacements and second axis lie in the plane.

Nodal coordinates of an element: x, y, rotation at its first end, then at its second, all in the global axes. With r in [0, 1]
along the element, L its length, e its direction and n = e turned by +90 degrees,

    displacement  u(r) = S(r) u_e = e a(r) u_e + n w(r) u_e,    rotation  (1/L) w'(r) u_e

    a: (1 - r) u_1 + r u_2
    w: (1 - 3r^2 + 2r^3) v_1 + L (r - 2r^2 + r^3) th_1 + (3r^2 - 2r^3) v_2 + L (r^3 - r^2) th_2

In the coordinates of `spatial_beam` these are x, y and the rotation about z of both ends, with e_2 = n and e_3 = z. Every function returns
polynomial coefficients or matrices of all elements at once (first axis), for unit parameters of the section. Rotary inertia is a matrix of
its own, on one coordinate more, the offset of `spatial_beam`. Shear deforms elements of which Phi is given, `phi` (n_e,), as it says there.
The textbook matrices: Przemieniecki, Theory of Matrix Structural Analysis (1968), chapters 5 and 11.
"""

from __future__ import annotations

import numpy as np

from preprocessing.elements import spatial_beam
from preprocessing.elements.spatial_beam import SECOND, Phi

IN_PLANE = [0, 1, 5, 6, 7, 11]
"""Coordinates of the planar element among those of the spatial one."""
WITH_OFFSET = [*IN_PLANE, 12]
"""The same with the offset, one in the undeformed shape and zero in every displacement."""


def _in_space(ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ends (n_e, 2, 3) at z = 0 and axes of the same elements in space."""
    flat = np.concatenate([ends, np.zeros((len(ends), 2, 1))], axis=2)
    return flat, spatial_beam.axes(flat, np.tile([0.0, 0.0, 1.0], (len(ends), 1)))


def length(ends: np.ndarray) -> np.ndarray:
    """Lengths (n_e,) of elements with ends (n_e, 2, 2)."""
    return spatial_beam.length(ends)


def directions(ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors e along the elements and n = e turned by +90 degrees, both (n_e, 2)."""
    _, triad = _in_space(ends)
    return triad[:, 0, :2], triad[:, 1, :2]


def _of_plane(phi: Phi) -> Phi:
    """Phi of both axes of elements in space, (n_e, 2)."""
    return None if phi is None else np.column_stack([phi, 0 * phi])


def shape(ends: np.ndarray, phi: Phi = None) -> np.ndarray:
    """Coefficients of r^k in the displacement S(r) in global axes, (n_e, 4, 2, 6)."""
    return spatial_beam.shape(*_in_space(ends), _of_plane(phi))[:, :, :2, IN_PLANE]


def rotation(ends: np.ndarray, phi: Phi = None) -> np.ndarray:
    """Coefficients of r^k in the rotation of the section, w'(r) / L without shear, (n_e, 4, 6)."""
    return spatial_beam.rotation(*_in_space(ends), _of_plane(phi))[:, :, 2, IN_PLANE]


def component_mass(ends: np.ndarray, phi: Phi = None) -> np.ndarray:
    """Component mass matrices M_ab = L int S_a^T S_b dr for unit mass per length, (n_e, 2, 2, 6, 6)."""
    return spatial_beam.products(ends, shape(ends, phi))


def rotary_mass(ends: np.ndarray, phi: Phi = None) -> np.ndarray:
    """Component mass matrices of the section's spread along n for unit rho int n^2 dA, with the offset last, (n_e, 2, 2, 7, 7)."""
    flat, triad = _in_space(ends)
    return spatial_beam.products(flat, spatial_beam.offset(flat, triad, SECOND, _of_plane(phi))[:, :, :2, WITH_OFFSET])


def strain(ends: np.ndarray) -> np.ndarray:
    """Row eps = a'(r) / L of the axial strain, constant along the element, (n_e, 6)."""
    return spatial_beam.strain(*_in_space(ends))[:, IN_PLANE]


def curvature(ends: np.ndarray, phi: Phi = None) -> np.ndarray:
    """Rows kappa = w''(r) / L^2 of the curvature change at both ends, (n_e, 2, 6); positive turns anticlockwise."""
    return spatial_beam.curvature(*_in_space(ends), SECOND, _of_plane(phi))[:, :, IN_PLANE]


def stretching(ends: np.ndarray) -> np.ndarray:
    """Rows F (n_e, 1, 6) of the stiffness F^T F for unit E A."""
    return spatial_beam.stretching(*_in_space(ends))[:, :, IN_PLANE]


def bending(ends: np.ndarray, phi: Phi = None) -> np.ndarray:
    """Rows F (n_e, 2, 6) of the stiffness F^T F for unit E I."""
    return spatial_beam.bending(*_in_space(ends), SECOND, _of_plane(phi))[:, :, IN_PLANE]


def shearing(ends: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """Rows F (n_e, 1, 6) of the stiffness F^T F for unit kappa G A."""
    flat, triad = _in_space(ends)
    return spatial_beam.shearing(flat, triad, SECOND, np.column_stack([phi, phi]))[:, :, IN_PLANE]


def turning(ends: np.ndarray, phi: Phi = None) -> np.ndarray:
    """Rows F (n_e, 3, 6) whose squares sum up to the integral of the square of the slope along the element."""
    return spatial_beam.turning(*_in_space(ends), SECOND, _of_plane(phi))[:, :, IN_PLANE]
