"""Bushing in the plane: two springs and dampers along the axes of a body, and one between the rotations."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from toolkit.description.description import NotNegative
from toolkit.description.quantity import Quantity
from toolkit.foundation.kernel import kernel
from toolkit.loads.acting import Acting
from toolkit.loads.kernels.measured_spring import add_measured_spring
from toolkit.loads.places import BetweenBodies
from toolkit.loads.planar.load import PlanarLoad
from toolkit.markers.component import Skeleton


@kernel
def bushing(z, w, force, force_z, force_w):
    """f = -sum (k u + c u') u_z of u_1, u_2 = e_1a . d, e_2a . d, d = r_a - r_b, and u_3 = angle_a - angle_b; see `measured_spring`.

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

    def parameters(self, _scene: Skeleton) -> list[Any]:
        """Parameters of the law: three stiffnesses and three dampings."""
        return [*self.stiffness, self.rotational_stiffness, *self.damping, self.rotational_damping]
