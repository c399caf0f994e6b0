"""Rigid joint: two points coincide and the relative rotation is locked."""

from __future__ import annotations

from typing import Any

from toolkit.foundation.kernel import kernel
from toolkit.joints.joint import RowQuantity
from toolkit.joints.planar.joint import PointJoint
from toolkit.joints.planar.revolute import revolute
from toolkit.markers.component import Skeleton


@kernel
def rigid(z, w, phi, phi_z, phi_zz, phi_zww):
    """phi = [r_a - r_b, angle_a - angle_b]."""
    revolute(z, w, phi, phi_z, phi_zz, phi_zww)
    phi[2] = z[2] - z[5]
    phi_z[2, 2], phi_z[2, 5] = 1, -1


class RigidJoint(PointJoint):
    """phi = [r_a - r_b, angle_a - angle_b]: both bodies move as one at the point."""

    kind = "rigid"
    formula = rigid
    curved = False

    @property
    def rows(self) -> list[tuple[str, RowQuantity]]:
        """Two directions and the rotation."""
        return [("x", "length"), ("y", "length"), ("rotation", "angle")]

    def parameters(self, _scene: Skeleton) -> list[Any]:
        """None."""
        return []
