"""Spring-damper between the rotations of two bodies about an axis in space."""

from __future__ import annotations

from toolkit.foundation.kernel import inner, kernel
from toolkit.joints.kernels.laws import angle_of
from toolkit.loads.spatial.load import SpatialLoad
from toolkit.loads.springs import TurnSpring
from toolkit.markers.about_axis import AboutAxis


@kernel
def spatial_rotational_spring_damper(z, w, force, force_z, force_w):
    """f = - T theta_z, T = k (theta - theta_0) + c theta', theta = atan2(s, c) with s = e_1a . e_2b, c = e_1a . e_1b.

    (k, c, theta_0) = z[24:27], theta_z = (c s_z - s c_z) / d, d = c^2 + s^2, theta' = theta_z . w; the derivative of theta_z in a
    direction u is

        [(c s_zu - s c_zu) + (c_u s_z - s_u c_z)] / d - theta_z (2 c c_u + 2 s s_u) / d
    """
    cosine, sine = 0 * z[0], 0 * z[0]
    for i in range(3, 6):
        cosine += z[i] * z[12 + i]
        sine += z[i] * z[15 + i]
    square, rate = cosine * cosine + sine * sine, 0 * z[0]
    for i in range(3, 6):
        force[i], force[12 + i], force[15 + i] = cosine * z[15 + i] - sine * z[12 + i], -sine * z[i], cosine * z[i]
    for i in range(24):
        force[i] = force[i] / square  # theta_z
        rate += force[i] * w[i]
    angle = angle_of(sine, cosine) - z[26]
    torque = z[24] * angle + z[25] * rate
    for column in range(25):  # the last one is the direction of the rates
        cosine_u, sine_u = 0 * z[0], 0 * z[0]
        for i in range(3, 6):
            u, u_b, u_c = unit(column, i, w), unit(column, 12 + i, w), unit(column, 15 + i, w)
            cosine_u += u * z[12 + i] + z[i] * u_b
            sine_u += u * z[15 + i] + z[i] * u_c
        grown = 2 * (cosine * cosine_u + sine * sine_u) / square
        for i in range(3, 6):
            u, u_b, u_c = unit(column, i, w), unit(column, 12 + i, w), unit(column, 15 + i, w)
            turns = (
                (cosine * u_c - sine * u_b + cosine_u * z[15 + i] - sine_u * z[12 + i]) / square - force[i] * grown,
                (-sine * u - sine_u * z[i]) / square - force[12 + i] * grown,
                (cosine * u + cosine_u * z[i]) / square - force[15 + i] * grown,
            )
            for side in range(3):
                row = i + (0 if side == 0 else 9 + 3 * side)
                if column < 24:
                    force_z[row, column] = -torque * turns[side]
                else:
                    force_z[row, 27] = turns[side]  # theta_zz w, until it is used up below
    for row in range(24):
        for column in range(24):
            force_z[row, column] -= force[row] * (z[24] * force[column] + z[25] * force_z[column, 27])
            force_w[row, column] = -z[25] * force[row] * force[column]
    for row in range(24):
        force_z[row, 27] = 0
        force_z[row, 24], force_z[row, 25], force_z[row, 26] = -angle * force[row], -rate * force[row], z[24] * force[row]
    for row in range(24):
        force[row] = -torque * force[row]


@inner
def unit(column, i, w):
    """Entry i of a direction: of the unit vector `column`, or of w."""
    if column == 24:
        return w[i]
    return 1 + 0 * w[i] if column == i else 0 * w[i]


class SpatialRotationalSpringDamper(AboutAxis, TurnSpring, SpatialLoad):
    """Torque -k (angle - rest_angle) - c angle' about an axis between two bodies, angle in (-pi, pi] since the undeformed configuration.

    Both bodies turn against each other about this axis alone: a revolute or cylindrical joint with the same axis has to stand beside it.
    """

    kind = "rotational-spring-damper"
    formula = spatial_rotational_spring_damper
    folds = True
