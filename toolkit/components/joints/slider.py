"""Slider: a point of one body moves along a straight line fixed in the other, with or without its rotation locked."""

from __future__ import annotations

from toolkit.components.joints.joint import DirectedAtPoint
from toolkit.components.joints.rows import Row
from toolkit.components.markers.component import Skeleton


class Slider(DirectedAtPoint):
    """n . (r_a - r_b) = 0, n the normal of the axis: the point of body a slides along the axis fixed in body b.

    With `lock_rotation` also angle_a - angle_b = 0.

    Attributes
    ----------
    lock_rotation
        Whether the relative rotation is locked too.
    """

    kind = "slider"

    lock_rotation: bool = False

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        """Rows of the normal direction, and of the rotation if it is locked."""
        poses = self.poses
        return (*poses.on_line, *poses.locked) if self.lock_rotation else poses.on_line
