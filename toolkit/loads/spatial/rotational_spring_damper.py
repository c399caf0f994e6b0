"""Spring-damper between the rotations of two bodies about an axis in space."""

from __future__ import annotations

from typing import Literal

from toolkit.foundation.kernel import kernel
from toolkit.joints.rows import RowQuantity
from toolkit.loads.kernels.along import counted_turns, spring_along
from toolkit.loads.kernels.measured import space_angle
from toolkit.loads.spatial.load import SpatialLoad
from toolkit.loads.springs import TurnSpring
from toolkit.markers.component import AboutAxis


@kernel
def spatial_rotational_spring_damper(z, w, force, force_z, force_w):
    """u = - k (g - g_0) - c g' along the rotation g about the third axis, (k, c, g_0) = parameters; see `along`.

    Without a state of its own, w[24] is zero and g the angle nearest to zero.
    """
    g = counted_turns(24, space_angle(z, force, force_z), w, force, force_z, force_w)
    spring_along(24, g, z, w, force, force_z, force_w)


class SpatialRotationalSpringDamper(AboutAxis, TurnSpring, SpatialLoad):
    """Torque -k (angle - rest_angle) - c angle' about an axis between two bodies, angle since the undeformed configuration.

    Both bodies turn against each other about this axis alone: a revolute or cylindrical joint with the same axis has to stand beside it.

    Attributes
    ----------
    counts_turns
        Whether the angle has any number of turns, as that of a clock spring. They are counted by a coordinate of the spring's own, from
        those of the start position, in (-pi, pi], on. Otherwise the angle is one of (-pi, pi], and what turns beyond is refused, but for a
        damper without `stiffness`, which feels no angle.
    """

    kind = "rotational-spring-damper"
    formula = spatial_rotational_spring_damper
    counts_turns: bool = False

    @property
    def turn(self) -> Literal["zero", "state"] | None:
        """Reference of the turn of the angle: the counted turns, or zero; None for a damper alone, which feels no angle."""
        if "stiffness" not in self.model_fields_set:
            return None
        return "state" if self.counts_turns else "zero"

    @property
    def state(self) -> RowQuantity | None:
        """Quantity of the spring's own state: the angle that tells which turn it is; None where turns are not counted."""
        return "angle" if self.counts_turns else None
