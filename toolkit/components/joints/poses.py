"""The poses of the two markers of a joint, and the rows that joints are made of: the same names in the plane and in space."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from toolkit.components.joints.rows import Form, Row, Vector, angle
from toolkit.description.description import Scalar


@dataclass(frozen=True, eq=False)
class Pose:
    """A marker: its position r and its axes; in the plane its angle too, of any number of turns.

    In the undeformed configuration the axes of both markers are those of the joint, by default those of the coordinates.
    """

    r: Vector
    axes: tuple[Vector, ...]
    turned: Form | None = None

    def e(self, i: int) -> Vector:
        """Axis e_i of the marker, counted from 1."""
        return self.axes[i - 1]

    @property
    def angle(self) -> Form:
        """Rotation of the marker since the undeformed configuration."""
        if self.turned is None:
            raise TypeError("a pose in space has no one angle; take `poses.turned`, or products of axes")
        return self.turned


@dataclass(frozen=True, eq=False)
class Poses:
    """Poses of the two markers of a joint, and rows of them. `for a, b in [poses]` or `a, b = poses` gives the poses."""

    a: Pose
    b: Pose

    along = 0
    """Which axis is that of a joint about or along an axis."""

    def __iter__(self) -> Iterator[Pose]:
        return iter((self.a, self.b))

    @cached_property
    def together(self) -> tuple[Row, ...]:
        """Rows of r_a = r_b: two points coincide."""
        return tuple(Row("xyz"[c], "length", self.a.r[c] - self.b.r[c]) for c in range(self.a.r.size))

    @property
    @abstractmethod
    def locked(self) -> tuple[Row, ...]:
        """Rows that leave no relative rotation."""

    @property
    @abstractmethod
    def on_line(self) -> tuple[Row, ...]:
        """Rows that keep point a on the joint's axis through point b."""

    @property
    @abstractmethod
    def turned(self) -> Row:
        """Row of the rotation of marker a against marker b, in space about the joint's axis."""

    def on_axis(self, j: int, name: str, offset: Scalar = 0.0) -> Row:
        """Axis e_j of marker b . (r_a - r_b) - offset = 0."""
        return Row(name, "length", (self.a.r - self.b.r) @ self.b.e(j) - offset)

    def apart(self, length: Scalar) -> Row:
        """(d . d / L - L) / 2 = 0 with d = r_a - r_b: its multiplier is the force of a rod of length L."""
        d = self.a.r - self.b.r
        return Row("distance", "length", d @ d * (0.5 / length) - length / 2)


class PlanePoses(Poses):
    """Poses of two markers in the plane; the first axis is that along which a joint slides, the second one its normal."""

    along = 1

    @cached_property
    def locked(self) -> tuple[Row, ...]:
        """Row of angle_a = angle_b, which leaves no relative rotation."""
        return (self.turned,)

    @cached_property
    def on_line(self) -> tuple[Row, ...]:
        """Row of one normal direction, which keeps point a on the joint's axis."""
        return (self.on_axis(2, "normal"),)

    @cached_property
    def turned(self) -> Row:
        """Row of the relative rotation angle_a - angle_b, of any number of turns."""
        return Row("rotation", "angle", self.a.angle - self.b.angle)


class SpacePoses(Poses):
    """Poses of two markers in space, whose third axis is that about or along which a joint moves."""

    along = 3

    def perpendicular(self, i: int, j: int, name: str) -> Row:
        """Axis e_i of marker a . axis e_j of marker b = 0: the bodies do not turn about the axis normal to both."""
        return Row(f"rotation {name}", "angle", self.a.e(i) @ self.b.e(j))

    @cached_property
    def aligned(self) -> tuple[Row, ...]:
        """Rows that keep the third axes of both markers parallel.

        That of b is normal to two axes of a, whatever the angle about it.
        """
        return (self.perpendicular(2, 3, "about the first axis"), self.perpendicular(1, 3, "about the second axis"))

    @cached_property
    def locked(self) -> tuple[Row, ...]:
        """Rows of three rotations, which leave no relative rotation."""
        return (*self.aligned, self.perpendicular(1, 2, "about the third axis"))

    @cached_property
    def on_line(self) -> tuple[Row, ...]:
        """Rows of two normal directions, which keep point a on the joint's axis."""
        return (self.on_axis(1, "first normal"), self.on_axis(2, "second normal"))

    @cached_property
    def turned(self) -> Row:
        """Row of the rotation about the third axis, measured in marker b: atan2(e_1a . e_2b, e_1a . e_1b)."""
        (a, b), name = self, "rotation"
        return angle(name, cosine=a.e(1) @ b.e(1), sine=a.e(1) @ b.e(2))


def plane_poses(axes: np.ndarray | None = None) -> PlanePoses:
    """Poses in the plane: vectors 0 to 5 are r, e_1, e_2 of a and of b, 6 is r_a - r_b, numbers 0 to 5 are x, y, angle of a and of b.

    `axes` (2, 2) has the axes of both markers in the undeformed configuration as columns.
    """

    def pose(first: int) -> Pose:
        own = [Vector(((first + i, -1, 1.0),), 2) for i in (1, 2)]
        turned = own if axes is None else [own[0] * axes[0, i] + own[1] * axes[1, i] for i in range(2)]
        return Pose(Vector(((first, first, 1.0),), 2, position=True), tuple(turned), Form(linear=((first + 2, 1.0),)))

    return PlanePoses(pose(0), pose(3))


def _space_pose(first: int) -> Pose:
    vectors = [Vector(((first + i, 3 * (first + i), 1.0),), 3) for i in range(4)]
    return Pose(vectors[0], tuple(vectors[1:]))


PLANE = plane_poses()
"""Poses in the plane with the axes of the coordinates."""
SPACE = SpacePoses(_space_pose(0), _space_pose(4))
"""Vectors 0 to 7 are r, e_1, e_2, e_3 of a and of b, numbers 0 to 23 their components; the axes of markers in space are the joint's own."""
