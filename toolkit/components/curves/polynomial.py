"""Polynomials of time, and the constant."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from toolkit.components.curves.curve import Curve, Rates
from toolkit.description.description import OF_OWNER, OF_OWNER_PER_TIME, Number, Quantity, Scalar


class Constant(Curve):
    """f(t) = value.

    Attributes
    ----------
    value
        Value at all times.
    """

    kind = "constant"

    value: Annotated[Number, OF_OWNER] = 1.0

    def rates(self, _time: np.ndarray) -> Rates:
        """Value of the curve, with derivatives f' and f'' that are zero."""
        return self.value, 0.0, 0.0

    @property
    def is_constant(self) -> bool:
        """Whether the curve has one value at all times: always."""
        return True


class Polynomial(Curve):
    """f(t) = c_0 + c_1 (t - start) + c_2 (t - start)^2 + ..., at all times; a sequence cuts it off.

    Attributes
    ----------
    coefficients
        c_0, c_1, ...: each is the value's per time to the power of its place.
    start
        Time that it is developed about.
    """

    kind = "polynomial"

    coefficients: Annotated[tuple[Number, ...], OF_OWNER_PER_TIME] = Field(min_length=1)
    start: Annotated[Number, Quantity("time")] = 0.0

    def rates(self, time: np.ndarray) -> Rates:
        """f, f', f'' at the times, by Horner's rule."""
        t: np.ndarray | Scalar = time - self.start
        f, slope, half = 0 * t, 0 * t, 0 * t
        for coefficient in reversed(self.coefficients):
            half = half * t + slope
            slope = slope * t + f
            f = f * t + coefficient
        return f, slope, 2 * half

    @property
    def is_constant(self) -> bool:
        """Whether the polynomial has one coefficient alone."""
        return len(self.coefficients) == 1
