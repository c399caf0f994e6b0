"""Bases of all loads: what acts on whole bodies, and what acts between two markers; a new load is one such class with its force law."""

from __future__ import annotations

from typing import ClassVar, Literal, Self

from pydantic import model_validator

from toolkit.components.joints.joint import AtPoint
from toolkit.components.joints.kernels.laws import angle_of
from toolkit.components.joints.rows import RowQuantity
from toolkit.components.loads.kernels.measured import AXIS_ANGLE
from toolkit.components.markers.component import AlongAxis, Component
from toolkit.description.description import Description, InSpace, Registered, Scalar
from toolkit.foundation.kernel import plain


class AnyLoad(InSpace):
    """Base of all loads: those on markers, and those on whole bodies and surfaces."""

    siblings: ClassVar[str] = "PlanarLoad or SpatialLoad"
    proportional: ClassVar[tuple[str, ...]] = ()
    """Fields that it is proportional to, so that a load as large again is one of twice their numbers; none of a spring."""


class Load(AnyLoad, Component):
    """Forces and torques f(pose a, pose b, rates, parameters, curve value) on two markers.

    `formula(z, w, force, force_z, force_w)` (see `load_kernel`) fills f, f_z and f_w; the value of the time curve is its last argument.
    """

    leads: ClassVar[bool] = False
    """Whether its time curve leads, as that of a driver does, instead of being what grows with the loads."""

    @property
    def turn(self) -> Literal["zero", "state", "curve"] | None:
        """Reference next to which the turn of the load's angle in space is taken, as an axis says nothing of turns.

        Where the turn is lost the torque jumps. None if the load feels no angle.
        """
        return None

    @property
    def state(self) -> RowQuantity | None:
        """Quantity that the load's own state is compared with, also as an integral over time; None without a state.

        It is a length or an angle; pure numbers count as angles.
        """
        return None


class AnyPlanarLoad(AnyLoad):
    """Base of all loads on bodies in the plane."""

    dimension: ClassVar[int] = 2


class PlanarLoad(Load, AnyPlanarLoad):
    """Forces and torques f(pose a, pose b, rates, parameters, curve value) on two markers in the plane.

    `formula(z, w, force, force_z, force_w)` (see `load_kernel`) fills f, f_z and f_w; the value of the time curve is its last argument.
    z[0:3] and z[3:6] are x, y and angle of both markers; parameters begin at z[6].
    """


class AlongAxisLoad(AlongAxis, PlanarLoad):
    """Base of loads along an axis fixed in body b; the angle of the axis is the last parameter."""

    def with_axis(self, found: list[Scalar]) -> list[Scalar]:
        """Parameters of the law, followed by the angle of the axis."""
        x, y = self.axis
        return [*found, *[0.0] * (AXIS_ANGLE - 6 - len(found)), plain(angle_of)(y, x)]


class AnySpatialLoad(AnyLoad):
    """Base of all loads on bodies in space."""

    dimension: ClassVar[int] = 3


class SpatialLoad(Load, AnySpatialLoad):
    """Forces f(pose a, pose b, rates, parameters, curve value) on two markers, conjugate to their poses of four vectors.

    `formula(z, w, force, force_z, force_w)` (see `load_kernel`) fills f, f_z and f_w; the value of the time curve is its last argument,
    z[SPATIAL_CURVE]. z[0:3] and z[12:15] are the positions, then follow the three axes of each marker; parameters begin at z[24].
    """


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


class Acting(Description):
    """Base of loads of which one number at least is to be written. It may be zero: what begins there can be varied."""

    acts_by: ClassVar[tuple[str, ...]] = ("stiffness", "damping")
    """Names of these numbers."""

    @model_validator(mode="after")
    def _acts(self) -> Self:
        if not self.model_fields_set.intersection(self.acts_by):
            *others, last = self.acts_by
            names = f"{', '.join(others)} or {last}"
            raise ValueError(f"{name_of(self)} has no effect without {names}; give one of them")
        return self
