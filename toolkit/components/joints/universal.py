"""Universal joint: two crossed axes."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import model_validator

from toolkit.components.joints.joint import SpatialPointJoint
from toolkit.components.joints.rows import Row
from toolkit.components.markers.component import Skeleton
from toolkit.description.description import Quantity, Triple

LARGEST_COSINE = 1e-9
"""Largest cosine between axes that are perpendicular but for round-off of the input."""


class Universal(SpatialPointJoint):
    """r_a = r_b and e_1a . e_2b = 0: body a turns about the first axis, which is fixed in it, and that about the second, fixed in body b.

    Attributes
    ----------
    axes_of_cross
        Directions of the axis fixed in body a and of the one fixed in body b in the undeformed configuration, perpendicular to each other.
    """

    kind = "universal"
    symbol = "cross"

    axes_of_cross: Annotated[tuple[Triple, Triple], Quantity("none")]

    @model_validator(mode="after")
    def _crossed(self) -> Universal:
        first, second = (np.array(axis) for axis in self.axes_of_cross)
        if not (any(first) and any(second)):
            raise ValueError("both axes of a universal joint need a direction, for example [[1, 0, 0], [0, 1, 0]]")
        if abs(first @ second) > LARGEST_COSINE * np.sqrt((first @ first) * (second @ second)):
            raise ValueError("the axes of a universal joint are perpendicular to each other")
        return self

    @property
    def axes(self) -> np.ndarray:
        """Axes of the markers, (3, 3) as columns, the first two along those of the cross.

        What a step in one of them makes oblique is left oblique.
        """
        first, second = (np.array(axis) for axis in self.axes_of_cross)
        first, second = first / np.sqrt(first @ first), second / np.sqrt(second @ second)
        return np.column_stack([first, second, np.cross(first, second)])

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        """Rows of three directions and one rotation."""
        return (*self.poses.together, self.poses.perpendicular(1, 2, "about the normal of both axes"))
