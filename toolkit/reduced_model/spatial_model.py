"""What the reduced model of a spatial body holds in the place of a planar one's parts: invariants, surface and loads on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

PAIRS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
"""Components (a, b) of the six stored matrices Q[a, b]; the others are their transposes, Q[b, a] = Q[a, b]^T."""


@dataclass(frozen=True)
class SpatialInvariants:
    """Invariants of a spatial body, theory section 1, with Z = [xi, Psi] and n_f elastic coordinates.

        m     = t_a^T M_aa t_a             N[a, :] = t_a^T M_aa Z          Q[a, b] = Z^T M_ab Z
        K     = Psi^T K_fe Psi             D       = Psi^T D_fe Psi

    `stress_operator` maps the elastic coordinates to the stress at every stress point: six components (xx, yy, zz, yz, xz, xy) in the
    body's axes, or one (the stress of a fibre).
    """

    mass: np.ndarray  # ()
    first_moment: np.ndarray  # N (3, 1 + n_f)
    second_moment: np.ndarray  # Q (6, 1 + n_f, 1 + n_f) in the order of `PAIRS`
    stiffness: np.ndarray  # (n_f, n_f)
    damping: np.ndarray  # (n_f, n_f)
    stress_operator: np.ndarray  # (n_stress, 6 or 1, n_f)

    moments: ClassVar[tuple[str, ...]] = ("second_moment",)
    """Names of the arrays that are integrals of products of shapes."""

    @property
    def inertia_about_origin(self) -> np.ndarray:
        """Sum of Q[a, a] (1 + n_f, 1 + n_f): the kinetic energy's squares of deformation rates."""
        return self.second_moment[:3].sum(axis=0)

    def mass_across(self, axis: np.ndarray) -> np.ndarray:
        """Elastic mass that moves across an axis with unit vector n, sum_a Q[a, a] - sum_ab n_a n_b Q[a, b], (n_f, n_f)."""
        Q = all_second_moments(self.second_moment)
        return (np.einsum("aaij->ij", Q) - np.einsum("a,b,abij->ij", axis, axis, Q))[1:, 1:]


SURFACE_POSITION = "surface.position"
"""Item of the model that is where the points of its surface are."""


@dataclass(frozen=True)
class Surface:
    """The surface of a body, for pictures: points are `position @ [1; q_f]`.

    Stress points with six components are the surface's points, in their order; those with one are the ends of its lines in turn.
    """

    position: np.ndarray  # (n_points, 3, 1 + n_f)
    triangles: np.ndarray  # (n_triangles, 3) points, seen from outside counter-clockwise
    lines: np.ndarray  # (n_lines, 2) points; of beams, which have no triangles


@dataclass(frozen=True)
class SurfaceLoad:
    """A unit pressure on a named surface, normal to it in the undeformed body, theory chapter 12.

        f_a = - int n_a dA         L[a, b] = - int n_a (S Z)_b dA

    with the outer normal n and axes a and b of the body.
    """

    force: np.ndarray  # f (3,)
    moment: np.ndarray  # L (3, 3, 1 + n_f)


def all_second_moments(stored: np.ndarray) -> np.ndarray:
    """All nine Q[a, b] (3, 3, 1 + n_f, 1 + n_f) from the six that are stored."""
    found = np.zeros((3, 3, *stored.shape[1:]), stored.dtype)
    for matrix, (a, b) in zip(stored, PAIRS, strict=True):
        found[b, a] = matrix.T
        found[a, b] = matrix
    return found


def spatial_generalized_mass(inv: SpatialInvariants) -> np.ndarray:
    """Mass matrix of the undeformed, unrotated body in (r, rotation vector, q_f), theory section 1, scaled to a unit diagonal."""
    n, Q = len(inv.stiffness), all_second_moments(inv.second_moment)
    moments = Q[:, :, 0, 0]
    coupling = np.stack([Q[1, 2, 0, 1:] - Q[2, 1, 0, 1:], Q[2, 0, 0, 1:] - Q[0, 2, 0, 1:], Q[0, 1, 0, 1:] - Q[1, 0, 0, 1:]])
    x, y, z = inv.first_moment[:, 0]
    m = np.zeros((6 + n, 6 + n))
    m[:3, :3] = inv.mass * np.eye(3)
    m[:3, 3:6] = -np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    m[:3, 6:] = inv.first_moment[:, 1:]
    m[3:6, 3:6] = np.trace(moments) * np.eye(3) - moments
    m[3:6, 6:] = coupling
    m[6:, 6:] = Q[0, 0, 1:, 1:] + Q[1, 1, 1:, 1:] + Q[2, 2, 1:, 1:]
    m = np.triu(m) + np.triu(m, 1).T
    scale = 1 / np.sqrt(np.diag(m).clip(np.finfo(float).tiny))
    return scale[:, None] * m * scale


def spatial_lengths(inv: SpatialInvariants) -> np.ndarray:
    """RMS displacement of the whole body per unit of each elastic coordinate, sqrt(sum_a Q[a, a]_ii / m), shape (n_f,)."""
    return np.sqrt(np.diag(inv.second_moment[:3].sum(axis=0))[1:] / inv.mass)
