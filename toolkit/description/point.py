"""Points: the skeleton of a scene, in the undeformed global configuration."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from toolkit.description.description import Description, Number
from toolkit.description.quantity import Quantity


class Point(Description):
    """A point given by its coordinates.

    Attributes
    ----------
    x
        Coordinate in the undeformed global configuration, in units of length.
    y
        Likewise.
    z
        Likewise, of a spatial scene alone.
    """

    x: Annotated[Number, Quantity("length")]
    y: Annotated[Number, Quantity("length")]
    z: Annotated[Number | None, Quantity("length")] = None

    def position(self) -> np.ndarray:
        """Coordinates of the point, shape (2,) or (3,)."""
        return np.array([self.x, self.y] if self.z is None else [self.x, self.y, self.z])


class BodyPoint(Description):
    """An interface point of a flexible body; `arc_length` moves it along the body, within the element it was made for.

    Attributes
    ----------
    body
        Name of the flexible body.
    interface
        Name of the interface point in the body's reduced model; "(frame)" is the origin of the body's frame, which does not deform.
    arc_length
        Place along the body, in units of length from its start; by default where preprocessing put the point.
    """

    body: str
    interface: str
    arc_length: Annotated[Number | None, Quantity("length")] = None
