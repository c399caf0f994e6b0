"""Spring-dampers: between two points, or between the rotations of two bodies."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import numpy as np

from toolkit.components.joints.rows import RowQuantity
from toolkit.components.loads.kernels.along import counted_turns, spring_along
from toolkit.components.loads.kernels.measured import space_angle
from toolkit.components.loads.load import Acting, BetweenBodies, BetweenPoints, PlanarLoad, SpatialLoad
from toolkit.components.markers.component import AboutAxis, Skeleton
from toolkit.description.description import NotNegative, Number, Quantity, Scalar
from toolkit.foundation.kernel import kernel


class PointSpring(BetweenPoints, Acting):
    """Force -k (l - length) - c l' along the line between two points; without `length` the spring is relaxed at the start.

    Attributes
    ----------
    stiffness
        k, in force/length.
    damping
        c, in force time/length.
    length
        Relaxed length; by default the distance of the points in the undeformed configuration.
    """

    kind: ClassVar[str] = "spring-damper"

    stiffness: Annotated[NotNegative, Quantity("force/length")] = 0.0
    damping: Annotated[NotNegative, Quantity("force time/length")] = 0.0
    length: Annotated[NotNegative | None, Quantity("length")] = None

    def parameters(self, scene: Skeleton) -> list[Scalar]:
        """Parameters of the law: stiffness, damping, relaxed length."""
        d = scene.position(self.points[0]) - scene.position(self.points[1])
        return [self.stiffness, self.damping, np.sqrt(d @ d) if self.length is None else self.length]


class TurnSpring(BetweenBodies, Acting):
    """Base of spring-dampers between the rotations of two bodies.

    Attributes
    ----------
    stiffness
        k, in torque/rad.
    damping
        c, in torque time/rad.
    rest_angle
        Relative rotation without torque, in rad.
    """

    kind: ClassVar[str] = "rotational-spring-damper"

    stiffness: Annotated[NotNegative, Quantity("torque/angle")] = 0.0
    damping: Annotated[NotNegative, Quantity("torque time/angle")] = 0.0
    rest_angle: Annotated[Number, Quantity("angle")] = 0.0

    def parameters(self, _scene: Skeleton) -> list[Scalar]:
        """Parameters of the law: stiffness, damping, relaxed angle."""
        return [self.stiffness, self.damping, self.rest_angle]


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
    __doc__ = PointSpring.__doc__

    formula = spring_damper


class RotationalSpringDamper(TurnSpring, PlanarLoad):
    """Torque -k (angle - rest_angle) - c angle' between two bodies, angle = relative rotation since the undeformed configuration."""

    formula = rotational_spring_damper


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
    __doc__ = PointSpring.__doc__

    formula = spatial_spring_damper

    @property
    def feels_axes(self) -> bool:
        """Whether the load feels axes of markers: no, only their positions."""
        return False


@kernel
def spatial_rotational_spring_damper(z, w, force, force_z, force_w):
    """u = - k (g - g_0) - c g' along the rotation g about the third axis, (k, c, g_0) = parameters; see `along`.

    Without a state of its own, w[24] is zero and g the angle nearest to zero.
    """
    g = counted_turns(24, space_angle(z, force, force_z), w, force, force_z, force_w)
    spring_along(24, g, z, w, force, force_z, force_w)


class SpatialRotationalSpringDamper(AboutAxis, TurnSpring, SpatialLoad):
    """Torque -k (angle - rest_angle) - c angle' about an axis between two bodies, angle since the undeformed configuration.

    Both bodies turn against each other about this axis alone: a revolute or cylindrical joint with the same axis has to stand beside it.

    Attributes
    ----------
    counts_turns
        Whether the angle has any number of turns, as that of a clock spring. They are counted by a coordinate of the spring's own, from
        those of the start position, in (-pi, pi], on. Otherwise the angle is one of (-pi, pi], and what turns beyond is refused, but for a
        damper without `stiffness`, which feels no angle.
    """

    formula = spatial_rotational_spring_damper

    counts_turns: bool = False

    @property
    def turn(self) -> Literal["zero", "state"] | None:
        """Reference of the turn of the angle: the counted turns, or zero; None for a damper alone, which feels no angle."""
        if "stiffness" not in self.model_fields_set:
            return None
        return "state" if self.counts_turns else "zero"

    @property
    def state(self) -> RowQuantity | None:
        """Quantity of the spring's own state: the angle that tells which turn it is; None where turns are not counted."""
        return "angle" if self.counts_turns else None
