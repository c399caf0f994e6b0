"""What spring-dampers in the plane and in space share: their numbers, and where they grip."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import model_validator

from toolkit.description.description import Description, NotNegative, Number
from toolkit.description.quantity import Quantity
from toolkit.markers.component import Place, Skeleton, on_both


class PointSpring(Description):
    """Base of springs along the line between two points; without `length` the spring is relaxed at the start.

    Attributes
    ----------
    bodies
        Names of bodies a and b.
    points
        Names of the point on body a and that on body b.
    stiffness
        k, in force/length.
    damping
        c, in force time/length.
    length
        Relaxed length; by default the distance of the points in the undeformed configuration.
    """

    bodies: tuple[str, str]
    points: tuple[str, str]
    stiffness: Annotated[NotNegative, Quantity("force/length")] = 0.0
    damping: Annotated[NotNegative, Quantity("force time/length")] = 0.0
    length: Annotated[NotNegative | None, Quantity("length")] = None

    @model_validator(mode="after")
    def _two_points(self) -> Self:
        if self.points[0] == self.points[1]:
            raise ValueError("a spring needs two different points, otherwise it has no direction")
        if self.bodies == ("ground", "ground"):
            raise ValueError("a spring between two points of the ground has no effect; name a body that moves")
        return self

    @property
    def grips(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Each body at its own point."""
        return (self.bodies[0], self.points[0]), (self.bodies[1], self.points[1])

    def parameters(self, scene: Skeleton) -> list[Any]:
        """Stiffness, damping, relaxed length."""
        d = scene.position(self.points[0]) - scene.position(self.points[1])
        return [self.stiffness, self.damping, np.sqrt(d @ d) if self.length is None else self.length]


class BetweenBodies(Description):
    """Base of springs between the poses of two bodies.

    Attributes
    ----------
    bodies
        Names of bodies a and b.
    point
        Name of the point, or of the point on body a and that on body b.
    """

    called: ClassVar[str]
    """What messages call it."""

    bodies: tuple[str, str]
    point: Place

    @model_validator(mode="after")
    def _two_bodies(self) -> Self:
        if self.bodies[0] == self.bodies[1]:
            raise ValueError(f"a {self.called} ties two different bodies, not {self.bodies[0]!r} to itself")
        return self

    @property
    def grips(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Each body at the point."""
        first, second = on_both(self.point)
        return (self.bodies[0], first), (self.bodies[1], second)


class TurnSpring(BetweenBodies):
    """Base of springs between the rotations of two bodies.

    Attributes
    ----------
    stiffness
        k, in torque/rad.
    damping
        c, in torque time/rad.
    rest_angle
        Relative rotation without torque, in rad.
    """

    called = "rotational spring"
    folds: ClassVar[bool] = False
    """Whether its angle is known up to half a turn only, beyond which its torque would change sign."""

    stiffness: Annotated[NotNegative, Quantity("torque/angle")] = 0.0
    damping: Annotated[NotNegative, Quantity("torque time/angle")] = 0.0
    rest_angle: Annotated[Number, Quantity("angle")] = 0.0

    def parameters(self, _scene: Skeleton) -> list[Any]:
        """Stiffness, damping, relaxed angle."""
        return [self.stiffness, self.damping, self.rest_angle]
