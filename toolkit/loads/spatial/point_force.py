"""Force at a point of a body in space: fixed in space, or following the body's rotation."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from toolkit.description.description import Triple
from toolkit.description.quantity import Quantity
from toolkit.foundation.kernel import kernel
from toolkit.loads.applied import AppliedForce
from toolkit.loads.kernels.load_kernel import SPATIAL_CURVE
from toolkit.loads.spatial.load import SpatialLoad
from toolkit.markers.component import Skeleton


@kernel
def spatial_point_force(z, w, force, force_z, force_w):
    """f_a = s (p_0, p_1, p_2), or with p_3 = 1 along the axes of the marker: f_a = s (p_0 e_1 + p_1 e_2 + p_2 e_3)."""
    follow, scale = z[27], z[SPATIAL_CURVE]
    for i in range(3):
        total = (1 - follow) * z[24 + i]
        for k in range(3):
            at = 3 + 3 * k + i
            total += follow * z[24 + k] * z[at]
            force_z[i, at] = scale * follow * z[24 + k]
            force_z[i, 24 + k] = scale * (follow * z[at] + (1 - follow if i == k else 0 * follow))
        force[i] = scale * total
        force_z[i, SPATIAL_CURVE] = total


class SpatialPointForce(AppliedForce, SpatialLoad):
    """Force F s(t) on `body` at `point`; with `frame = "body"` it turns with the body at that point.

    Attributes
    ----------
    force
        F_x, F_y, F_z.
    frame
        Axes of F: those of space, or those that turn with the body.
    """

    kind = "point-force"
    proportional = ("force",)
    formula = spatial_point_force

    force: Annotated[Triple, Quantity("force")]
    frame: Literal["space", "body"] = "space"

    @property
    def feels_axes(self) -> bool:
        """Whether the load feels axes of markers, as a force does that follows the body."""
        return self.frame == "body"

    def parameters(self, _scene: Skeleton) -> list[Any]:
        """Components of the force, and whether it follows the body."""
        return [*self.force, 1.0 if self.frame == "body" else 0.0]
