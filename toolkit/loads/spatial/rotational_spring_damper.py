"""Spring-damper between the rotations of two bodies about an axis in space."""

from __future__ import annotations

from toolkit.foundation.kernel import kernel
from toolkit.loads.kernels.along import spring_along
from toolkit.loads.kernels.measured import space_angle
from toolkit.loads.spatial.load import SpatialLoad
from toolkit.loads.springs import TurnSpring
from toolkit.markers.about_axis import AboutAxis


@kernel
def spatial_rotational_spring_damper(z, w, force, force_z, force_w):
    """u = - k (g - g_0) - c g' along the rotation g about the third axis, (k, c, g_0) = parameters; see `along`."""
    spring_along(24, space_angle(z, force, force_z), z, w, force, force_z, force_w)


class SpatialRotationalSpringDamper(AboutAxis, TurnSpring, SpatialLoad):
    """Torque -k (angle - rest_angle) - c angle' about an axis between two bodies, angle in (-pi, pi] since the undeformed configuration.

    Both bodies turn against each other about this axis alone: a revolute or cylindrical joint with the same axis has to stand beside it.
    """

    kind = "rotational-spring-damper"
    formula = spatial_rotational_spring_damper
    folds = True
