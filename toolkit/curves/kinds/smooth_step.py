"""A smooth step of a polynomial."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from toolkit.curves.curve import Curve
from toolkit.curves.shapes.rise import quintic, risen
from toolkit.description.description import Number, Positive
from toolkit.description.quantity import OF_OWNER, Quantity


class SmoothStep(Curve):
    """f(t) = height s(u), u = (t - start) / duration, s = u^3 (10 - 15 u + 6 u^2) on [0, 1], 0 before and 1 after.

    Attributes
    ----------
    height
        Value after the step.
    start
        Time at which it begins.
    duration
        Time that it takes.
    """

    kind = "smooth-step"

    height: Annotated[Number, OF_OWNER] = 1.0
    start: Annotated[Number, Quantity("time")] = 0.0
    duration: Annotated[Positive, Quantity("time")] = 1.0

    def rates(self, time: np.ndarray) -> tuple[Any, Any, Any]:
        """The height times those of s."""
        s, slope, curvature = risen(time, self.start, self.duration, quintic)
        return self.height * s, self.height * slope, self.height * curvature

    def corners(self) -> tuple[Any, ...]:
        """Times where the third derivative jumps."""
        return self.start, self.start + self.duration
