"""Distance joint: a massless rod between two points, in the plane and in space."""

from __future__ import annotations

import numpy as np

from toolkit.components.joints.joint import Joint, JointBetweenPoints, PlanarJoint, SpatialJoint
from toolkit.components.joints.rows import Row
from toolkit.components.markers.component import Skeleton


class KeptDistance(JointBetweenPoints, Joint):
    """(d . d / L - L) / 2 = 0, d from point b to point a: the two points keep their distance L.

    Without `length` it is the distance in the undeformed configuration and follows when a point moves.
    """

    def constraint(self, scene: Skeleton | None) -> tuple[Row, ...]:
        """Row that keeps the distance of the two points."""
        return (self.poses.apart(1.0 if scene is None else self.own_length(scene)),)

    def opening(self, scene: Skeleton, _row: int, violation: float) -> float:
        """Length by which the two points are further apart than L."""
        length = float(np.real(self.own_length(scene)))
        return length * (np.sqrt(max(1 + 2 * violation / length, 0.0)) - 1)


class Distance(KeptDistance, PlanarJoint):
    __doc__ = KeptDistance.__doc__

    kind = "distance"


class SpatialDistance(KeptDistance, SpatialJoint):
    __doc__ = KeptDistance.__doc__

    kind = "distance"
    symbol = ""
