"""Revolute joint in space: a hinge."""

from __future__ import annotations

from toolkit.component import Skeleton
from toolkit.joints.spatial.forms import ALIGNED, TOGETHER, Row
from toolkit.joints.spatial.joint import AxisJoint


class SpatialRevolute(AxisJoint):
    """r_a = r_b and e_3a || e_3b: the bodies turn against each other about the axis alone."""

    kind = "revolute"

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        """Three directions and two rotations."""
        return (*TOGETHER, *ALIGNED)
