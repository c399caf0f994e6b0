"""Torque on a body, and its reaction on another."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

from pydantic import model_validator

from toolkit.components.curves.catalogue import Curve
from toolkit.components.curves.polynomial import Constant
from toolkit.components.loads.kernels.load_kernel import CURVE, SPATIAL_CURVE
from toolkit.components.loads.load import PlanarLoad, SpatialLoad
from toolkit.components.markers.component import Place, Skeleton, on_both
from toolkit.description.description import Description, Number, Quantity, Scalar, Triple
from toolkit.foundation.kernel import inner, kernel


class AppliedTorque(Description):
    """Torque M s(t) on `body` at `point` (any point of a rigid body); the reaction acts on `reaction`.

    In the plane it is positive counter-clockwise. With two points the reaction acts at the second.

    Attributes
    ----------
    body
        Body that the torque acts on.
    point
        Name of the point, or of the point on `body` and that on `reaction`.
    curve
        s(t).
    reaction
        Body that the opposite torque acts on.
    torque
        M, in space M_x, M_y, M_z, in force length.
    """

    kind: ClassVar[str] = "torque"
    proportional: ClassVar[tuple[str, ...]] = ("torque",)

    body: str
    point: Place
    curve: Annotated[Curve, Quantity("none")] = Constant()
    reaction: str = "ground"

    @model_validator(mode="after")
    def _two_bodies(self) -> Self:
        if self.body == self.reaction:
            raise ValueError(
                f"a torque on {self.body!r} with its reaction on the same body has no effect; name another `reaction`"
            )
        return self

    @property
    def grips(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Points where the load grips: the body and its reaction, each at the point."""
        first, second = on_both(self.point)
        return (self.body, first), (self.reaction, second)

    @property
    def time_curve(self) -> Curve:
        """Time curve s(t) that scales the torque."""
        return self.curve


@kernel
def torque(z, w, force, force_z, force_w):
    """f = [0, 0, M s, 0, 0, -M s] with the torque M and the curve's value s."""
    force[2], force[5] = z[6] * z[CURVE], -z[6] * z[CURVE]
    force_z[2, 6], force_z[5, 6] = z[CURVE], -z[CURVE]
    force_z[2, CURVE], force_z[5, CURVE] = z[6], -z[6]


class Torque(AppliedTorque, PlanarLoad):
    __doc__ = AppliedTorque.__doc__

    formula = torque

    torque: Annotated[Number, Quantity("torque")]

    def parameters(self, _scene: Skeleton) -> list[Scalar]:
        """Parameter of the law: the torque."""
        return [self.torque]


@inner
def add_torque(z, side, sign, follow, scale, force, force_z):
    """Add the forces on the axes of one marker by a torque M, and their derivatives.

    f_i = sign M x e_i / 2 with M = s sum_k p_k m_k.

    m_k are the axes of space, or with `follow` = 1 those of marker a.
    """
    for axis in range(3):
        at = 12 * side + 3 + 3 * axis
        for c in range(3):
            a, b = (c + 1) % 3, (c + 2) % 3
            for k in range(3):
                half = sign * z[24 + k] / 2
                m_a = (1 - follow if a == k else 0 * follow) + follow * z[3 + 3 * k + a]
                m_b = (1 - follow if b == k else 0 * follow) + follow * z[3 + 3 * k + b]
                part = m_a * z[at + b] - m_b * z[at + a]
                force[at + c] += scale * half * part
                force_z[at + c, SPATIAL_CURVE] += half * part
                force_z[at + c, 24 + k] += scale * sign * part / 2
                force_z[at + c, at + b] += scale * half * m_a
                force_z[at + c, at + a] -= scale * half * m_b
                force_z[at + c, 3 + 3 * k + a] += scale * half * follow * z[at + b]
                force_z[at + c, 3 + 3 * k + b] -= scale * half * follow * z[at + a]


@kernel
def spatial_torque(z, w, force, force_z, force_w):
    """M = s (p_0, p_1, p_2) on marker a, in the axes of space, or with p_3 = 1 in those of marker a; - M on marker b."""
    add_torque(z, 0, 1.0, z[27], z[SPATIAL_CURVE], force, force_z)
    add_torque(z, 1, -1.0, z[27], z[SPATIAL_CURVE], force, force_z)


class SpatialTorque(AppliedTorque, SpatialLoad):
    """Torque M s(t) on `body` at `point` (any point of a rigid body); the reaction acts on `reaction`.

    In the plane it is positive counter-clockwise. With two points the reaction acts at the second.

    Attributes
    ----------
    frame
        Axes of M: those of space, or those that turn with `body` at the point.
    """

    formula = spatial_torque

    torque: Annotated[Triple, Quantity("torque")]
    frame: Literal["space", "body"] = "space"

    def parameters(self, _scene: Skeleton) -> list[Scalar]:
        """Components of the torque, and whether it follows the body."""
        return [*self.torque, 1.0 if self.frame == "body" else 0.0]
