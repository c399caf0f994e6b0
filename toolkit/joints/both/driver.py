"""Drivers: the relative angle, or the position along an axis, follows a time curve, in the plane and in space."""

from __future__ import annotations

from typing import Annotated

from toolkit.curves.curve import Curve
from toolkit.description.quantity import Quantity
from toolkit.joints.driven import Driven
from toolkit.joints.joint import Joint
from toolkit.joints.planar.along_axis import AlongAxis
from toolkit.joints.planar.joint import PointJoint
from toolkit.joints.rows import Row
from toolkit.joints.spatial.joint import AxisJoint
from toolkit.markers.component import Skeleton


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


class PositionDriver(DrivenPosition, AlongAxis):
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
