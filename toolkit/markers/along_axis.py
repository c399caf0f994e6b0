"""Base of joints and loads along an axis in the plane."""

from __future__ import annotations

from typing import Annotated

from pydantic import field_validator

from toolkit.description.description import Description, Pair
from toolkit.description.quantity import Quantity


class AlongAxis(Description):
    """Base of components along an axis fixed in body b; the axis is given in the undeformed configuration.

    Attributes
    ----------
    axis
        Direction of the axis in the undeformed configuration, of any length.
    """

    axis: Annotated[Pair, Quantity("none")] = (1.0, 0.0)

    @field_validator("axis")
    @classmethod
    def _not_zero(cls, axis: Pair) -> Pair:
        if axis == (0.0, 0.0):
            raise ValueError("an axis needs a direction, for example [1, 0]")
        return axis
