"""Distance joint in space: a massless rod between two points."""

from __future__ import annotations

import numpy as np
from pydantic import model_validator

from toolkit.component import Skeleton
from toolkit.description import Positive
from toolkit.joints.spatial.forms import Row, apart
from toolkit.joints.spatial.joint import SpatialJoint


class SpatialDistance(SpatialJoint):
    """(d . d / L - L) / 2 = 0, d from point b to point a: the two points keep their distance L.

    Without `length` it is the distance in the undeformed configuration and follows when a point moves.

    Attributes
    ----------
    points
        Names of the point on body a and that on body b.
    length
        L, in units of length.
    """

    kind = "distance"

    points: tuple[str, str]
    length: Positive | None = None

    @model_validator(mode="after")
    def _two_points(self) -> SpatialDistance:
        if self.points[0] == self.points[1]:
            raise ValueError("a distance joint needs two different points; use a spherical joint to unite them")
        return self

    @property
    def grips(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Each body at its own point."""
        return (self.bodies[0], self.points[0]), (self.bodies[1], self.points[1])

    def constraint(self, scene: Skeleton | None) -> tuple[Row, ...]:
        """One direction."""
        if self.length is not None or scene is None:
            return (apart(self.length or 1.0),)
        d = scene.position(self.points[0]) - scene.position(self.points[1])
        return (apart(np.sqrt(d @ d)),)
