"""Bushings: springs and dampers along the axes of a body, and between the rotations."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from toolkit.components.loads.load import Acting, BetweenBodies, PlanarLoad, SpatialLoad
from toolkit.components.markers.component import Skeleton
from toolkit.description.description import NotNegative, Quantity, Scalar
from toolkit.foundation.kernel import inner, kernel


@inner
def add_measured_spring(z, w, u, k, stiff, damp, force, force_z, force_w):
    """Adds f = -T u_z, T = k u + c u', u' = u_z . w, c = z[damp]; but for -T u_zz, T is returned. k is z[stiff], or zero of a damper alone.

        f_z = -u_z (k u_z + c u_zz w)^T - T u_zz,     f_w = -c u_z u_z^T

    On entry u_z is in column `stiff` of force_z, and u_zz w in column `damp`; on return they have the derivatives by k and c.
    """
    rate, n = 0 * u, len(w)
    for row in range(n):
        rate += force_z[row, stiff] * w[row]
    tension = k * u + z[damp] * rate
    for row in range(n):
        slope = force_z[row, stiff]
        if slope != 0:
            force[row] -= tension * slope
            for column in range(n):
                force_z[row, column] -= slope * (k * force_z[column, stiff] + z[damp] * force_z[column, damp])
                force_w[row, column] -= z[damp] * slope * force_z[column, stiff]
    for row in range(n):
        slope = force_z[row, stiff]
        force_z[row, stiff], force_z[row, damp] = -u * slope, -rate * slope
    return tension


@kernel
def bushing(z, w, force, force_z, force_w):
    """f = -sum (k u + c u') u_z of u_1, u_2 = e_1a . d, e_2a . d, d = r_a - r_b, and u_3 = angle_a - angle_b; see `add_measured_spring`.

    (k_1, k_2, k_3) = z[6:9], (c_1, c_2, c_3) = z[9:12]. With e' = de/d angle_a: u_z = (e, e' . d, -e, 0), u_zz in the angle is -u.
    """
    cosine, sine = np.cos(z[2]), np.sin(z[2])
    for m in range(2):
        x, y = (cosine, sine) if m == 0 else (-sine, cosine)
        u = x * (z[0] - z[3]) + y * (z[1] - z[4])
        force_z[0, 6 + m], force_z[1, 6 + m], force_z[3, 6 + m], force_z[4, 6 + m] = x, y, -x, -y
        force_z[2, 6 + m] = -y * (z[0] - z[3]) + x * (z[1] - z[4])
        force_z[0, 9 + m], force_z[1, 9 + m], force_z[3, 9 + m], force_z[4, 9 + m] = -y * w[2], x * w[2], y * w[2], -x * w[2]
        force_z[2, 9 + m] = -y * (w[0] - w[3]) + x * (w[1] - w[4]) - u * w[2]
        tension = add_measured_spring(z, w, u, z[6 + m], 6 + m, 9 + m, force, force_z, force_w)
        for i in range(2):
            turned = -y if i == 0 else x
            for side in range(2):
                sign = 1 - 2 * side
                force_z[3 * side + i, 2] -= sign * tension * turned
                force_z[2, 3 * side + i] -= sign * tension * turned
        force_z[2, 2] += tension * u
    force_z[2, 8], force_z[5, 8] = 1, -1
    add_measured_spring(z, w, z[2] - z[5], z[8], 8, 11, force, force_z, force_w)


class Bushing(BetweenBodies, Acting, PlanarLoad):
    """Springs and dampers in both directions and between the rotations of two bodies.

    It is relaxed where the points coincide and nothing is turned. Forces -k_i u_i - c_i u_i', with the offsets u_1, u_2 of the point of
    body a from that of body b along the axes of body a, which are those of the coordinates in the undeformed configuration, and a torque
    -k angle - c angle', angle = angle_a - angle_b of any number of turns: the gradient of sum k_i u_i^2 / 2, less what damps.

    Attributes
    ----------
    stiffness
        k_1, k_2, in force/length.
    damping
        c_1, c_2, in force time/length.
    rotational_stiffness
        k, in torque/rad.
    rotational_damping
        c, in torque time/rad.
    """

    kind = "bushing"
    acts_by = ("stiffness", "damping", "rotational_stiffness", "rotational_damping")
    formula = bushing

    stiffness: Annotated[tuple[NotNegative, NotNegative], Quantity("force/length")] = (0.0, 0.0)
    damping: Annotated[tuple[NotNegative, NotNegative], Quantity("force time/length")] = (0.0, 0.0)
    rotational_stiffness: Annotated[NotNegative, Quantity("torque/angle")] = 0.0
    rotational_damping: Annotated[NotNegative, Quantity("torque time/angle")] = 0.0

    def parameters(self, _scene: Skeleton) -> list[Scalar]:
        """Parameters of the law: three stiffnesses and three dampings."""
        return [*self.stiffness, self.rotational_stiffness, *self.damping, self.rotational_damping]


Three = tuple[NotNegative, NotNegative, NotNegative]


@inner
def product(m, n):
    """Vectors and factor of product n of measure m, vectors 0 to 7 being r, e_1, e_2, e_3 of a and of b."""
    if m < 3:
        return 1 + m, 4 * n, 1.0 - 2 * n
    j, k = (m - 2) % 3, (m - 1) % 3
    return (1 + j, 5 + k, 0.5) if n == 0 else (1 + k, 5 + j, -0.5)


@kernel
def spatial_bushing(z, w, force, force_z, force_w):
    """f = -sum (k u + c u') u_z of offsets u_i = e_ia . (r_a - r_b), i = 0 to 2, and of the rotations between both axes

        - sum k_i (2 p_i)^2_z / 2 - sum c_i s_i' s_i,z,     s_i = (e_ja . e_kb - e_ka . e_jb) / 2,    (i, j, k) in cyclic order,

    p being the quaternion of the rotation, (2 p_i)^2 = 1 + R_ii - R_jj - R_kk, R_ii = e_ia . e_ib; k = z[24:30], c = z[30:36]. See
    `add_measured_spring`.
    """
    for m in range(6):
        u = 0 * z[0]
        for n in range(2):
            p, q, value = product(m, n)
            for c in range(3):
                u += value * z[3 * p + c] * z[3 * q + c]
                force_z[3 * p + c, 24 + m] += value * z[3 * q + c]
                force_z[3 * q + c, 24 + m] += value * z[3 * p + c]
                force_z[3 * p + c, 30 + m] += value * w[3 * q + c]
                force_z[3 * q + c, 30 + m] += value * w[3 * p + c]
        k = z[24 + m] if m < 3 else 0 * z[24]
        tension = add_measured_spring(z, w, u if m < 3 else 0 * u, k, 24 + m, 30 + m, force, force_z, force_w)
        for n in range(2):
            p, q, value = product(m, n)
            for c in range(3):
                force_z[3 * p + c, 3 * q + c] -= value * tension
                force_z[3 * q + c, 3 * p + c] -= value * tension
    for i in range(3):
        add_alignment(z, i, force, force_z)


@inner
def add_alignment(z, i, force, force_z):
    """Add what keeps e_ia at e_ib: f = K (R_ii)_z, K = (k_j + k_k - k_i) / 2."""
    pull = (z[27] + z[28] + z[29]) / 2 - z[27 + i]
    for c in range(3):
        a, b = 3 + 3 * i + c, 15 + 3 * i + c
        force[a] += pull * z[b]
        force[b] += pull * z[a]
        force_z[a, b] += pull
        force_z[b, a] += pull
        for n in range(3):
            share = -0.5 if n == i else 0.5
            force_z[a, 27 + n] += share * z[b]
            force_z[b, 27 + n] += share * z[a]


class SpatialBushing(BetweenBodies, Acting, SpatialLoad):
    """Springs and dampers in three directions and three small rotations.

    It is relaxed where the points coincide and nothing is turned. Forces are -k_i u_i - c_i u_i', with the offsets u_i = e_ia . (r_a - r_b)
    along the axes of body a, which are those of the coordinates in the undeformed configuration. The rotation of body a against body b by
    an angle about an axis n is measured by t = 2 sin(angle / 2) n, so that forces and torques are the gradient of
    sum k_i u_i^2 / 2 + sum k_i t_i^2 / 2, less what damps: about one axis

        torque = - k sin(angle) - c cos(angle)^2 angle'

    That is a small rotation's: at 30 degrees it is less than k angle by 4.5 % and than c angle' by 25 %. A run that goes further is
    doubted; beyond a quarter turn the torque would fall.

    Attributes
    ----------
    stiffness
        k of the three offsets, in force/length.
    damping
        c of the three offsets, in force time/length.
    rotational_stiffness
        k of the three rotations, in torque/rad.
    rotational_damping
        c of the three rotations, in torque time/rad.
    """

    kind = "bushing"
    acts_by = ("stiffness", "damping", "rotational_stiffness", "rotational_damping")
    formula = spatial_bushing

    stiffness: Annotated[Three, Quantity("force/length")] = (0.0, 0.0, 0.0)
    damping: Annotated[Three, Quantity("force time/length")] = (0.0, 0.0, 0.0)
    rotational_stiffness: Annotated[Three, Quantity("torque/angle")] = (0.0, 0.0, 0.0)
    rotational_damping: Annotated[Three, Quantity("torque time/angle")] = (0.0, 0.0, 0.0)

    def parameters(self, _scene: Skeleton) -> list[Scalar]:
        """Parameters of the law: six stiffnesses and six dampings."""
        return [*self.stiffness, *self.rotational_stiffness, *self.damping, *self.rotational_damping]
