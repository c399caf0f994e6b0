"""Force at a point of a body: fixed in space, or following the body's rotation."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np

from toolkit.description.description import Pair
from toolkit.description.quantity import Quantity
from toolkit.foundation.kernel import kernel
from toolkit.loads.applied import AppliedForce
from toolkit.loads.kernels.load_kernel import CURVE
from toolkit.loads.planar.load import PlanarLoad
from toolkit.markers.component import Skeleton


@kernel
def point_force(z, w, force, force_z, force_w):
    """f_a = s A(k angle_a) (p_0, p_1), k = p_2: 0 for a force fixed in space, 1 for one that follows the body."""
    follow = z[8]
    c, s = np.cos(follow * z[2]), np.sin(follow * z[2])
    x, y = c * z[6] - s * z[7], s * z[6] + c * z[7]
    force[0], force[1] = z[CURVE] * x, z[CURVE] * y
    force_z[0, 6], force_z[0, 7] = z[CURVE] * c, -z[CURVE] * s
    force_z[1, 6], force_z[1, 7] = z[CURVE] * s, z[CURVE] * c
    force_z[0, CURVE], force_z[1, CURVE] = x, y
    force_z[0, 2], force_z[1, 2] = -follow * z[CURVE] * y, follow * z[CURVE] * x


class PointForce(AppliedForce, PlanarLoad):
    """Force F s(t) on `body` at `point`; with `frame = "body"` it turns with the body at that point.

    Attributes
    ----------
    force
        F_x, F_y.
    frame
        Axes of F: those of space, or those that turn with the body.
    """

    kind = "point-force"
    proportional = ("force",)
    formula = point_force

    force: Annotated[Pair, Quantity("force")]
    frame: Literal["space", "body"] = "space"

    def parameters(self, _scene: Skeleton) -> list[Any]:
        """Components of the force, and whether it follows the body."""
        return [*self.force, 1.0 if self.frame == "body" else 0.0]
