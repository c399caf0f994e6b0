"""Gravity: one uniform acceleration on every body."""

from __future__ import annotations

from typing import Annotated, ClassVar

from toolkit.description.description import Pair, Registered
from toolkit.description.quantity import Quantity


class Gravity(Registered):
    """Acceleration of gravity on all bodies; part of the constant forces, so it costs nothing where a scene has none.

    Attributes
    ----------
    acceleration
        g_x, g_y, in length/time^2.
    """

    kind = "gravity"
    dimension: ClassVar[int] = 2

    acceleration: Annotated[Pair, Quantity("length/time^2")]
