"""Controllers in space: of a relative angle, of a position along an axis, of a distance."""

from __future__ import annotations

from typing import Literal

from toolkit.foundation.kernel import kernel
from toolkit.loads.controllers import AngleControlled, DistanceControlled, PositionControlled
from toolkit.loads.kernels.along import control_along
from toolkit.loads.kernels.load_kernel import SPATIAL_CURVE
from toolkit.loads.kernels.measured import distance, space_angle, space_offset, turn_next_to
from toolkit.loads.spatial.load import SpatialLoad
from toolkit.markers.component import AboutAxis


@kernel
def spatial_angle_controller(z, w, force, force_z, force_w):
    """u = k_p (s - g) + k_i x - k_d g' along the rotation g about the third axis, in the turn next to s, see `along`."""
    g = turn_next_to(z[SPATIAL_CURVE], space_angle(z, force, force_z))
    control_along(24, g, z, w, force, force_z, force_w)


@kernel
def spatial_position_controller(z, w, force, force_z, force_w):
    """u = k_p (s - g) + k_i x - k_d g' along g = e_3b . (r_a - r_b)."""
    control_along(24, space_offset(z, force, force_z), z, w, force, force_z, force_w)


@kernel
def spatial_distance_controller(z, w, force, force_z, force_w):
    """u = k_p (s - g) + k_i x - k_d g' along g = |r_a - r_b|."""
    control_along(24, distance(z, 12, force, force_z), z, w, force, force_z, force_w)


class SpatialAngleController(AboutAxis, AngleControlled, SpatialLoad):
    """Torque k_p (s - angle) + k_i x - k_d angle', x' = s - angle, about an axis on body a, its opposite on body b.

    A motor that leads the angle since the undeformed configuration to s(t), of any number of turns. An axis in space does not say how often
    a body has turned: the angle is taken in the turn next to s(t), and a motion that stays behind by more than half a turn is refused.
    Both bodies turn against each other about this axis alone: a revolute or cylindrical joint with the same axis has to stand beside it.
    """

    kind = "angle-controller"
    formula = spatial_angle_controller

    @property
    def turn(self) -> Literal["curve"]:
        """Reference of the turn of the angle: the curve of the set value."""
        return "curve"


class SpatialPositionController(AboutAxis, PositionControlled, SpatialLoad):
    """Force k_p (s - g) + k_i x - k_d g', x' = s - g, along an axis fixed in body b: a linear motor.

    The point of body a stands at g on the axis, and is led to s(t); there the force acts, its reaction on body b.
    """

    kind = "position-controller"
    formula = spatial_position_controller


class SpatialDistanceController(DistanceControlled, SpatialLoad):
    """Force k_p (s - l) + k_i x - k_d l', x' = s - l, along the line between two points: a cylinder.

    It is led to the length s(t); a positive force drives the points apart.
    """

    kind = "distance-controller"
    formula = spatial_distance_controller

    @property
    def feels_axes(self) -> bool:
        """Whether the load feels axes of markers: no, only their positions."""
        return False
