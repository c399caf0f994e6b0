"""Base of friction in the plane and in space: its level, and the width of its regularisation."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, ClassVar

from toolkit.curves.catalogue import Curve
from toolkit.curves.kinds.constant import Constant
from toolkit.description.description import NotNegative, Positive
from toolkit.description.quantity import Quantity
from toolkit.loads.places import BetweenBodies
from toolkit.markers.component import Skeleton


class Friction(BetweenBodies):
    """Base of friction between two bodies, regularised by velocity: u = - s(t) F tanh(g' / d) against the rate g' of what slides or turns.

    Its level F is given; it does not follow from forces of joints. At rates far above the width d it is F; below, it is a damper: it
    never holds, but lets creep under a load L < F with the rate d artanh(L / F). In an equilibrium, where nothing moves, it is zero.

    Attributes
    ----------
    curve
        s(t), such as the course of a pressing force.
    """

    measure: ClassVar[Callable]
    """Function g that measures what slides or turns, see `measured`."""
    rate: ClassVar[str]
    """Quantity of the rate g', one of `toolkit.foundation.units`."""

    level: Annotated[NotNegative, Quantity("force")]
    width: Annotated[Positive, Quantity("length/time")]
    curve: Annotated[Curve, Quantity("none")] = Constant()

    @property
    def time_curve(self) -> Curve:
        """Time curve s(t) that scales the friction."""
        return self.curve

    def parameters(self, _scene: Skeleton) -> list[Any]:
        """Parameters of the friction law: level and width."""
        return [self.level, self.width]

    @classmethod
    def measured(cls) -> Callable:
        """Function that measures what slides or turns.

        Reached through an instance it would be bound to it.
        """
        return cls.measure


class TurningFriction(Friction):
    """Base of friction against the rotation of body a against body b.

    Attributes
    ----------
    level
        F, the torque of friction.
    width
        d, the relative rate of rotation below which friction is a damper, in rad/time: it sets the width of the regularisation.
    """

    rate = "angular_velocity"

    level: Annotated[NotNegative, Quantity("torque")]
    width: Annotated[Positive, Quantity("angle/time")]


class SlidingFriction(Friction):
    """Base of friction against the sliding of the point of body a along an axis fixed in body b.

    Attributes
    ----------
    level
        F, the force of friction, such as mu N.
    width
        d, the relative velocity below which friction is a damper: it sets the width of the regularisation.
    """

    rate = "velocity"
