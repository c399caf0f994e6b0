"""Spherical joint: two points coincide."""

from __future__ import annotations

from toolkit.component import Skeleton
from toolkit.joints.spatial.forms import TOGETHER, Row
from toolkit.joints.spatial.joint import SpatialPointJoint


class Spherical(SpatialPointJoint):
    """r_a = r_b: the point of both bodies stays common, every rotation is free."""

    kind = "spherical"

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        """Three directions."""
        return TOGETHER
