"""A ramp between two values and two times."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import model_validator

from toolkit.curves.curve import Curve
from toolkit.curves.shapes.rise import Shape, cubic, linear, quintic, risen
from toolkit.description.description import Number
from toolkit.description.quantity import OF_OWNER, Quantity

_SHAPES: dict[str, Shape] = {"linear": linear, "cubic": cubic, "quintic": quintic}


class Ramp(Curve):
    """f(t) = initial + (final - initial) s(u), u = (t - start) / (end - start) on [0, 1]; constant before and after.

    s = u (linear: the slope jumps at both ends, which a driver refuses), u^2 (3 - 2 u) (cubic: f'' jumps there), or
    u^3 (10 - 15 u + 6 u^2) (quintic: f'' is continuous). A derivative by the start or the end is the mean of both sides where a time step
    hits it exactly.

    Attributes
    ----------
    initial
        Value before the ramp.
    final
        Value after it.
    start
        Time at which it begins.
    end
        Time at which it ends.
    smoothness
        Between both.
    """

    kind = "ramp"

    initial: Annotated[Number, OF_OWNER] = 0.0
    final: Annotated[Number, OF_OWNER] = 1.0
    start: Annotated[Number, Quantity("time")] = 0.0
    end: Annotated[Number, Quantity("time")] = 1.0
    smoothness: Literal["linear", "cubic", "quintic"] = "quintic"

    @model_validator(mode="after")
    def _forwards(self) -> Self:
        if not np.real(self.end) > np.real(self.start):
            raise ValueError(
                f"end = {np.real(self.end):g} is not after start = {np.real(self.start):g}; times of a ramp increase, its values may fall"
            )
        return self

    def rates(self, time: np.ndarray) -> tuple[Any, Any, Any]:
        """f, f', f'' at the times of the ramp from the initial to the final value."""
        s, slope, curvature = risen(time, self.start, self.end - self.start, _SHAPES[self.smoothness])
        height = self.final - self.initial
        return self.initial + height * s, height * slope, height * curvature

    def corners(self) -> tuple[Any, ...]:
        """Start and end of the ramp: the slope jumps there, or the second or third derivative."""
        return self.start, self.end

    def kink(self) -> str:
        """Sentence on the kinks of a linear ramp, empty for smoother ones."""
        return "a linear ramp has none at its ends: use smoothness = 'cubic' or 'quintic'" if self.smoothness == "linear" else ""
