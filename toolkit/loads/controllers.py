"""Base of controllers in the plane and in space: a set value over time, and their gains."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from toolkit.curves.curve import Curve
from toolkit.description.description import NotNegative, Positive
from toolkit.description.quantity import Quantity
from toolkit.joints.rows import RowQuantity
from toolkit.loads.acting import Acting
from toolkit.loads.places import BetweenBodies, BetweenPoints
from toolkit.markers.component import Skeleton


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

    def parameters(self, _scene: Skeleton) -> list[Any]:
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
    """Base of controllers of the offset of the point of body a along an axis fixed in body b."""


class DistanceControlled(BetweenPoints, LengthControlled):
    """Base of controllers of the distance between two points."""
