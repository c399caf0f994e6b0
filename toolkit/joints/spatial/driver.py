"""Drivers in space: the relative angle about an axis, or the position along it, follows a time curve."""

from __future__ import annotations

from typing import Annotated

from toolkit.curves.curve import Curve
from toolkit.description.quantity import Quantity
from toolkit.joints.driven import Driven
from toolkit.joints.kernels.spatial.forms import TURNED, Row, on_axis
from toolkit.joints.spatial.joint import AxisJoint
from toolkit.markers.component import Skeleton


class SpatialAngleDriver(Driven, AxisJoint):
    """Rotation of body a against body b about the axis - f(t) = 0. Both bodies turn against each other about this axis alone: a revolute or
    cylindrical joint with the same axis has to stand beside it.

    Attributes
    ----------
    curve
        Relative rotation over time, in rad, of any number of turns; smooth, and zero at the start.
    """

    kind = "angle-driver"
    symbol = ""

    curve: Annotated[Curve, Quantity("angle")]

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        """The rotation."""
        return (TURNED,)


class SpatialPositionDriver(Driven, AxisJoint):
    """e_3b . (r_a - r_b) - f(t) = 0: the offset along the axis fixed in body b follows the curve.

    Attributes
    ----------
    curve
        Offset along the axis over time, in units of length; smooth, and equal to the given offset at the start.
    """

    kind = "position-driver"
    symbol = ""

    curve: Annotated[Curve, Quantity("length")]

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        """The axis."""
        return (on_axis(3, "axis"),)
