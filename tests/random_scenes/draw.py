"""Drawing of numbers and choices, the same on every machine: rounded, so that the last digit of a logarithm decides nothing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np

from toolkit.components.curves.combined import Sum
from toolkit.components.curves.oscillation import Sine
from toolkit.components.curves.polynomial import Constant
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.curves.table import Table

T = TypeVar("T")


def rounded(value: float, digits: int = 4) -> float:
    """The number with so many decimal digits."""
    return float(f"{value:.{digits}g}")


class Draw:
    """Random numbers of one scene."""

    def __init__(self, seed: int) -> None:
        self.generator = np.random.default_rng([seed, 20261122])

    def between(self, low: float, high: float) -> float:
        """Uniform."""
        return rounded(self.generator.uniform(low, high))

    def about(self, low: float, high: float) -> float:
        """Uniform in the logarithm."""
        return rounded(float(np.exp(self.generator.uniform(np.log(low), np.log(high)))))

    def chance(self, probability: float) -> bool:
        """True so often."""
        return bool(self.generator.uniform() < probability)

    def count(self, low: int, high: int) -> int:
        """An integer from low to high, both included."""
        return int(self.generator.integers(low, high + 1))

    def one(self, items: Sequence[T]) -> T:
        """One of them."""
        return items[self.count(0, len(items) - 1)]

    def some(self, items: Sequence[T], most: int) -> list[T]:
        """At most so many different ones, in their order."""
        chosen = self.generator.choice(len(items), size=min(most, len(items)), replace=False)
        return [items[k] for k in sorted(map(int, chosen))]

    def vector(self, size: float, dimension: int) -> tuple[Any, ...]:
        """A direction at random, about as long as `size`."""
        return tuple(rounded(size * each) for each in self.generator.normal(size=dimension) / np.sqrt(dimension))

    def load_curve(self, period: float) -> Any:
        """Any kind of time curve, of order one and as fast as the motion."""
        kinds = [
            Constant(value=self.between(0.3, 1.0)),
            SmoothStep(height=self.between(0.5, 1.2), duration=self.about(0.2 * period, 2 * period)),
            Sine(
                amplitude=self.between(0.4, 1.0), frequency=self.about(0.3 / period, 2.0 / period), phase=self.between(0.0, 3.0)
            ),
            Table(times=self._times(period), values=self._values(), interpolation=self.one(("cubic", "linear"))),
        ]
        return Sum(terms=tuple(self.some(kinds, 2))) if self.chance(0.15) else self.one(kinds)

    def driver_curve(self, size: float, period: float) -> Any:
        """A smooth curve of about this size that is zero at time 0."""
        step = SmoothStep(height=self.one((1, -1)) * self.about(0.3 * size, size), duration=self.about(0.5 * period, 3 * period))
        sine = Sine(amplitude=self.about(0.1 * size, 0.5 * size), frequency=self.about(0.2 / period, 1.5 / period))
        table = Table(times=self._times(period), values=(0.0, *(rounded(0.7 * size * each) for each in self._values()[1:])))
        return Sum(terms=(step, sine)) if self.chance(0.2) else self.one((step, sine, table))

    def _times(self, period: float) -> tuple[float, ...]:
        lengths = [self.about(0.3 * period, 1.5 * period) for _ in range(3)]
        return (0.0, *(rounded(sum(lengths[: k + 1])) for k in range(3)))

    def _values(self) -> tuple[float, ...]:
        return tuple(self.between(-1.0, 1.0) for _ in range(4))
