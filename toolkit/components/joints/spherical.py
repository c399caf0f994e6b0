"""Spherical joint: two points coincide."""

from __future__ import annotations

from toolkit.components.joints.joint import SpatialPointJoint
from toolkit.components.joints.rows import Row
from toolkit.components.markers.component import Skeleton


class Spherical(SpatialPointJoint):
    """r_a = r_b: the point of both bodies stays common, every rotation is free."""

    kind = "spherical"

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        """Rows of three directions, in which the points coincide."""
        return self.poses.together
