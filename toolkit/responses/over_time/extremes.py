"""Largest and smallest value over time, and the smooth maximum, of the values at the steps of a run."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np

from toolkit.description.description import Positive
from toolkit.description.quantity import OF_OWNER, Quantity
from toolkit.foundation.near_ties import SAME, first_largest
from toolkit.responses.over_time.over_time import OfTable
from toolkit.responses.stress.aggregation import kreisselmeier_steinhauser


class Extreme(OfTable):
    """Base of extremes over time.

    Attributes
    ----------
    of
        Table of a response at one time, with its `type` and keys.
    measure
        Signed: the value itself counts. Absolute: its magnitude.
    """

    measure: Literal["signed", "absolute"] = "signed"

    def of_slopes(self, _size: float, slopes: np.ndarray, _duration: float) -> np.ndarray:
        """Zeros: an extreme's derivative is that of one instant, and does not swing with the derivatives at the others."""
        return np.zeros_like(slopes)

    def considered(self, values: np.ndarray) -> np.ndarray:
        """Values that count (n_t,), or (2 n_t,) with the opposite sign too."""
        return np.concatenate([values, -values]) if self.measure == "absolute" else values

    def folded(self, weights: np.ndarray) -> np.ndarray:
        """Weights of the values (n_t,) from those of the considered ones."""
        half = len(weights) // 2
        return weights[:half] - weights[half:] if self.measure == "absolute" else weights


class TimeMax(Extreme):
    """Largest value of a quantity at the steps of a run; its derivative is that of the first step where it occurs. `of` is its table."""

    kind = "time-max"

    def reduced(self, values: np.ndarray, _shares: np.ndarray) -> tuple[Any, np.ndarray]:
        """Largest value of all steps, and its derivatives by the values: nonzero at the first step where it occurs."""
        value, weights = _first(self.considered(values))
        return value, self.folded(weights)

    def combined(self, values: np.ndarray) -> tuple[Any, np.ndarray]:
        """Largest of the windows' values, and its derivatives by them: one for the first largest window, else zero."""
        return _first(values)


class TimeMin(OfTable):
    """Smallest value of a quantity at the steps of a run; its derivative is that of the first step where it occurs. `of` is its table."""

    kind = "time-min"

    def of_slopes(self, _size: float, slopes: np.ndarray, _duration: float) -> np.ndarray:
        """Zeros: an extreme's derivative is that of one instant, and does not swing with the derivatives at the others."""
        return np.zeros_like(slopes)

    def reduced(self, values: np.ndarray, _shares: np.ndarray) -> tuple[Any, np.ndarray]:
        """Smallest value of all steps, and its derivatives by the values: nonzero at the first step where it occurs."""
        return self.combined(values)

    def combined(self, values: np.ndarray) -> tuple[Any, np.ndarray]:
        """Smallest of the windows' values, and its derivatives by them: one for the first smallest window, else zero."""
        value, weights = _first(-values)
        return -value, weights


class TimeKS(Extreme):
    """Smooth maximum (Kreisselmeier-Steinhauser) of a quantity at the steps of a run: at most ln(n) / aggregation above the largest of its
    n values, never below. It has no limit for ever smaller steps. `of` is its table.

    Attributes
    ----------
    of
        Table of a response at one time, with its `type` and keys.
    aggregation
        Parameter rho, in 1/unit of the quantity, or a pure number with `reference`.
    reference
        Value that all values are divided by first; the result is a value again.
    """

    kind = "time-ks"

    aggregation: Annotated[Positive, OF_OWNER]
    reference: Annotated[Positive | None, OF_OWNER] = None

    def quantity_of(self, field: str) -> Quantity | None:
        """Quantity of a field: the aggregation's depends on whether there is a reference, which has the quantity's own unit."""
        if field == "aggregation":
            return Quantity("none") if self.reference is not None else self._of_power(-1)
        return self._of_power(1) if field == "reference" else super().quantity_of(field)

    def _of_power(self, exponent: int) -> Quantity:
        words = [f"{name}^{power}" for name, power in self.source.physical_dimension.power(exponent)._asdict().items() if power]
        return Quantity(" ".join(words) or "none")

    @property
    def sharpness(self) -> float:
        """Aggregation parameter in 1/unit of the quantity."""
        return self.aggregation / (1.0 if self.reference is None else self.reference)

    def reduced(self, values: np.ndarray, _shares: np.ndarray) -> tuple[Any, np.ndarray]:
        """Smooth maximum of the values, and its derivatives by them: softmax weights."""
        value, weights = kreisselmeier_steinhauser(self.considered(values), self.sharpness)
        return value, self.folded(weights)

    def combined(self, values: np.ndarray) -> tuple[Any, np.ndarray]:
        """Smooth maximum of the windows' own smooth maxima, and its derivatives by them."""
        return kreisselmeier_steinhauser(values, self.sharpness)


def _first(values: np.ndarray) -> tuple[Any, np.ndarray]:
    """The largest value, of equal ones the first, and weight one at its place."""
    place = first_largest(np.real(values), SAME)
    return values[place], (np.arange(len(values)) == place).astype(float)
