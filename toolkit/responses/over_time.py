"""Base of responses over time, one number of what another response is at each time; and integral, mean and mean square."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import field_validator

from toolkit.foundation.errors import InputError
from toolkit.foundation.itself import Itself
from toolkit.foundation.units import LABELLED, Dimension, unit
from toolkit.responses.response import Instant, MeanSquare, Partials, Response, slope_at, weighted
from toolkit.system.solution import Solution

if TYPE_CHECKING:
    from toolkit.foundation.value_types import Scalar, TomlTable
    from toolkit.scene.resolution import ResolvedScene


class OverTime(Response):
    """Base of responses that reduce another response, their `source`, over time to one number."""

    @property
    @abstractmethod
    def source(self) -> Instant:
        """Response at one time that is reduced over time."""

    @property
    def needs_motion(self) -> bool:
        """Whether the response exists for a transient solution only: always true of responses over time."""
        return True

    def check(self, scene: ResolvedScene) -> None:
        """Refuse what the underlying quantity refuses."""
        self.source.check(scene)

    def grips(self, scene: ResolvedScene) -> tuple[tuple[str, str], ...]:
        """Pairs of body and point that the underlying quantity refers to."""
        return self.source.grips(scene)

    @property
    def physical_dimension(self) -> Dimension:
        """Physical dimension of the underlying quantity."""
        return self.source.physical_dimension

    @property
    def unit_quantity(self) -> str:
        """Name of the underlying quantity's unit where this response has the same dimension, otherwise "none"."""
        return self.source.unit_quantity if self.physical_dimension == self.source.physical_dimension else "none"

    def unit(self, system_of_units: str) -> str:
        """Unit of the underlying quantity in a system of units."""
        return self.source.unit(system_of_units)

    @abstractmethod
    def reduced(self, values: np.ndarray, shares: np.ndarray) -> tuple[Scalar, np.ndarray]:
        """Value from the quantity's values (n_t,) at some steps, and its derivatives by them (n_t,).

        `shares` (n_t,) are the parts of the whole run's duration that the steps stand for, by the trapezoidal rule; over all steps their
        sum is one.
        """

    def combined(self, values: np.ndarray) -> tuple[Scalar, np.ndarray]:
        """Value of the whole run from those of its windows (m,), and its derivatives by them (m,)."""
        return values.sum(), np.ones(len(values))

    def of_size(self, size: float, _duration: float) -> float:
        """Magnitude of the value where that of the quantity is `size`."""
        return size

    def of_slopes(self, _size: float, slopes: np.ndarray, _duration: float) -> np.ndarray:
        """Magnitudes (n_x,) of the value's derivatives where those of the quantity are `slopes`."""
        return slopes

    def partials(self, solution: Solution) -> Partials:
        """Value and partial derivatives: those of the quantity at all steps, weighted by the derivatives of `reduced`.

        Raises
        ------
        InputError
            The solution is static.
        """
        look, shares = self.source.instants(solution), time_shares(solution)
        parts = [look(step) for step in range(len(solution.times))]
        values = solution.known[over_all_steps, Itself(self.source)] = np.array([part.value for part in parts])
        value, weights = self.reduced(values, shares)
        return weighted(parts.__getitem__, solution, np.real(weights))._replace(value=value)


class OfTable(OverTime):
    """Base of responses over time whose quantity is given by a table.

    Attributes
    ----------
    of
        Table of a response at one time, with its `type` and keys.
    """

    of: Any

    @property
    def source(self) -> Instant:
        """Response at one time that the table `of` describes."""
        found: Instant = self.of
        return found

    @field_validator("of")
    @classmethod
    def _instant(cls, value: Instant | TomlTable) -> Instant:
        if isinstance(value, Instant):
            return _over_all_times(value)
        kind = value.get("type") if isinstance(value, dict) else None
        if not isinstance(kind, str) or kind not in Instant.kinds:
            raise ValueError(f"`of` needs a table with a `type`, one of: {', '.join(sorted(Instant.kinds))}")
        found = Instant.kinds[kind](**{key: item for key, item in value.items() if key != "type"})
        assert isinstance(found, Instant)
        return _over_all_times(found)


def _over_all_times(quantity: Instant) -> Instant:
    if quantity.time is not None:
        raise ValueError("a response over time looks at all times; leave `time` out of `of`")
    return quantity


def over_all_steps(quantity: Instant, solution: Solution) -> np.ndarray:
    """Values of a quantity at all steps (n_t,), evaluated once."""
    key = over_all_steps, Itself(quantity)
    if key not in solution.known:
        look = quantity.instants(solution)
        solution.known[key] = np.array([look(step).value for step in range(len(solution.times))])
    found: np.ndarray = solution.known[key]
    return found


def time_shares(solution: Solution) -> np.ndarray:
    """Parts of the run's duration that the solution's steps stand for, by the trapezoidal rule, (n_t,).

    Raises
    ------
    InputError
        The solution is static.
    """
    whole = solution.whole_run
    if len(whole) < 2:
        raise InputError("a response over time needs a transient solution. Use `simulate`, or another response.")
    h, first = np.diff(whole), int(np.searchsorted(whole, solution.times[0]))
    weights = (np.append(h, 0) + np.append(0, h)) / 2
    found: np.ndarray = weights[first : first + len(solution.times)] / (whole[-1] - whole[0])
    return found


class Integral(OverTime):
    """Base of integrals over time, by the trapezoidal rule."""

    @property
    def physical_dimension(self) -> Dimension:
        """Physical dimension of the quantity times time."""
        return self.source.physical_dimension.times(LABELLED["time"])

    def unit(self, system_of_units: str) -> str:
        """Unit of the quantity times time."""
        return f"{self.source.unit(system_of_units)} {unit(system_of_units, 'time')}".lstrip()

    def reduced(self, values: np.ndarray, shares: np.ndarray) -> tuple[Scalar, np.ndarray]:
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

    def reduced(self, values: np.ndarray, shares: np.ndarray) -> tuple[Scalar, np.ndarray]:
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

    def reduced(self, values: np.ndarray, shares: np.ndarray) -> tuple[Scalar, np.ndarray]:
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
