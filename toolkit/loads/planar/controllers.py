"""Controllers in the plane: of a relative angle, of a position along an axis, of a distance."""

from __future__ import annotations

from typing import Any

from toolkit.foundation.kernel import kernel
from toolkit.loads.controllers import AngleControlled, DistanceControlled, PositionControlled
from toolkit.loads.kernels.along import control_along
from toolkit.loads.kernels.measured import TILT, distance, plane_angle, plane_offset
from toolkit.loads.planar.along_axis import AlongAxisLoad
from toolkit.loads.planar.load import PlanarLoad
from toolkit.markers.component import Skeleton


@kernel
def angle_controller(z, w, force, force_z, force_w):
    """u = k_p (s - g) + k_i x - k_d g' along g = angle_a - angle_b, see `along`."""
    control_along(6, plane_angle(z, force, force_z), z, w, force, force_z, force_w)


@kernel
def position_controller(z, w, force, force_z, force_w):
    """u = k_p (s - g) + k_i x - k_d g' along g = e . (r_a - r_b); the angle of the axis e acts like that of body b."""
    control_along(6, plane_offset(z, force, force_z), z, w, force, force_z, force_w)
    for i in range(7):
        force_z[i, TILT] = force_z[i, 5]


@kernel
def distance_controller(z, w, force, force_z, force_w):
    """u = k_p (s - g) + k_i x - k_d g' along g = |r_a - r_b|."""
    control_along(6, distance(z, 3, force, force_z), z, w, force, force_z, force_w)


class AngleController(AngleControlled, PlanarLoad):
    """Torque k_p (s - angle) + k_i x - k_d angle', x' = s - angle, on body a, its opposite on body b: a motor.

    The angle is the relative rotation since the undeformed configuration, with all turns; it is led to s(t).
    """

    kind = "angle-controller"
    formula = angle_controller


class PositionController(PositionControlled, AlongAxisLoad):
    """Force k_p (s - g) + k_i x - k_d g', x' = s - g, along an axis fixed in body b: a linear motor.

    The point of body a stands at g on the axis, and is led to s(t); there the force acts, its reaction on body b.
    """

    kind = "position-controller"
    formula = position_controller

    def parameters(self, scene: Skeleton) -> list[Any]:
        """Gains of the controller, and the angle of the axis."""
        return self.with_axis(PositionControlled.parameters(self, scene))


class DistanceController(DistanceControlled, PlanarLoad):
    """Force k_p (s - l) + k_i x - k_d l', x' = s - l, along the line between two points: a cylinder.

    It is led to the length s(t); a positive force drives the points apart.
    """

    kind = "distance-controller"
    formula = distance_controller
