"""Revolute joint in space: a hinge."""

from __future__ import annotations

from toolkit.joints.rows import Row
from toolkit.joints.spatial.joint import AxisJoint
from toolkit.markers.component import Skeleton


class SpatialRevolute(AxisJoint):
    """r_a = r_b and e_3a || e_3b: the bodies turn against each other about the axis alone."""

    kind = "revolute"
    symbol = "hinge"

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        """Rows of three directions and two rotations."""
        return (*self.poses.together, *self.poses.aligned)
