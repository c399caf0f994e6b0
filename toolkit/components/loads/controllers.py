"""Controllers of a relative angle, of a position along an axis, of a distance."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from toolkit.components.curves.curve import Curve
from toolkit.components.joints.rows import RowQuantity
from toolkit.components.loads.kernels.along import control_along
from toolkit.components.loads.kernels.load_kernel import SPATIAL_CURVE
from toolkit.components.loads.kernels.measured import (
    AXIS_ANGLE,
    distance,
    plane_angle,
    plane_offset,
    space_angle,
    space_offset,
    turn_next_to,
)
from toolkit.components.loads.load import Acting, AlongAxisLoad, BetweenBodies, BetweenPoints, PlanarLoad, SpatialLoad
from toolkit.components.markers.component import AboutAxis, Skeleton
from toolkit.description.description import NotNegative, Positive, Quantity, Scalar
from toolkit.foundation.kernel import kernel


class Controlled(Acting):
    """Base of loads u = k_p (s - g) + k_i x - k_d g' along what they measure, g, which is to follow the curve s(t); x' = s - g, x(0) = 0.

    The derivative action is that on the measured value, so that a set value that jumps gives no impulse; without an integral action what
    follows a moving set value lags behind it by k_d s' / k_p. The integral x is a state of the motion. In an equilibrium it is what makes
    s - g zero, and a start there keeps it.
    """

    leads: ClassVar[bool] = True
    acts_by: ClassVar[tuple[str, ...]] = ("proportional_gain", "derivative_gain", "integral_gain")
    measured: ClassVar[RowQuantity] = "length"
    """Quantity of g."""

    proportional_gain: Annotated[NotNegative, Quantity("force/length")] = 0.0
    derivative_gain: Annotated[NotNegative, Quantity("force time/length")] = 0.0
    integral_gain: Annotated[Positive | None, Quantity("force/length time")] = None
    curve: Annotated[Curve, Quantity("length")]

    @property
    def time_curve(self) -> Curve:
        """Time curve of the set value."""
        return self.curve

    @property
    def state(self) -> RowQuantity | None:
        """Quantity of the controller's integral, that of what it measures; None without integral action."""
        return None if self.integral_gain is None else self.measured

    def parameters(self, _scene: Skeleton) -> list[Scalar]:
        """Gains of the controller: proportional, derivative, integral."""
        return [self.proportional_gain, self.derivative_gain, 0.0 if self.integral_gain is None else self.integral_gain]


class AngleControlled(BetweenBodies, Controlled):
    """Base of controllers of the rotation of body a against body b: a torque on both.

    Attributes
    ----------
    proportional_gain
        k_p, in torque/rad.
    derivative_gain
        k_d, in torque time/rad; on the measured rate, so that a set value that jumps gives no impulse.
    integral_gain
        k_i, in torque/(rad time); without it there is no integral.
    curve
        Set value of the relative rotation over time, in rad.
    """

    kind: ClassVar[str] = "angle-controller"
    measured: ClassVar[RowQuantity] = "angle"

    proportional_gain: Annotated[NotNegative, Quantity("torque/angle")] = 0.0
    derivative_gain: Annotated[NotNegative, Quantity("torque time/angle")] = 0.0
    integral_gain: Annotated[Positive | None, Quantity("torque/angle time")] = None
    curve: Annotated[Curve, Quantity("angle")]


class LengthControlled(Controlled):
    """Base of controllers of a length: a force.

    Attributes
    ----------
    proportional_gain
        k_p, in force/length.
    derivative_gain
        k_d, in force time/length; on the measured rate, so that a set value that jumps gives no impulse.
    integral_gain
        k_i, in force/(length time); without it there is no integral.
    curve
        Set value over time, in units of length.
    """


class PositionControlled(BetweenBodies, LengthControlled):
    """Force k_p (s - g) + k_i x - k_d g', x' = s - g, along an axis fixed in body b: a linear motor.

    The point of body a stands at g on the axis, and is led to s(t); there the force acts, its reaction on body b.
    """

    kind: ClassVar[str] = "position-controller"


