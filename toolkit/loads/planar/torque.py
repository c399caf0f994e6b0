"""Torque on a body, and its reaction on another."""

from __future__ import annotations

from typing import Annotated, Any

from toolkit.description.description import Number
from toolkit.description.quantity import Quantity
from toolkit.foundation.kernel import kernel
from toolkit.loads.applied import AppliedTorque
from toolkit.loads.kernels.load_kernel import CURVE
from toolkit.loads.planar.load import PlanarLoad
from toolkit.markers.component import Skeleton


@kernel
def torque(z, w, force, force_z, force_w):
    """f = [0, 0, M s, 0, 0, -M s] with the torque M and the curve's value s."""
    force[2], force[5] = z[6] * z[CURVE], -z[6] * z[CURVE]
    force_z[2, 6], force_z[5, 6] = z[CURVE], -z[CURVE]
    force_z[2, CURVE], force_z[5, CURVE] = z[6], -z[6]


class Torque(AppliedTorque, PlanarLoad):
    """Torque M s(t) on `body` at `point` (any point of a rigid body), counter-clockwise positive; the reaction acts on `reaction`.

    With two points the reaction acts at the second.

    Attributes
    ----------
    torque
        M, in force length.
    """

    kind = "torque"
    proportional = ("torque",)
    formula = torque

    torque: Annotated[Number, Quantity("torque")]

    def parameters(self, _scene: Skeleton) -> list[Any]:
        """Parameter of the law: the torque."""
        return [self.torque]
