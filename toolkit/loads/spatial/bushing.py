"""Bushing in space: three springs and dampers along the axes of a body, and three of small rotations."""

from __future__ import annotations

from typing import Annotated, Any

from toolkit.description.description import NotNegative
from toolkit.description.quantity import Quantity
from toolkit.foundation.kernel import inner, kernel
from toolkit.loads.kernels.measured_spring import add_measured_spring
from toolkit.loads.spatial.load import SpatialLoad
from toolkit.loads.springs import BetweenBodies
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
    """f = -sum (k u + c u') u_z of six measures, each a sum of two products of vectors; see `measured_spring`.

    u_i = e_ia . (r_a - r_b),  u_3+i = (e_ja . e_kb - e_ka . e_jb) / 2 with (i, j, k) in cyclic order; k = z[24:30], c = z[30:36].
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
        tension = add_measured_spring(z, w, u, 24 + m, 30 + m, force, force_z, force_w)
        for n in range(2):
            p, q, value = product(m, n)
            for c in range(3):
                force_z[3 * p + c, 3 * q + c] -= value * tension
                force_z[3 * q + c, 3 * p + c] -= value * tension


class SpatialBushing(BetweenBodies, SpatialLoad):
    """Springs and dampers in three directions and three small rotations; relaxed where the points coincide and nothing is turned.

    Forces -k_i u_i - c_i u_i', with the offsets u_i = e_ia . (r_a - r_b) along the axes of body a, which are those of the coordinates in
    the undeformed configuration, and torques of the rotations

        s_i = (e_ja . e_kb - e_ka . e_jb) / 2,     s = n sin(angle) for a turn of body a against body b about any axis n

    Together they are the gradient of sum k_i u_i^2 / 2 + sum k_i s_i^2 / 2. That is a small rotation's: at 30 degrees s is 4.5 % less than
    the angle, where a run is doubted, and beyond a quarter turn the torque would fall.

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
    formula = spatial_bushing
    called = "bushing"

    stiffness: Annotated[Three, Quantity("force/length")] = (0.0, 0.0, 0.0)
    damping: Annotated[Three, Quantity("force time/length")] = (0.0, 0.0, 0.0)
    rotational_stiffness: Annotated[Three, Quantity("torque/angle")] = (0.0, 0.0, 0.0)
    rotational_damping: Annotated[Three, Quantity("torque time/angle")] = (0.0, 0.0, 0.0)

    def parameters(self, _scene: Skeleton) -> list[Any]:
        """Six stiffnesses and six dampings."""
        return [*self.stiffness, *self.rotational_stiffness, *self.damping, *self.rotational_damping]
