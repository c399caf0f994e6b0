"""Drivers: the relative angle, or the position along an axis, follows a time curve, in the plane and in space."""

from __future__ import annotations

from typing import Annotated

from pydantic import field_validator

from toolkit.components.curves.catalogue import Curve
from toolkit.components.joints.joint import AxisJoint, DirectedAtPoint, Joint, PointJoint
from toolkit.components.joints.rows import Row
from toolkit.components.markers.component import Skeleton
from toolkit.description.description import Description, Quantity


def smooth(curve: Curve) -> Curve:
    """Refuse a curve without second derivative: the acceleration of what it drives would not exist."""
    if why := curve.kink():
        raise ValueError(f"a driver needs a curve with a second derivative; {why}")
    return curve


class Driven(Description):
    """Base of drivers: a joint coordinate follows a curve; each kind says what the curve's values measure.

    Attributes
    ----------
    curve
        The joint coordinate over time.
    """

    curve: Curve
    _smooth = field_validator("curve")(smooth)

    @property
    def time_curve(self) -> Curve:
        """Time curve that the joint coordinate follows."""
        return self.curve


class DrivenAngle(Driven, Joint):
    """Rotation of body a against body b - f(t) = 0."""

    curve: Annotated[Curve, Quantity("angle")]

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        """Row of the relative rotation, which follows the curve."""
        return (self.poses.turned,)


class DrivenPosition(Driven, Joint):
    """Offset of the point of body a along an axis fixed in body b - f(t) = 0."""

    curve: Annotated[Curve, Quantity("length")]

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        """Row of the offset along the axis, which follows the curve."""
        return (self.poses.on_axis(self.poses.along, "axis"),)


class AngleDriver(DrivenAngle, PointJoint):
    """angle_a - angle_b - f(t) = 0: the relative rotation since the undeformed configuration follows the curve.

    Attributes
    ----------
    curve
        Relative rotation over time, in rad; smooth, and zero at the start.
    """

    kind = "angle-driver"


class SpatialAngleDriver(DrivenAngle, AxisJoint):
    """Rotation of body a against body b about the axis - f(t) = 0. Both bodies turn against each other about this axis alone: a revolute or
    cylindrical joint with the same axis has to stand beside it.

    Attributes
    ----------
    curve
        Relative rotation over time, in rad, of any number of turns; smooth, and zero at the start.
    """

    kind = "angle-driver"
    symbol = ""


class PositionDriver(DrivenPosition, DirectedAtPoint):
    """e . (r_a - r_b) - f(t) = 0: the offset along the axis e fixed in body b follows the curve.

    Attributes
    ----------
    curve
        Offset along the axis over time, in units of length; smooth, and equal to the given offset at the start.
    """

    kind = "position-driver"


class SpatialPositionDriver(DrivenPosition, AxisJoint):
    """e_3b . (r_a - r_b) - f(t) = 0: the offset along the axis fixed in body b follows the curve.

    Attributes
    ----------
    curve
        Offset along the axis over time, in units of length; smooth, and equal to the given offset at the start.
    """

    kind = "position-driver"
    symbol = ""