class DistanceControlled(BetweenPoints, LengthControlled):
    """Force k_p (s - l) + k_i x - k_d l', x' = s - l, along the line between two points: a cylinder.

    It is led to the length s(t); a positive force drives the points apart.
    """

    kind: ClassVar[str] = "distance-controller"


@kernel
def angle_controller(z, w, force, force_z, force_w):
    """u = k_p (s - g) + k_i x - k_d g' along g = angle_a - angle_b, see `along`."""
    control_along(6, plane_angle(z, force, force_z), z, w, force, force_z, force_w)


@kernel
def position_controller(z, w, force, force_z, force_w):
    """u = k_p (s - g) + k_i x - k_d g' along g = e . (r_a - r_b); the angle of the axis e acts like that of body b."""
    control_along(6, plane_offset(z, force, force_z), z, w, force, force_z, force_w)
    for i in range(7):
        force_z[i, AXIS_ANGLE] = force_z[i, 5]


@kernel
def distance_controller(z, w, force, force_z, force_w):
    """u = k_p (s - g) + k_i x - k_d g' along g = |r_a - r_b|."""
    control_along(6, distance(z, 3, force, force_z), z, w, force, force_z, force_w)


class AngleController(AngleControlled, PlanarLoad):
    """Torque k_p (s - angle) + k_i x - k_d angle', x' = s - angle, on body a, its opposite on body b: a motor.

    The angle is the relative rotation since the undeformed configuration, with all turns; it is led to s(t).
    """

    formula = angle_controller


class PositionController(PositionControlled, AlongAxisLoad):
    __doc__ = PositionControlled.__doc__

    formula = position_controller

    def parameters(self, scene: Skeleton) -> list[Scalar]:
        """Gains of the controller, and the angle of the axis."""
        return self.with_axis(PositionControlled.parameters(self, scene))


class DistanceController(DistanceControlled, PlanarLoad):
    __doc__ = DistanceControlled.__doc__

    formula = distance_controller


@kernel
def spatial_angle_controller(z, w, force, force_z, force_w):
    """u = k_p (s - g) + k_i x - k_d g' along the rotation g about the third axis, in the turn next to s, see `along`."""
    g = turn_next_to(z[SPATIAL_CURVE], space_angle(z, force, force_z))
    control_along(24, g, z, w, force, force_z, force_w)


@kernel
def spatial_position_controller(z, w, force, force_z, force_w):
    """u = k_p (s - g) + k_i x - k_d g' along g = e_3b . (r_a - r_b)."""
    control_along(24, space_offset(z, force, force_z), z, w, force, force_z, force_w)


@kernel
def spatial_distance_controller(z, w, force, force_z, force_w):
    """u = k_p (s - g) + k_i x - k_d g' along g = |r_a - r_b|."""
    control_along(24, distance(z, 12, force, force_z), z, w, force, force_z, force_w)


class SpatialAngleController(AboutAxis, AngleControlled, SpatialLoad):
    """Torque k_p (s - angle) + k_i x - k_d angle', x' = s - angle, about an axis on body a, its opposite on body b.

    A motor that leads the angle since the undeformed configuration to s(t), of any number of turns. An axis in space does not say how often
    a body has turned: the angle is taken in the turn next to s(t), and a motion that stays behind by more than half a turn is refused.
    Both bodies turn against each other about this axis alone: a revolute or cylindrical joint with the same axis has to stand beside it.
    """

    formula = spatial_angle_controller

    @property
    def turn(self) -> Literal["curve"]:
        """Reference of the turn of the angle: the curve of the set value."""
        return "curve"


class SpatialPositionController(AboutAxis, PositionControlled, SpatialLoad):
    __doc__ = PositionControlled.__doc__

    formula = spatial_position_controller


class SpatialDistanceController(DistanceControlled, SpatialLoad):
    __doc__ = DistanceControlled.__doc__

    formula = spatial_distance_controller

    @property
    def feels_axes(self) -> bool:
        """Whether the load feels axes of markers: no, only their positions."""
        return False
