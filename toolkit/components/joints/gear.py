"""Gear: two wheels that roll on each other, in the plane and in space."""

from __future__ import annotations

from math import gcd
from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from toolkit.components.joints.joint import AtPoints, Joint, PlanarJoint, SpatialJoint
from toolkit.components.joints.kernels.laws import teeth_law, turn_law
from toolkit.components.joints.rows import Row
from toolkit.components.markers.component import AboutAxis, Skeleton
from toolkit.description.description import Number, Pair, Quantity, Scalar
from toolkit.foundation.errors import InputError

RADIUS_TOLERANCE = 1e-3
"""Part of the distance of the centres by which radii may miss it: that is a rounded number, not another gear."""
Teeth = Annotated[int, Field(strict=True, ge=-100_000, le=100_000)]


class Wheels(AtPoints, Joint):
    """Base of gears, with two wheels.

    Attributes
    ----------
    points
        Names of the centre of wheel a and that of wheel b.
    teeth
        Whole numbers z_a, z_b of teeth. A wheel that the other turns in, a ring, has a negative one.
    """

    teeth: tuple[Teeth, Teeth] | None = None

    @model_validator(mode="after")
    def _wheels(self) -> Self:
        if self.teeth is not None and (0 in self.teeth or max(self.teeth) < 0):
            raise ValueError("a wheel has at least one tooth, and of two wheels one at most is a ring, with a negative number")
        return self


def rolling(distance: float, ratio: float) -> list[tuple[int, float]]:
    """Pitch circles of two wheels, (number of the point, radius); none of two equal ones that would not touch."""
    if abs(1 + ratio) < RADIUS_TOLERANCE:
        return []
    first = distance / abs(1 + ratio)
    return [(0, first), (1, first * abs(ratio))]


class Gear(Wheels, PlanarJoint):
    """(angle_a - phi) + n (angle_b - phi) = 0: the wheels roll on each other, seen from the line between their centres.

    phi is the angle by which that line has turned, so that the centres may be fixed to the ground, or to a carrier that turns, as those of
    planets. n is radius b over radius a; the second wheel turns the other way for a positive n and the same way for a negative one.
    It is given by `ratio`, by `radii` or by `teeth`. Each wheel needs a revolute on its carrier beside the gear.

    The line does not say how often it has turned: it is taken in the turn that fits the wheels best. A start or a step that is off by more
    than (1 + n) / 2 turns would be in mesh with another one.

    Attributes
    ----------
    ratio
        n; negative where one wheel is a ring that the other turns in, and for a belt that is not crossed.
    radii
        Pitch radii of both wheels; that of a ring is negative. They add up to the distance of the centres.
    """

    kind = "gear"

    ratio: Annotated[Number | None, Quantity("none")] = None
    radii: Annotated[Pair | None, Quantity("length")] = None

    @model_validator(mode="after")
    def _one_ratio(self) -> Self:
        given = [name for name in ("ratio", "radii", "teeth") if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"a gear has one of `ratio`, `radii` and `teeth`, not {' and '.join(given) or 'none of them'}")
        if self.ratio == 0 or (self.radii and (0 in self.radii or max(self.radii) < 0)):
            raise ValueError(
                "no ratio and no radius of a gear is zero, and of two wheels one at most is a ring, with a negative one"
            )
        return self

    def constraint(self, scene: Skeleton | None) -> tuple[Row, ...]:
        """Row that keeps the rotations of both wheels in their ratio."""
        (a, b), line, n = self.poses, np.array([1.0, 0.0]), self._ratio
        if scene is not None:
            line = self._line(scene)
        d = b.r - a.r
        turned = (d @ line, d @ np.array([-line[1], line[0]]))
        return (Row("rotation", "angle", (a.angle + n * b.angle, *turned, 1 + n), turn_law),)

    def circles(self, scene: Skeleton) -> list[tuple[int, float]]:
        """Pitch circles of both wheels, for pictures."""
        return rolling(float(np.linalg.norm(np.real(self.apart(scene)))), float(np.real(self._ratio)))

    @property
    def _ratio(self) -> Scalar:
        if self.ratio is not None:
            return self.ratio
        first, second = self.radii or self.teeth or (1.0, 1.0)
        return second / first

    def _line(self, scene: Skeleton) -> np.ndarray:
        """Vector from centre a to centre b in the undeformed configuration, divided by its length squared."""
        d = -self.apart(scene)
        square = d @ d
        if not np.real(square) > 0:
            raise InputError(
                f"a gear between points {self.points[0]!r} and {self.points[1]!r} has both centres at one place. Move one."
            )
        if self.radii is not None:
            reach, distance = abs(np.real(sum(self.radii))), np.sqrt(np.real(square))
            if abs(reach - distance) > RADIUS_TOLERANCE * distance:
                raise InputError(
                    f"radii of a gear between points {self.points[0]!r} and {self.points[1]!r} add up to {reach:g}, but the centres "
                    f"are {distance:g} apart. Fix one, give a ring a negative radius, or write `ratio` for wheels that do not touch."
                )
        return d / square


class SpatialGear(AboutAxis, Wheels, SpatialJoint):
    """angle_a + z_b / z_a angle_b = 0: the wheels roll on each other, about parallel axes, seen from the line between their centres.

    The centres may be fixed to the ground, or to a carrier that moves and turns. Each wheel needs a revolute on its carrier beside the
    gear, with the same axis. An axis in space does not say how often a wheel has turned, so that only whole numbers of teeth are a
    constraint; a start or a step that is off by more than half a tooth, of numbers without a common divisor, would be in mesh with the
    next one.

    Attributes
    ----------
    axis
        Direction of the axes of both wheels in the undeformed configuration, of any length.
    """

    kind = "gear"
    symbol = ""

    teeth: tuple[Teeth, Teeth]

    def constraint(self, scene: Skeleton | None) -> tuple[Row, ...]:
        """Row that keeps the rotations of both wheels in their ratio.

        The rotation of each wheel is that of its first axis, seen from the line between the centres.
        """
        (a, b), (x, y) = self.poses, (1.0, 0.0) if scene is None else self._line(scene)
        d = b.r - a.r
        seen = [form for e in (a, b) for form in (e.e(1) @ d * x + e.e(2) @ d * y, e.e(1) @ d * y - e.e(2) @ d * x)]
        first, second = self.teeth
        numbers = (second / first, 2 * np.pi * gcd(first, second) / abs(first))
        return (Row("rotation", "angle", (*seen, *numbers), teeth_law),)

    def circles(self, scene: Skeleton) -> list[tuple[int, float]]:
        """Pitch circles of both wheels, for pictures."""
        across = np.real(self.apart(scene) @ self.axes[:, :2])
        return rolling(float(np.linalg.norm(across)), self.teeth[1] / self.teeth[0])

    def _line(self, scene: Skeleton) -> np.ndarray:
        """Components along the first two axes of the line from centre a to centre b, over its length squared."""
        d = -self.apart(scene)
        line = d @ self.axes[:, :2]
        square = line @ line
        if not np.real(square) > RADIUS_TOLERANCE**2 * np.real(d @ d):
            raise InputError(
                f"a gear between points {self.points[0]!r} and {self.points[1]!r} has both centres on one axis. Move one of them aside."
            )
        return line / square
