"""Points at which joints in the plane and in space grip their bodies."""

from __future__ import annotations

from typing import Annotated, Any, Self

import numpy as np
from pydantic import model_validator

from toolkit.description.description import Description, Positive
from toolkit.description.quantity import Quantity
from toolkit.markers.component import Place, Skeleton, on_both


class AtPoint(Description):
    """Base of joints at one point, which belongs to both bodies in the undeformed configuration; or at one point of each.

    Attributes
    ----------
    point
        Name of the point, or of the point on body a and that on body b.
    """

    bodies: tuple[str, str]
    point: Place

    @property
    def grips(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Bodies of the joint, each with the point where it is gripped."""
        first, second = on_both(self.point)
        return (self.bodies[0], first), (self.bodies[1], second)


class AtPoints(Description):
    """Base of joints that grip each body at a point of its own.

    Attributes
    ----------
    points
        Names of the point on body a and that on body b.
    """

    bodies: tuple[str, str]
    points: tuple[str, str]

    @property
    def grips(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Bodies of the joint, each with its own point."""
        return (self.bodies[0], self.points[0]), (self.bodies[1], self.points[1])

    def circles(self, _scene: Skeleton) -> list[tuple[int, float]]:
        """Circles of what rolls, for pictures: (number of the point, radius)."""
        return []

    def apart(self, scene: Skeleton) -> np.ndarray:
        """Vector from point b to point a in the undeformed configuration."""
        return scene.position(self.points[0]) - scene.position(self.points[1])


class BetweenPoints(AtPoints):
    """Base of joints that keep two points apart.

    Attributes
    ----------
    length
        L, in units of length; without it the distance in the undeformed configuration, which follows when a point moves.
    """

    length: Annotated[Positive | None, Quantity("length")] = None

    @model_validator(mode="after")
    def _two_points(self) -> Self:
        if self.points[0] == self.points[1]:
            raise ValueError(
                "a distance joint needs two different points; use a revolute (in space a spherical) joint to unite them"
            )
        return self

    def own_length(self, scene: Skeleton) -> Any:
        """Length that the joint keeps."""
        d = self.apart(scene)
        return np.sqrt(d @ d) if self.length is None else self.length
