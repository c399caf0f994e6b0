"""Friction in space, regularised by velocity: against turning about an axis, or against sliding along one."""

from __future__ import annotations

from toolkit.foundation.kernel import kernel
from toolkit.loads.friction import SlidingFriction, TurningFriction
from toolkit.loads.kernels.along import friction_along
from toolkit.loads.kernels.measured import space_angle, space_offset
from toolkit.loads.spatial.load import SpatialLoad
from toolkit.markers.component import AboutAxis


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

    kind = "turning-friction"
    formula = spatial_turning_friction
    measure = space_angle


class SpatialSlidingFriction(AboutAxis, SlidingFriction, SpatialLoad):
    """Force - F tanh(v / width) s(t) on the point of body a against its velocity v along an axis fixed in body b.

    The reaction acts on body b.
    """

    kind = "sliding-friction"
    formula = spatial_sliding_friction
    measure = space_offset
