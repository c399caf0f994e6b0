"""Base of joints and loads about an axis in space."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import field_validator

from toolkit.description.description import Description, Triple
from toolkit.description.quantity import Quantity
from toolkit.kinematics.spatial import axes_along


class AboutAxis(Description):
    """Base of components about or along an axis; it is the third axis of both markers.

    Attributes
    ----------
    axis
        Direction of the axis in the undeformed configuration, of any length.
    """

    axis: Annotated[Triple, Quantity("none")]

    @field_validator("axis")
    @classmethod
    def _not_zero(cls, axis: Triple) -> Triple:
        if not any(axis):
            raise ValueError("an axis needs a direction, for example [0, 0, 1]")
        return axis

    @property
    def axes(self) -> np.ndarray:
        """Axes of the markers, (3, 3) as columns, the third one along the axis."""
        return axes_along(self.axis)
