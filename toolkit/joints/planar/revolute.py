"""Revolute joint: two points coincide."""

from __future__ import annotations

from toolkit.joints.planar.joint import PointJoint
from toolkit.joints.rows import Row
from toolkit.markers.component import Skeleton


class Revolute(PointJoint):
    """r_a = r_b: the point of both bodies stays common, rotation is free."""

    kind = "revolute"

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        """Rows of two directions, in which the points coincide."""
        return self.poses.together
