"""Friction, regularised by velocity: against turning, or against sliding along an axis."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, ClassVar

from toolkit.components.curves.catalogue import Curve
from toolkit.components.curves.polynomial import Constant
from toolkit.components.loads.kernels.along import friction_along
from toolkit.components.loads.kernels.measured import AXIS_ANGLE, plane_angle, plane_offset, space_angle, space_offset
from toolkit.components.loads.load import AlongAxisLoad, BetweenBodies, PlanarLoad, SpatialLoad
from toolkit.components.markers.component import AboutAxis, Skeleton
from toolkit.description.description import NotNegative, Positive, Quantity, Scalar
from toolkit.foundation.kernel import kernel


class Friction(BetweenBodies):
    """Base of friction between two bodies, regularised by velocity: u = - s(t) F tanh(g' / d) against the rate g' of what slides or turns.

    Its level F is given; it does not follow from forces of joints. At rates far above the width d it is F; below, it is a damper: it
    never holds, but lets creep under a load L < F with the rate d artanh(L / F). In an equilibrium, where nothing moves, it is zero.

    Attributes
    ----------
    curve
        s(t), such as the course of a pressing force.
    """

    measure: ClassVar[Callable]
    """Function g that measures what slides or turns, see `measured`."""
    rate: ClassVar[str]
    """Quantity of the rate g', one of `toolkit.foundation.units`."""

    level: Annotated[NotNegative, Quantity("force")]
    width: Annotated[Positive, Quantity("length/time")]
    curve: Annotated[Curve, Quantity("none")] = Constant()

    @property
    def time_curve(self) -> Curve:
        """Time curve s(t) that scales the friction."""
        return self.curve

    def parameters(self, _scene: Skeleton) -> list[Scalar]:
        """Parameters of the friction law: level and width."""
        return [self.level, self.width]

    @classmethod
    def measured(cls) -> Callable:
        """Function that measures what slides or turns.

        Reached through an instance it would be bound to it.
        """
        return cls.measure


class TurningFriction(Friction):
    """Base of friction against the rotation of body a against body b.

    Attributes
    ----------
    level
        F, the torque of friction.
    width
        d, the relative rate of rotation below which friction is a damper, in rad/time: it sets the width of the regularisation.
    """

    kind: ClassVar[str] = "turning-friction"
    rate = "angular_velocity"

    level: Annotated[NotNegative, Quantity("torque")]
    width: Annotated[Positive, Quantity("angle/time")]


class SlidingFriction(Friction):
    """Force - F tanh(v / width) s(t) on the point of body a against its velocity v along an axis fixed in body b.

    The reaction acts on body b.

    Attributes
    ----------
    level
        F, the force of friction, such as mu N.
    width
        d, the relative velocity below which friction is a damper: it sets the width of the regularisation.
    """

    kind: ClassVar[str] = "sliding-friction"
    rate = "velocity"


@kernel
def turning_friction(z, w, force, force_z, force_w):
    """u = - s F tanh(g' / d) along g = angle_a - angle_b, see `along`."""
    plane_angle(z, force, force_z)
    friction_along(6, z, w, force, force_z, force_w)


@kernel
def sliding_friction(z, w, force, force_z, force_w):
    """u = - s F tanh(g' / d) along g = e . (r_a - r_b); the angle of the axis e acts like that of body b."""
    plane_offset(z, force, force_z)
    friction_along(6, z, w, force, force_z, force_w)
    for i in range(6):
        force_z[i, AXIS_ANGLE] = force_z[i, 5]


class PlanarTurningFriction(TurningFriction, PlanarLoad):
    """Torque - F tanh(angle' / width) s(t) on body a against its rotation relative to body b, its opposite on body b."""

    formula = turning_friction
    measure = plane_angle


class PlanarSlidingFriction(SlidingFriction, AlongAxisLoad):
    __doc__ = SlidingFriction.__doc__

    formula = sliding_friction
    measure = plane_offset

    def parameters(self, scene: Skeleton) -> list[Scalar]:
        """Level and width of the friction law, and the angle of the axis."""
        return self.with_axis(SlidingFriction.parameters(self, scene))


@kernel
def spatial_turning_friction(z, w, force, force_z, force_w):
    """u = - s F tanh(g' / d) along the rotation g about the third axis, see `along`."""
    space_angle(z, force, force_z)
    friction_along(24, z, w, force, force_z, force_w)


@kernel
def spatial_sliding_friction(z, w, force, force_z, force_w):
    """u = - s F tanh(g' / d) along g = e_3b . (r_a - r_b)."""
    space_offset(z, force, force_z)
    friction_along(24, z, w, force, force_z, force_w)


class SpatialTurningFriction(AboutAxis, TurningFriction, SpatialLoad):
    """Torque - F tanh(angle' / width) s(t) about an axis on body a against its rotation relative to body b, its opposite on body b.

    Both bodies turn against each other about this axis alone: a revolute or cylindrical joint with the same axis has to stand beside it.
    """

    formula = spatial_turning_friction
    measure = space_angle


class SpatialSlidingFriction(AboutAxis, SlidingFriction, SpatialLoad):
    __doc__ = SlidingFriction.__doc__

    formula = spatial_sliding_friction
    measure = space_offset
