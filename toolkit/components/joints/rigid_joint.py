"""Rigid joint: two points coincide and no relative rotation is left, in the plane and in space; and ties, which the scene does not show."""

from __future__ import annotations

from toolkit.components.joints.joint import AtPoint, Joint, PlanarJoint, SpatialJoint
from toolkit.components.joints.rows import Row
from toolkit.components.markers.component import Skeleton


class Welded(AtPoint, Joint):
    """r_a = r_b and no relative rotation: both bodies move as one at the point."""

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        """Rows of all directions and all rotations."""
        return (*self.poses.together, *self.poses.locked)


class RigidJoint(Welded, PlanarJoint):
    """r_a = r_b and angle_a = angle_b: both bodies move as one at the point."""

    kind = "rigid"


class SpatialRigidJoint(Welded, SpatialJoint):
    """r_a = r_b, and the axes of both markers stay parallel: both bodies move as one at the point."""

    kind = "rigid"
    symbol = "weld"


class Tie(Welded):
    """Base of rigid joints between two parts of a cut body, or between its clamp and the ground."""

    kind = ""


class PlanarTie(Tie, RigidJoint):
    """A rigid joint in the plane between two parts of a cut body, or between its clamp and the ground."""

    kind = ""


class SpatialTie(Tie, SpatialRigidJoint):
    """A rigid joint in space between two parts of a cut body, or between its clamp and the ground."""

    kind = ""
