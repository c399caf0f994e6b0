"""Cams: a follower moves, or swings, as a curve of the cam's angle says, in the plane and in space."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import field_validator

from toolkit.components.curves.catalogue import Curve
from toolkit.components.joints.driver import smooth
from toolkit.components.joints.joint import AtPoints, Directed, Joint, PlanarJoint, SpatialJoint
from toolkit.components.joints.kernels.profile import profile_law
from toolkit.components.joints.profile import check_turn, profile_form
from toolkit.components.joints.rows import Form, Row
from toolkit.components.markers.component import AboutAxis, Skeleton
from toolkit.description.description import OverAngle, Quantity, Scalar, Triple
from toolkit.foundation.errors import InputError


class OnCam(AtPoints, Joint):
    """Base of followers, body a, on a cam, body b.

    Attributes
    ----------
    points
        Names of a point of the follower and of the centre of the cam.
    curve
        f over the angle of the cam in rad, where a curve of time has its time, from 0 to 2 pi; it ends as it begins.
    """

    curve: Curve
    _smooth = field_validator("curve")(smooth)

    def profile(self, scene: Skeleton | None) -> Form:
        """Form that carries the numbers of the profile f - f(0)."""
        if scene is not None:
            check_turn(self.curve, f"the {self.kind} between points {self.points[0]!r} and {self.points[1]!r}")
        return profile_form(self.curve)


class Lift(OnCam):
    """Base of followers that move along a straight line."""

    curve: Annotated[Curve, OverAngle("length")]

    def lifted(self, scene: Skeleton | None, along: Form, start: Scalar) -> tuple[Row, ...]:
        """Row of a lifted follower, from its offset along a direction and the angle of b against a."""
        a, b = self.poses
        forms = (along - start, b.e(1) @ a.e(1), b.e(1) @ a.e(2), self.profile(scene))
        return (Row("lift", "length", forms, profile_law),)


class Cam(Lift, Directed):
    """e . (r_a - r_b) - s_0 - (f(angle) - f(0)) = 0: the follower, body a, moves along e as the cam, body b, turns against it.

    s_0 is the offset in the undeformed configuration, and the angle counts from there, so that f may be a lift alone or with its base
    circle. The follower does not turn against what carries both, which may move: a slider with its rotation locked, with the same axis, and
    the revolute of the cam stand beside this joint. The follower stays on the cam even where a spring would have to press it on.

    Attributes
    ----------
    axis
        Direction of the lift in the undeformed configuration, of any length; it is fixed in body a.
    """

    kind = "cam"

    def constraint(self, scene: Skeleton | None) -> tuple[Row, ...]:
        """Row that keeps the follower's offset along the axis at the cam's profile."""
        (a, b), axis = self.poses, np.array(self.axis)
        start = 0.0 if scene is None else self.apart(scene) @ axis / np.sqrt(axis @ axis)
        return self.lifted(scene, (a.r - b.r) @ a.e(1), start)


class SpatialCam(AboutAxis, Lift, SpatialJoint):
    """n . (r_a - r_b) - s_0 - (f(angle) - f(0)) = 0: the follower, body a, moves along n as the cam, body b, turns against it.

    The angle is that about the axis. s_0 is the offset in the undeformed configuration, and the angle counts from there. The follower does
    not turn against what carries both, which may move: a prismatic joint and the revolute of the cam stand beside this joint.

    Attributes
    ----------
    axis
        Direction of the axis of the cam in the undeformed configuration, of any length.
    along
        Direction of the lift in the undeformed configuration, of any length: across the axis of a plate, along that of a drum. It is fixed
        in body a.
    """

    kind = "cam"
    symbol = ""

    along: Annotated[Triple, Quantity("none")]

    @field_validator("along")
    @classmethod
    def _leads(cls, along: Triple) -> Triple:
        if not any(along):
            raise ValueError("a lift needs a direction, for example [0, 1, 0]")
        return along

    def constraint(self, scene: Skeleton | None) -> tuple[Row, ...]:
        """Row that keeps the follower's offset along the direction at the cam's profile."""
        (a, b), n = self.poses, np.array(self.along)
        n = n / np.sqrt(n @ n)
        start = 0.0 if scene is None else self.apart(scene) @ n
        own, d = n @ self.axes, a.r - b.r
        return self.lifted(scene, a.e(1) @ d * own[0] + a.e(2) @ d * own[1] + a.e(3) @ d * own[2], start)


class Swing(OnCam):
    """Base of followers on a cam that swing."""

    curve: Annotated[Curve, OverAngle("angle")]

    def swung(self, scene: Skeleton | None, line: np.ndarray) -> tuple[Row, ...]:
        """Row of a swinging follower.

        The rotation of each body is that of its first axis, seen from the line between the centres.
        """
        (a, b), (x, y) = self.poses, line
        d = b.r - a.r
        seen = [form for e in (a, b) for form in (e.e(1) @ d * x + e.e(2) @ d * y, e.e(1) @ d * y - e.e(2) @ d * x)]
        return (Row("swing", "angle", (*seen, self.profile(scene)), profile_law),)

    def aside(self, scene: Skeleton | None, axes: np.ndarray) -> np.ndarray:
        """Components of the line between the centres along two axes, over its length squared."""
        if scene is None:
            return np.array([1.0, 0.0])
        line = -self.apart(scene) @ axes[:, :2]
        if not np.real(line @ line) > 0:
            raise InputError(
                f"a {self.kind} between points {self.points[0]!r} and {self.points[1]!r} has the pivot of its follower on the axis of the "
                "cam. Move one of them."
            )
        return line / (line @ line)


class SwingCam(Swing, PlanarJoint):
    """angle_a - (f(angle_b) - f(0)) = 0: the follower, body a, swings as the cam, body b, turns.

    Both angles count from the undeformed configuration and are seen from the line between the pivot of the follower and the centre of the
    cam, so that what carries both may move. The revolutes of both stand beside this joint. The follower stays on the cam even where a
    spring would have to press it on.
    """

    kind = "swing-cam"

    def constraint(self, scene: Skeleton | None) -> tuple[Row, ...]:
        """Row that keeps the follower's rotation at the cam's profile."""
        return self.swung(scene, self.aside(scene, np.eye(2)))


class SpatialSwingCam(AboutAxis, Swing, SpatialJoint):
    """angle_a - (f(angle_b) - f(0)) = 0: the follower, body a, swings as the cam, body b, turns, about parallel axes.

    Both angles count from the undeformed configuration and are seen from the line between the pivot of the follower and the centre of the
    cam, so that what carries both may move. The revolutes of both, with the same axis, stand beside this joint.

    Attributes
    ----------
    axis
        Direction of both axes in the undeformed configuration, of any length.
    """

    kind = "swing-cam"
    symbol = ""

    def constraint(self, scene: Skeleton | None) -> tuple[Row, ...]:
        """Row that keeps the follower's rotation at the cam's profile."""
        return self.swung(scene, self.aside(scene, self.axes))
