"""Bushing in space: three springs and dampers along the axes of a body, and three of small rotations."""

from __future__ import annotations

from typing import Annotated, Any

from toolkit.description.description import NotNegative
from toolkit.description.quantity import Quantity
from toolkit.foundation.kernel import inner, kernel
from toolkit.loads.acting import Acting
from toolkit.loads.kernels.measured_spring import add_measured_spring
from toolkit.loads.places import BetweenBodies
from toolkit.loads.spatial.load import SpatialLoad
from toolkit.markers.component import Skeleton

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
    `measured_spring`.
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

    def parameters(self, _scene: Skeleton) -> list[Any]:
        """Parameters of the law: six stiffnesses and six dampings."""
        return [*self.stiffness, *self.rotational_stiffness, *self.damping, *self.rotational_damping]
