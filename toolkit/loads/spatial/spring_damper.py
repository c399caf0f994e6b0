"""Spring-damper between two points in space."""

from __future__ import annotations

import numpy as np

from toolkit.foundation.kernel import kernel
from toolkit.loads.spatial.load import SpatialLoad
from toolkit.loads.springs import PointSpring


@kernel
def spatial_spring_damper(z, w, force, force_z, force_w):
    """f_a = -T e = -f_b, T = k (l - l_0) + c l', d = r_a - r_b, l = |d|, e = d / l, (k, c, l_0) = parameters.

    df_a/dd = -[e T_d^T + T P / l],  T_d = k e + c P v / l,  df_a/dv = -c e e^T,  P = I - e e^T,  v = d'
    """
    k, c, rest = z[24], z[25], z[26]
    square, pull = 0 * k, 0 * k
    for i in range(3):
        square += (z[i] - z[12 + i]) * (z[i] - z[12 + i])
        pull += (z[i] - z[12 + i]) * (w[i] - w[12 + i])
    length = np.sqrt(square)
    rate = pull / length
    tension = k * (length - rest) + c * rate
    for side in range(2):
        sign = 1 - 2 * side
        for i in range(3):
            e_i = (z[i] - z[12 + i]) / length
            row = 12 * side + i
            force[row] = -sign * tension * e_i
            force_z[row, 24], force_z[row, 25], force_z[row, 26] = (
                -sign * (length - rest) * e_i,
                -sign * rate * e_i,
                sign * k * e_i,
            )
            for j in range(3):
                e_j, v_j = (z[j] - z[12 + j]) / length, w[j] - w[12 + j]
                t_j = k * e_j + c * (v_j - rate * e_j) / length
                projection = (1 if i == j else 0) - e_i * e_j
                stiffness = e_i * t_j + tension * projection / length
                for other in range(2):
                    column = 12 * other + j
                    force_z[row, column] = -sign * (1 - 2 * other) * stiffness
                    force_w[row, column] = -sign * (1 - 2 * other) * c * e_i * e_j


class SpatialSpringDamper(PointSpring, SpatialLoad):
    """Force -k (l - length) - c l' along the line between two points; without `length` the spring is relaxed at the start."""

    kind = "spring-damper"
    formula = spatial_spring_damper

    @property
    def feels_axes(self) -> bool:
        """Whether the load feels axes of markers: no, only their positions."""
        return False
