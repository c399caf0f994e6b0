"""Cylindrical joint: a slide that also turns."""

from __future__ import annotations

from toolkit.components.joints.joint import AxisJoint
from toolkit.components.joints.rows import Row
from toolkit.components.markers.component import Skeleton


class Cylindrical(AxisJoint):
    """The point of body a slides along the axis fixed in body b, and turns about it."""

    kind = "cylindrical"
    symbol = "sleeve"

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        """Rows of two normal directions and two rotations."""
        return (*self.poses.on_line, *self.poses.aligned)
