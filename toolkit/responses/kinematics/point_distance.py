"""Distance of two points of two bodies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

import numpy as np
from pydantic import model_validator

from toolkit.responses.kinematics.marker_formula import MarkerVector
from toolkit.responses.kinematics.marker_motion import Motion
from toolkit.responses.kinematics.point_motion import dimension_of


class PointDistance(MarkerVector):
    """Distance of two points of two bodies: its length, or a component of the way from the first to the second in global axes.

    Attributes
    ----------
    bodies
        Both bodies; one may be the ground.
    points
        The point on the first and that on the second.
    """

    kind = "distance"
    quantity = "length"

    bodies: tuple[str, str]
    points: tuple[str, str]

    @model_validator(mode="after")
    def _two_places(self) -> Self:
        first, second = self.points
        if self.bodies[0] == self.bodies[1] and first == second:
            raise ValueError(
                f"point {first!r} of {self.bodies[0]!r} has no distance from itself; name two bodies, or two points of one"
            )
        return self

    def markers(self) -> tuple[tuple[str, str], ...]:
        """Pairs of body and point: each point on its body."""
        return tuple(zip(self.bodies, self.points, strict=True))

    def formula(self, *motions: Motion) -> tuple[np.ndarray, Sequence[Motion]]:
        """Vector r_b - r_a from the first point to the second, and its derivatives by both motions."""
        a, b = (motion.y for motion in motions)
        d = dimension_of(a)
        side = np.eye(d, len(a))
        return b[:d] - a[:d], [Motion(y=-side), Motion(y=side)]
