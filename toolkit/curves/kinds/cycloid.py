"""A cycloidal rise, as of cams."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from toolkit.curves.curve import Curve
from toolkit.curves.shapes.rise import cycloid, risen
from toolkit.description.description import Number, Positive
from toolkit.description.quantity import OF_OWNER, Quantity


class Cycloid(Curve):
    """f(t) = height (u - sin(2 pi u) / (2 pi)), u = (t - start) / duration on [0, 1], 0 before and the height after.

    f' and f'' are zero at both ends; the largest slope is twice the mean one, height / duration.

    Attributes
    ----------
    height
        Value after the rise.
    start
        Time at which it begins.
    duration
        Time that it takes.
    """

    kind = "cycloid"

    height: Annotated[Number, OF_OWNER] = 1.0
    start: Annotated[Number, Quantity("time")] = 0.0
    duration: Annotated[Positive, Quantity("time")] = 1.0

    def rates(self, time: np.ndarray) -> tuple[Any, Any, Any]:
        """The height times those of the rise."""
        s, slope, curvature = risen(time, self.start, self.duration, cycloid)
        return self.height * s, self.height * slope, self.height * curvature

    def corners(self) -> tuple[Any, ...]:
        """Times where the third derivative jumps."""
        return self.start, self.start + self.duration
