"""Distance joint in space: a massless rod between two points."""

from __future__ import annotations

from toolkit.joints.kernels.spatial.forms import Row, apart
from toolkit.joints.places import BetweenPoints
from toolkit.joints.spatial.joint import SpatialJoint
from toolkit.markers.component import Skeleton


class SpatialDistance(BetweenPoints, SpatialJoint):
    """(d . d / L - L) / 2 = 0, d from point b to point a: the two points keep their distance L.

    Without `length` it is the distance in the undeformed configuration and follows when a point moves.
    """

    kind = "distance"
    symbol = ""

    def constraint(self, scene: Skeleton | None) -> tuple[Row, ...]:
        """One direction."""
        return (apart(1.0 if scene is None else self.own_length(scene)),)
