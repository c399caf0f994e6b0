"""A rise from zero to a height, over a time: base of kinds that differ in its shape."""

from __future__ import annotations

from abc import abstractmethod
from typing import Annotated, Any

import numpy as np

from toolkit.curves.curve import Curve
from toolkit.curves.shapes.rise import risen
from toolkit.description.description import Number, Positive
from toolkit.description.quantity import OF_OWNER, Quantity


class Rise(Curve):
    """f(t) = height s(u), u = (t - start) / duration on [0, 1], 0 before and the height after.

    Attributes
    ----------
    height
        Value after the rise.
    start
        Time at which it begins.
    duration
        Time that it takes.
    """

    height: Annotated[Number, OF_OWNER] = 1.0
    start: Annotated[Number, Quantity("time")] = 0.0
    duration: Annotated[Positive, Quantity("time")] = 1.0

    @staticmethod
    @abstractmethod
    def shape(u: np.ndarray) -> tuple[Any, Any, Any]:
        """Shape s of the rise with s', s'' at u, one of the formulas of `rise`."""

    def rates(self, time: np.ndarray) -> tuple[Any, Any, Any]:
        """f, f', f'' at the times: the height times s and its derivatives by time."""
        s, slope, curvature = risen(time, self.start, self.duration, self.shape)
        return self.height * s, self.height * slope, self.height * curvature

    def corners(self) -> tuple[Any, ...]:
        """Times of the start and the end of the rise, where a derivative jumps."""
        return self.start, self.start + self.duration
