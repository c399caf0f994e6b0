"""Integral, mean and mean square over time, by the trapezoidal rule: second order, as the default scheme."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.foundation.dimensions import LABELLED, Dimension
from toolkit.foundation.units import unit
from toolkit.responses.instant import slope_at, weighted
from toolkit.responses.over_time.over_time import OfTable, OverTime, time_shares
from toolkit.responses.response import MeanSquare, Partials
from toolkit.system.solution import Solution


class Integral(OverTime):
    """Base of integrals over time, by the trapezoidal rule."""

    @property
    def physical_dimension(self) -> Dimension:
        """Physical dimension of the quantity times time."""
        return self.source.physical_dimension.times(LABELLED["time"])

    def unit(self, system_of_units: str) -> str:
        """Unit of the quantity times time."""
        return f"{self.source.unit(system_of_units)} {unit(system_of_units, 'time')}".lstrip()

    def reduced(self, values: np.ndarray, shares: np.ndarray) -> tuple[Any, np.ndarray]:
        """Weighted sum of the values for a duration of one, and its derivatives by them."""
        return shares @ values, shares

    def of_size(self, size: float, duration: float) -> float:
        """Magnitude of the integral where the quantity's magnitude is `size`: that times the duration."""
        return size * duration

    def of_slopes(self, _size: float, slopes: np.ndarray, duration: float) -> np.ndarray:
        """Magnitudes (n_x,) of the integral's derivatives where those of the quantity are `slopes`: these times the duration."""
        return slopes * duration

    def partials(self, solution: Solution) -> Partials:
        """Integral and its partial derivatives: the quantity's own with trapezoidal weights; errors as `OverTime.partials`."""
        shares, whole = time_shares(solution), solution.whole_run
        return weighted(self.source.instants(solution), solution, shares * (whole[-1] - whole[0]))


class TimeIntegral(Integral, OfTable):
    """Integral over time of a quantity, by the trapezoidal rule (second order, as the default scheme); `of` is its table."""

    kind = "time-integral"


class TimeMean(OfTable):
    """Mean over time of a quantity: its integral by the trapezoidal rule over the duration of the run; `of` is its table."""

    kind = "time-mean"

    def reduced(self, values: np.ndarray, shares: np.ndarray) -> tuple[Any, np.ndarray]:
        """Weighted sum of the values, and its derivatives by them: the weights."""
        return shares @ values, shares

    def partials(self, solution: Solution) -> Partials:
        """Mean and its partial derivatives: the quantity's own with trapezoidal weights; errors as `OverTime.partials`."""
        return weighted(self.source.instants(solution), solution, time_shares(solution))


class TimeMeanSquare(OfTable, MeanSquare):
    """Mean over time of a quantity's square, by the trapezoidal rule; smooth also where the quantity is zero. `of` is its table."""

    kind = "time-mean-square"

    @property
    def physical_dimension(self) -> Dimension:
        """Physical dimension of the quantity's square."""
        return self.source.physical_dimension.power(2)

    def unit(self, system_of_units: str) -> str:
        """Unit of the quantity's square."""
        label = self.source.unit(system_of_units)
        return f"({label})^2" if set(label) & set(" /^") else label and f"{label}^2"

    def reduced(self, values: np.ndarray, shares: np.ndarray) -> tuple[Any, np.ndarray]:
        """Mean square as a weighted sum of squared values, and its derivatives by the values."""
        return shares @ (values * values), 2 * shares * values

    def curvature(self, solution: Solution) -> np.ndarray:
        """Gauss-Newton Hessian (n_x, n_x) from the quantity's derivatives at every time; errors as `OverTime.partials`."""
        look, shares = self.source.instants(solution), time_shares(solution)
        slopes = np.array([slope_at(look(step), solution, step) for step in range(len(shares))])
        return 2 * (slopes.T * shares) @ slopes

    def of_size(self, size: float, _duration: float) -> float:
        """Magnitude of the mean square where the quantity's magnitude is `size`: the square of that."""
        return size * size

    def of_slopes(self, size: float, slopes: np.ndarray, _duration: float) -> np.ndarray:
        """Magnitudes (n_x,) of the mean square's derivatives where those of the quantity are `slopes`."""
        return 2 * size * slopes
