"""Prismatic joint: a slide without rotation."""

from __future__ import annotations

from toolkit.components.joints.joint import AxisJoint
from toolkit.components.joints.rows import Row
from toolkit.components.markers.component import Skeleton


class Prismatic(AxisJoint):
    """The point of body a slides along the axis fixed in body b, and no relative rotation is left."""

    kind = "prismatic"
    symbol = "slider"

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        """Rows of two normal directions and three rotations."""
        return (*self.poses.on_line, *self.poses.locked)
