"""Gravity in the plane."""

from __future__ import annotations

from typing import Annotated

from toolkit.description.description import Pair
from toolkit.description.quantity import Quantity
from toolkit.loads.gravity import UniformGravity
from toolkit.loads.planar.load import AnyPlanarLoad


class Gravity(UniformGravity, AnyPlanarLoad):
    """Acceleration of gravity on all bodies; part of the constant forces, so it costs nothing where a scene has none.

    Attributes
    ----------
    acceleration
        g_x, g_y, in length/time^2.
    """

    kind = "gravity"

    acceleration: Annotated[Pair, Quantity("length/time^2")]
