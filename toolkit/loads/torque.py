"""Torque on a body, and its reaction on another."""

from __future__ import annotations

from typing import Any

from pydantic import model_validator

from toolkit.component import Place, Skeleton, on_both
from toolkit.description import Number
from toolkit.kernel import kernel
from toolkit.loads.load import Load
from toolkit.loads.load_kernel import CURVE
from toolkit.profile import Constant, Curve


@kernel
def torque(z, w, force, force_z, force_w):
    """f = [0, 0, M s, 0, 0, -M s] with the torque M and the curve's value s."""
    force[2], force[5] = z[6] * z[CURVE], -z[6] * z[CURVE]
    force_z[2, 6], force_z[5, 6] = z[CURVE], -z[CURVE]
    force_z[2, CURVE], force_z[5, CURVE] = z[6], -z[6]


class Torque(Load):
    """Torque M s(t) on `body` at `point` (any point of a rigid body), counter-clockwise positive; the reaction acts on `reaction`.

    With two points the reaction acts at the second.

    Attributes
    ----------
    body
        Body that the torque acts on.
    point
        Name of the point, or of the point on `body` and that on `reaction`.
    torque
        M, in force length.
    curve
        s(t).
    reaction
        Body that the opposite torque acts on.
    """

    kind = "torque"
    formula = torque

    body: str
    point: Place
    torque: Number
    curve: Curve = Constant()
    reaction: str = "ground"

    @model_validator(mode="after")
    def _two_bodies(self) -> Torque:
        if self.body == self.reaction:
            raise ValueError(
                f"a torque on {self.body!r} with its reaction on the same body has no effect; name another `reaction`"
            )
        return self

    @property
    def grips(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Each body at the point."""
        first, second = on_both(self.point)
        return (self.body, first), (self.reaction, second)

    @property
    def time_curve(self) -> Curve:
        """s(t)."""
        return self.curve

    def parameters(self, _scene: Skeleton) -> list[Any]:
        """The torque."""
        return [self.torque]
