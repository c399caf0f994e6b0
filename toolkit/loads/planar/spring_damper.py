"""Spring-dampers: between two points, or between the rotations of two bodies."""

from __future__ import annotations

import numpy as np

from toolkit.foundation.kernel import kernel
from toolkit.loads.planar.load import PlanarLoad
from toolkit.loads.springs import PointSpring, TurnSpring


@kernel
def spring_damper(z, w, force, force_z, force_w):
    """f_a = -T e = -f_b, T = k (l - l_0) + c l', d = r_a - r_b, l = |d|, e = d / l, (k, c, l_0) = parameters.

    df_a/dd = -[e T_d^T + T P / l],  T_d = k e + c P v / l,  df_a/dv = -c e e^T,  P = I - e e^T,  v = d'
    """
    k, c, rest = z[6], z[7], z[8]
    d_x, d_y = z[0] - z[3], z[1] - z[4]
    v_x, v_y = w[0] - w[3], w[1] - w[4]
    length = np.sqrt(d_x * d_x + d_y * d_y)
    e_x, e_y = d_x / length, d_y / length
    rate = e_x * v_x + e_y * v_y
    tension = k * (length - rest) + c * rate
    across = (-e_y * v_x + e_x * v_y) / length
    t_x, t_y = k * e_x - c * e_y * across, k * e_y + c * e_x * across
    for side in range(2):
        sign = 1 - 2 * side
        for i in range(2):
            e_i = e_x if i == 0 else e_y
            row = 3 * side + i
            force[row] = -sign * tension * e_i
            force_z[row, 6], force_z[row, 7], force_z[row, 8] = -sign * (length - rest) * e_i, -sign * rate * e_i, sign * k * e_i
            for j in range(2):
                e_j, t_j = (e_x, t_x) if j == 0 else (e_y, t_y)
                projection = (1 if i == j else 0) - e_i * e_j
                stiffness = e_i * t_j + tension * projection / length
                for other in range(2):
                    column = 3 * other + j
                    force_z[row, column] = -sign * (1 - 2 * other) * stiffness
                    force_w[row, column] = -sign * (1 - 2 * other) * c * e_i * e_j


@kernel
def rotational_spring_damper(z, w, force, force_z, force_w):
    """torque_a = -k (angle_a - angle_b - angle_0) - c (angle_a - angle_b)' = -torque_b, (k, c, angle_0) = parameters."""
    angle, rate = z[2] - z[5] - z[8], w[2] - w[5]
    for side in range(2):
        row, sign = 3 * side + 2, 1 - 2 * side
        force[row] = -sign * (z[6] * angle + z[7] * rate)
        force_z[row, 6], force_z[row, 7], force_z[row, 8] = -sign * angle, -sign * rate, sign * z[6]
        for other in range(2):
            force_z[row, 3 * other + 2] = -sign * (1 - 2 * other) * z[6]
            force_w[row, 3 * other + 2] = -sign * (1 - 2 * other) * z[7]


class SpringDamper(PointSpring, PlanarLoad):
    """Force -k (l - length) - c l' along the line between two points; without `length` the spring is relaxed at the start."""

    kind = "spring-damper"
    formula = spring_damper


class RotationalSpringDamper(TurnSpring, PlanarLoad):
    """Torque -k (angle - rest_angle) - c angle' between two bodies, angle = relative rotation since the undeformed configuration."""

    kind = "rotational-spring-damper"
    formula = rotational_spring_damper
