"""Rigid joint in space: two points coincide and no relative rotation is left."""

from __future__ import annotations

from toolkit.joints.kernels.spatial.forms import LOCKED, TOGETHER, Row
from toolkit.joints.spatial.joint import SpatialPointJoint
from toolkit.markers.component import Skeleton


class SpatialRigidJoint(SpatialPointJoint):
    """r_a = r_b, and the axes of both markers stay parallel: both bodies move as one at the point."""

    kind = "rigid"
    symbol = "weld"

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        """Three directions and three rotations."""
        return (*TOGETHER, *LOCKED)
