"""Revolute joint in space: a hinge."""

from __future__ import annotations

from toolkit.joints.kernels.spatial.forms import ALIGNED, TOGETHER, Row
from toolkit.joints.spatial.joint import AxisJoint
from toolkit.markers.component import Skeleton


class SpatialRevolute(AxisJoint):
    """r_a = r_b and e_3a || e_3b: the bodies turn against each other about the axis alone."""

    kind = "revolute"
    symbol = "hinge"

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        """Three directions and two rotations."""
        return (*TOGETHER, *ALIGNED)
