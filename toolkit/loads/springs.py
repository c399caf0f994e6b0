"""Base of spring-dampers in the plane and in space: their numbers, and where they grip."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from toolkit.description.description import NotNegative, Number
from toolkit.description.quantity import Quantity
from toolkit.loads.acting import Acting
from toolkit.loads.places import BetweenBodies, BetweenPoints
from toolkit.markers.component import Skeleton


class PointSpring(BetweenPoints, Acting):
    """Base of springs along the line between two points; without `length` the spring is relaxed at the start.

    Attributes
    ----------
    stiffness
        k, in force/length.
    damping
        c, in force time/length.
    length
        Relaxed length; by default the distance of the points in the undeformed configuration.
    """

    stiffness: Annotated[NotNegative, Quantity("force/length")] = 0.0
    damping: Annotated[NotNegative, Quantity("force time/length")] = 0.0
    length: Annotated[NotNegative | None, Quantity("length")] = None

    def parameters(self, scene: Skeleton) -> list[Any]:
        """Parameters of the law: stiffness, damping, relaxed length."""
        d = scene.position(self.points[0]) - scene.position(self.points[1])
        return [self.stiffness, self.damping, np.sqrt(d @ d) if self.length is None else self.length]


class TurnSpring(BetweenBodies, Acting):
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

    stiffness: Annotated[NotNegative, Quantity("torque/angle")] = 0.0
    damping: Annotated[NotNegative, Quantity("torque time/angle")] = 0.0
    rest_angle: Annotated[Number, Quantity("angle")] = 0.0

    def parameters(self, _scene: Skeleton) -> list[Any]:
        """Parameters of the law: stiffness, damping, relaxed angle."""
        return [self.stiffness, self.damping, self.rest_angle]
