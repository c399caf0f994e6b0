"""Force at a point of a body: fixed in space, or following the body's rotation."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import field_validator

from toolkit.components.curves.catalogue import Curve
from toolkit.components.curves.polynomial import Constant
from toolkit.components.loads.kernels.load_kernel import CURVE, SPATIAL_CURVE
from toolkit.components.loads.load import PlanarLoad, SpatialLoad
from toolkit.components.markers.component import Skeleton
from toolkit.description.description import Description, Number, Pair, Quantity, Scalar, Triple
from toolkit.foundation.kernel import kernel


class AppliedForce(Description):
    """Force F s(t) on `body` at `point`; with `frame = "body"` it turns with the body at that point.

    Attributes
    ----------
    body
        Body that the force acts on.
    point
        Name of the point on it.
    curve
        s(t).
    force
        F_x, F_y, in space F_z.
    frame
        Axes of F: those of space, or those that turn with the body.
    """

    kind: ClassVar[str] = "point-force"
    proportional: ClassVar[tuple[str, ...]] = ("force",)

    body: str
    point: str
    curve: Annotated[Curve, Quantity("none")] = Constant()
    force: Annotated[tuple[Number, ...], Quantity("force")]
    frame: Literal["space", "body"] = "space"

    @field_validator("body")
    @classmethod
    def _moves(cls, body: str) -> str:
        if body == "ground":
            raise ValueError("a force on the ground has no effect; name the body that it acts on")
        return body

    @property
    def grips(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Points where the load grips: the body, and the ground, which alone reacts."""
        return (self.body, self.point), ("ground", self.point)

    @property
    def time_curve(self) -> Curve:
        """Time curve s(t) that scales the force."""
        return self.curve

    def parameters(self, _scene: Skeleton) -> list[Scalar]:
        """Components of the force, and whether it follows the body."""
        return [*self.force, 1.0 if self.frame == "body" else 0.0]


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
    __doc__ = AppliedForce.__doc__

    formula = point_force

    force: Annotated[Pair, Quantity("force")]


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
    __doc__ = AppliedForce.__doc__

    formula = spatial_point_force

    force: Annotated[Triple, Quantity("force")]

    @property
    def feels_axes(self) -> bool:
        """Whether the load feels axes of markers, as a force does that follows the body."""
        return self.frame == "body"
