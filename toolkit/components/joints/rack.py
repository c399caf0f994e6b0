"""Rack: a wheel that rolls along a straight line of another body, in the plane and in space."""

from __future__ import annotations

from typing import Annotated, Self

import numpy as np
from pydantic import model_validator

from toolkit.components.joints.joint import AtPoints, Directed, Joint, SpatialJoint
from toolkit.components.joints.kernels.laws import turn_law
from toolkit.components.joints.rows import Row
from toolkit.components.joints.universal import LARGEST_COSINE
from toolkit.components.markers.component import AboutAxis, Skeleton
from toolkit.description.description import Positive, Quantity, Scalar, Triple
from toolkit.foundation.errors import InputError


class OnRack(AtPoints, Joint):
    """Base of wheels, body a, on a straight line of body b.

    Attributes
    ----------
    points
        Names of the centre of the wheel and of a point of the line, on the side where the line is.
    radius
        R of the wheel; by default the distance of its centre from the line through the second point, which follows when a point moves. One
        that is given counts alone: the line of a rack may run anywhere beside the wheel.
    """

    radius: Annotated[Positive | None, Quantity("length")] = None

    def rolled(self, scene: Skeleton | None, axes: np.ndarray) -> tuple[Scalar, Scalar]:
        """Offset of the centre along the line in the undeformed configuration, and R with the sign of the side where the centre is."""
        if scene is None:
            return 0.0, 1.0
        along, aside = self.apart(scene) @ axes[:, :2]
        side = np.sign(np.real(aside))
        if side == 0:
            raise InputError(
                f"point {self.points[0]!r}, the centre of a wheel, is on the line through {self.points[1]!r} that it is to roll along. "
                "Let the second point be one of the line that touches the wheel."
            )
        return along, aside if self.radius is None else side * self.radius


class Rack(OnRack, Directed):
    """s + R (angle_a - angle_b) = 0: pinion a rolls without slip along a line of rack b, by s from where it was.

    R is negative for a pinion on the right of the axis, seen along it.

    What keeps the pinion on the rack stands beside it: both on guides, or a slider with its rotation free.

    Attributes
    ----------
    axis
        Direction of the rack in the undeformed configuration, of any length; it is fixed in body b.
    """

    kind = "rack"

    def constraint(self, scene: Skeleton | None) -> tuple[Row, ...]:
        """Row that couples the offset along the rack with the rotation of the pinion."""
        (a, b), (start, radius) = self.poses, self._rolled(scene)
        return (Row("rolling", "length", self.poses.on_axis(1, "rolling", start).forms[0] + (a.angle - b.angle) * radius),)

    def circles(self, scene: Skeleton) -> list[tuple[int, float]]:
        """Circle of the pinion, for pictures."""
        return [(0, float(abs(np.real(self._rolled(scene)[1]))))]

    def _rolled(self, scene: Skeleton | None) -> tuple[Scalar, Scalar]:
        x, y = np.array(self.axis) / np.sqrt(np.array(self.axis) @ np.array(self.axis))
        return self.rolled(scene, np.array([[x, -y], [y, x]]))


class RollingDisc(Rack):
    """A disc rolls without slip on a straight line of body b and stays on it: that of a rack, and n . (r_a - r_b) - R = 0.

    It stays on the line even where it would have to be pulled. In space take a rack, and a point on a plane beside it.
    """

    kind = "rolling-disc"

    def constraint(self, scene: Skeleton | None) -> tuple[Row, ...]:
        """Rows of the contact in the normal direction, and of the rolling along the line."""
        return (self.poses.on_axis(2, "contact", self._rolled(scene)[1]), *super().constraint(scene))


class SpatialRack(AboutAxis, OnRack, SpatialJoint):
    """s + R angle = 0: pinion a rolls without slip along a line of rack b, by s from where it was, of any number of turns.

    Both bodies turn against each other about the axis of the pinion alone; what sees to that, and keeps the pinion on the rack, stands
    beside it.

    Attributes
    ----------
    axis
        Direction of the axis of the pinion in the undeformed configuration, of any length.
    along
        Direction of the rack, perpendicular to the axis; it is fixed in body b.
    """

    kind = "rack"
    symbol = ""

    along: Annotated[Triple, Quantity("none")]

    @model_validator(mode="after")
    def _crossed(self) -> Self:
        axis, along = np.array(self.axis), np.array(self.along)
        if not any(along) or abs(axis @ along) > LARGEST_COSINE * np.sqrt((axis @ axis) * (along @ along)):
            raise ValueError("a rack runs perpendicular to the axis of its pinion: give `along` such a direction")
        return self

    @property
    def axes(self) -> np.ndarray:
        """Axes of the markers, (3, 3) as columns: the first along the rack, the third along the axis of the pinion."""
        along, axis = np.array(self.along), np.array(self.axis)
        along, axis = along / np.sqrt(along @ along), axis / np.sqrt(axis @ axis)
        return np.column_stack([along, np.cross(axis, along), axis])

    def constraint(self, scene: Skeleton | None) -> tuple[Row, ...]:
        """Row that couples the offset along the rack with the rotation of the pinion."""
        (a, b), (start, radius) = self.poses, self.rolled(scene, self.axes)
        offset = self.poses.on_axis(1, "rolling", start).forms[0]
        return (Row("rolling", "length", (offset, a.e(1) @ b.e(1), a.e(1) @ b.e(2), -radius), turn_law),)

    def circles(self, scene: Skeleton) -> list[tuple[int, float]]:
        """Circle of the pinion, for pictures."""
        return [(0, float(abs(np.real(self.rolled(scene, self.axes)[1]))))]
