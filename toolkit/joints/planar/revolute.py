"""Revolute joint: two points coincide."""

from __future__ import annotations

from typing import Any

from toolkit.foundation.kernel import kernel
from toolkit.joints.joint import RowQuantity
from toolkit.joints.planar.joint import PointJoint
from toolkit.markers.component import Skeleton


@kernel
def revolute(z, w, phi, phi_z, phi_zz, phi_zww):
    """phi = r_a - r_b."""
    for i in range(2):
        phi[i] = z[i] - z[3 + i]
        phi_z[i, i], phi_z[i, 3 + i] = 1, -1


class Revolute(PointJoint):
    """phi = r_a - r_b: the point of both bodies stays common, rotation is free."""

    kind = "revolute"
    formula = revolute
    curved = False

    @property
    def rows(self) -> list[tuple[str, RowQuantity]]:
        """Two directions."""
        return [("x", "length"), ("y", "length")]

    def parameters(self, _scene: Skeleton) -> list[Any]:
        """None."""
        return []
