"""Gravity: one uniform acceleration on every body."""

from __future__ import annotations

from typing import Annotated, ClassVar

from toolkit.components.loads.load import AnyPlanarLoad, AnySpatialLoad
from toolkit.description.description import Description, Number, Pair, Quantity, Triple


class UniformGravity(Description):
    """Acceleration of gravity on all bodies; part of the constant forces, so it costs nothing where a scene has none.

    Attributes
    ----------
    acceleration
        g_x, g_y, in space g_z, in length/time^2.
    """

    kind: ClassVar[str] = "gravity"
    proportional: ClassVar[tuple[str, ...]] = ("acceleration",)

    acceleration: Annotated[tuple[Number, ...], Quantity("length/time^2")]


class Gravity(UniformGravity, AnyPlanarLoad):
    __doc__ = UniformGravity.__doc__

    acceleration: Annotated[Pair, Quantity("length/time^2")]


class SpatialGravity(UniformGravity, AnySpatialLoad):
    __doc__ = UniformGravity.__doc__

    acceleration: Annotated[Triple, Quantity("length/time^2")]
