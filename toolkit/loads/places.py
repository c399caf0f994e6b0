"""Points at which loads between two bodies grip: one for both, or one for each."""

from __future__ import annotations

from typing import Self

from pydantic import model_validator

from toolkit.description.description import Description, Registered
from toolkit.joints.joint import AtPoint


def name_of(load: Description) -> str:
    """Kind of a load with its article, for messages."""
    kind = load.kind if isinstance(load, Registered) else "load"
    return f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"


class BetweenBodies(AtPoint):
    """Base of loads between two bodies at a point that both share, or at a point of each.

    Attributes
    ----------
    bodies
        Names of bodies a and b.
    point
        Name of the point, or of the point on body a and that on body b.
    """

    @model_validator(mode="after")
    def _two_bodies(self) -> Self:
        if self.bodies[0] == self.bodies[1]:
            raise ValueError(f"{name_of(self)} acts between two different bodies, not on {self.bodies[0]!r} alone")
        return self


class BetweenPoints(Description):
    """Base of loads along the line between two points.

    Attributes
    ----------
    bodies
        Names of bodies a and b.
    points
        Names of the point on body a and that on body b.
    """

    bodies: tuple[str, str]
    points: tuple[str, str]

    @model_validator(mode="after")
    def _two_points(self) -> Self:
        if self.points[0] == self.points[1]:
            raise ValueError(f"{name_of(self)} needs two different points, otherwise it has no direction")
        if self.bodies == ("ground", "ground"):
            raise ValueError(f"{name_of(self)} between two points of the ground has no effect; name a body that moves")
        return self

    @property
    def grips(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Bodies of the load, each with its own point."""
        return (self.bodies[0], self.points[0]), (self.bodies[1], self.points[1])
