"""Gravity in space."""

from __future__ import annotations

from typing import Annotated, ClassVar

from toolkit.description.description import Registered, Triple
from toolkit.description.quantity import Quantity


class SpatialGravity(Registered):
    """Acceleration of gravity on all bodies; it costs nothing where a scene has none.

    Attributes
    ----------
    acceleration
        g_x, g_y, g_z, in length/time^2.
    """

    kind = "gravity"
    dimension: ClassVar[int] = 3
    closed: ClassVar[bool] = True

    acceleration: Annotated[Triple, Quantity("length/time^2")]
