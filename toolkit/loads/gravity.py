"""Gravity: one uniform acceleration on every body."""

from __future__ import annotations

from typing import Annotated

from toolkit.description.description import Number, Pair, Triple
from toolkit.description.quantity import Quantity
from toolkit.loads.load import AnyLoad, AnyPlanarLoad, AnySpatialLoad


class UniformGravity(AnyLoad):
    """Acceleration of gravity on all bodies; part of the constant forces, so it costs nothing where a scene has none.

    Attributes
    ----------
    acceleration
        g_x, g_y, in space g_z, in length/time^2.
    """

    proportional = ("acceleration",)

    acceleration: Annotated[tuple[Number, ...], Quantity("length/time^2")]


class Gravity(UniformGravity, AnyPlanarLoad):
    """Acceleration of gravity on all bodies; part of the constant forces, so it costs nothing where a scene has none.

    Attributes
    ----------
    acceleration
        g_x, g_y, in length/time^2.
    """

    kind = "gravity"

    acceleration: Annotated[Pair, Quantity("length/time^2")]


class SpatialGravity(UniformGravity, AnySpatialLoad):
    """Acceleration of gravity on all bodies; it costs nothing where a scene has none.

    Attributes
    ----------
    acceleration
        g_x, g_y, g_z, in length/time^2.
    """

    kind = "gravity"

    acceleration: Annotated[Triple, Quantity("length/time^2")]
