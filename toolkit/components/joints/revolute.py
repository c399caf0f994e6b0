"""Revolute joint, a hinge: in the plane two points coincide, in space two axes too.

Its rows are stated here; a step evaluates them in `kernels.planar_pin` (in the plane) and in `kernels.spatial_joint`.
"""

from __future__ import annotations

from toolkit.components.joints.joint import AxisJoint, PointJoint
from toolkit.components.joints.rows import Row
from toolkit.components.markers.component import Skeleton


class Revolute(PointJoint):
    """r_a = r_b: the point of both bodies stays common, rotation is free."""

    kind = "revolute"

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        """Rows of two directions, in which the points coincide."""
        return self.poses.together


class SpatialRevolute(AxisJoint):
    """r_a = r_b and e_3a || e_3b: the bodies turn against each other about the axis alone."""

    kind = "revolute"
    symbol = "hinge"

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        """Rows of three directions and two rotations."""
        return (*self.poses.together, *self.poses.aligned)
