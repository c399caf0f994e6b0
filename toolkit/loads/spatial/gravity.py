"""Gravity in space."""

from __future__ import annotations

from typing import Annotated

from toolkit.description.description import Triple
from toolkit.description.quantity import Quantity
from toolkit.loads.gravity import UniformGravity
from toolkit.loads.spatial.load import AnySpatialLoad


class SpatialGravity(UniformGravity, AnySpatialLoad):
    """Acceleration of gravity on all bodies; it costs nothing where a scene has none.

    Attributes
    ----------
    acceleration
        g_x, g_y, g_z, in length/time^2.
    """

    kind = "gravity"

    acceleration: Annotated[Triple, Quantity("length/time^2")]
