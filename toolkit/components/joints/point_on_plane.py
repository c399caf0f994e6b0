"""Point on plane."""

from __future__ import annotations

from toolkit.components.joints.joint import AxisJoint
from toolkit.components.joints.rows import Row
from toolkit.components.markers.component import Skeleton


class PointOnPlane(AxisJoint):
    """e_3b . (r_a - r_b) = 0: the point of body a stays in the plane through the point of body b, normal to the axis fixed in body b."""

    kind = "point-on-plane"
    symbol = "plane"

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        """Row of the normal direction of the plane."""
        return (self.poses.on_axis(3, "normal"),)
