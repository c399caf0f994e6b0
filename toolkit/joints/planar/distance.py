"""Distance joint: a massless rod between two points."""

from __future__ import annotations

from typing import Any

from toolkit.foundation.kernel import kernel
from toolkit.joints.joint import RowQuantity
from toolkit.joints.places import BetweenPoints
from toolkit.joints.planar.joint import PlanarJoint
from toolkit.markers.component import Skeleton


@kernel
def distance(z, w, phi, phi_z, phi_zz, phi_zww):
    """phi = (d . d / L - L) / 2 with d = r_a - r_b and L the first parameter; its multiplier is the rod's force."""
    length = z[6]
    d_x, d_y = z[0] - z[3], z[1] - z[4]
    square = d_x * d_x + d_y * d_y
    phi[0] = (square / length - length) / 2
    for i in range(2):
        d = d_x if i == 0 else d_y
        for side in range(2):
            sign, k = 1 - 2 * side, 3 * side + i
            phi_z[0, k] = sign * d / length
            phi_zz[0, k, k] = 1 / length
            phi_zz[0, k, 6] = phi_zz[0, 6, k] = -sign * d / (length * length)
        phi_zz[0, i, 3 + i] = phi_zz[0, 3 + i, i] = -1 / length
    phi_z[0, 6] = -(square / (length * length) + 1) / 2
    phi_zz[0, 6, 6] = square / (length * length * length)
    rate = (w[0] - w[3]) * (w[0] - w[3]) + (w[1] - w[4]) * (w[1] - w[4])
    phi_zww[0, 6] = -rate / (length * length)


class Distance(BetweenPoints, PlanarJoint):
    """phi = (d . d / L - L) / 2, d from point b to point a: the two points keep their distance L.

    Without `length` it is the distance in the undeformed configuration and follows when a point moves.
    """

    kind = "distance"
    formula = distance

    @property
    def rows(self) -> list[tuple[str, RowQuantity]]:
        """One direction."""
        return [("distance", "length")]

    def parameters(self, scene: Skeleton) -> list[Any]:
        """The length."""
        return [self.own_length(scene)]
