"""Base of forces and torques in the plane and in space: where they act, and their time curve."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import field_validator, model_validator

from toolkit.curves.catalogue import Curve
from toolkit.curves.polynomial import Constant
from toolkit.description.description import Description
from toolkit.description.quantity import Quantity
from toolkit.markers.component import Place, on_both


class AppliedForce(Description):
    """Base of forces on a body at a point.

    Attributes
    ----------
    body
        Body that the force acts on.
    point
        Name of the point on it.
    curve
        s(t).
    """

    body: str
    point: str
    curve: Annotated[Curve, Quantity("none")] = Constant()

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


class AppliedTorque(Description):
    """Base of torques on a body, whose reaction acts on another. With two points it acts at the second.

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
    """

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
