"""Friction in the plane, regularised by velocity: against turning, or against sliding along an axis."""

from __future__ import annotations

from typing import Any

from toolkit.foundation.kernel import kernel
from toolkit.loads.friction import SlidingFriction, TurningFriction
from toolkit.loads.kernels.along import friction_along
from toolkit.loads.kernels.measured import TILT, plane_angle, plane_offset
from toolkit.loads.planar.along_axis import AlongAxisLoad
from toolkit.loads.planar.load import PlanarLoad
from toolkit.markers.component import Skeleton


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
        force_z[i, TILT] = force_z[i, 5]


class PlanarTurningFriction(TurningFriction, PlanarLoad):
    """Torque - F tanh(angle' / width) s(t) on body a against its rotation relative to body b, its opposite on body b."""

    kind = "turning-friction"
    formula = turning_friction
    measure = plane_angle


class PlanarSlidingFriction(SlidingFriction, AlongAxisLoad):
    """Force - F tanh(v / width) s(t) on the point of body a against its velocity v along an axis fixed in body b.

    The reaction acts on body b.
    """

    kind = "sliding-friction"
    formula = sliding_friction
    measure = plane_offset

    def parameters(self, scene: Skeleton) -> list[Any]:
        """Level and width of the friction law, and the angle of the axis."""
        return self.with_axis(SlidingFriction.parameters(self, scene))
