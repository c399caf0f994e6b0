"""The cubic through two points of a path and their directions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Cubic(NamedTuple):
    """z(p) with z(0), z'(0), z(length), z'(length) given, each (n,) (Hermite's interpolation); good a little beyond its ends too."""

    begin: np.ndarray
    begin_slope: np.ndarray
    end: np.ndarray
    end_slope: np.ndarray
    length: float

    def at(self, p: float) -> np.ndarray:
        """z(p)."""
        x = p / self.length
        values = (1 + 2 * x) * (1 - x) ** 2 * self.begin + x**2 * (3 - 2 * x) * self.end
        found: np.ndarray = values + self.length * x * (1 - x) * ((1 - x) * self.begin_slope - x * self.end_slope)
        return found

    def slope(self, p: float) -> np.ndarray:
        """z'(p)."""
        x = p / self.length
        found: np.ndarray = (
            6 * x * (1 - x) * (self.end - self.begin) / self.length
            + (1 - x) * (1 - 3 * x) * self.begin_slope
            + x * (3 * x - 2) * self.end_slope
        )
        return found
