"""Responses at one time, and their integral over time."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Annotated, Any

import numpy as np
from pydantic import field_validator

from toolkit.description.description import NotNegative
from toolkit.description.quantity import Quantity
from toolkit.description.time_grid import time_grid
from toolkit.foundation.dimensions import LABELLED, Dimension
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import unit
from toolkit.responses.response import Partials, Response
from toolkit.system.solution import Solution


class Instant(Response):
    """A quantity of the state at one time: the end, unless `time` names another step.

    Attributes
    ----------
    time
        When; one of the time steps, by default the end.
    """

    time: Annotated[NotNegative | None, Quantity("time")] = None

    @property
    def needs_motion(self) -> bool:
        """At a time of its own; the end is also the time of a static solution."""
        return self.time is not None

    def check(self, scene: Any) -> None:
        """The time is one of the steps.

        Raises
        ------
        InputError
            There is no step at that time; names the nearest.
        """
        options = scene.solver
        hit = self.time is not None and options.local_error is not None  # a run that chooses its steps hits the time
        self.nearest(np.array([0.0, min(self.time or 0.0, options.end_time), options.end_time]) if hit else time_grid(options))

    @abstractmethod
    def at(self, solution: Solution, step: int) -> Partials:
        """Value and partial derivatives at one step; q, v (n_q,), multipliers (n_lam,), design (n_x,)."""

    def step(self, solution: Solution) -> int:
        """Number of the step at `time`.

        Raises
        ------
        InputError
            There is no step at that time; names the nearest.
        """
        return self.nearest(solution.times)

    def nearest(self, times: np.ndarray) -> int:
        """Number of the step at `time` among times; errors as `step`."""
        if self.time is None:
            return len(times) - 1
        step = int(np.argmin(np.abs(times - self.time)))
        if abs(times[step] - self.time) > 1e-9 * max(times[-1], 1e-300):
            raise InputError(
                f"there is no time step at t = {self.time:g}; the nearest is {times[step]:g}. "
                "Choose a time that is a multiple of solver.step, or a step that divides it."
            )
        return step

    def partials(self, solution: Solution) -> Partials:
        """Those of the one step, zero at all others."""
        weights = np.zeros(len(solution.times))
        weights[self.step(solution)] = 1
        return weighted(self, solution, weights)


def weighted(instant: Instant, solution: Solution, weights: np.ndarray) -> Partials:
    """Sum over time of weights (n_t,) times the quantity."""
    parts = [(n, instant.at(solution, n)) for n in map(int, np.flatnonzero(weights))]
    value: Any = sum(weights[n] * part.value for n, part in parts)
    widths = {"q": solution.q.shape, "v": solution.v.shape, "multipliers": solution.multipliers.shape}
    arrays: dict[str, Any] = {name: np.zeros(shape) for name, shape in widths.items()}
    design = np.zeros(solution.system.n_x)
    for n, part in parts:
        for name, array in arrays.items():
            partial = getattr(part, name)
            if partial is not None:
                array[n] += weights[n] * np.real(partial)
        if part.design is not None:
            design += weights[n] * np.real(part.design)
    return Partials(value, **arrays, design=design)


def magnitude(vector: np.ndarray, change: Callable[[], np.ndarray]) -> tuple[Any, np.ndarray]:
    """Length of a vector, and the vector's direction; `change` gives the vector's total design derivative, (2, n_x).

    A vector that is zero and stays zero has a length that stays zero: its direction counts as zero. If it is zero but would change,
    the length has a kink and the direction is nan.
    """
    length = np.sqrt(vector @ vector)
    if length.real != 0:
        return length, vector / length
    return length, np.full(len(vector), np.nan if np.any(change()) else 0.0)


class TimeIntegral(Response):
    """Integral over time of a quantity, by the trapezoidal rule (second order, as the default scheme); `of` is its table.

    Attributes
    ----------
    of
        Table of a response at one time, with its `type` and keys.
    """

    kind = "time-integral"
    of: Any

    @property
    def needs_motion(self) -> bool:
        """Always."""
        return True

    @field_validator("of")
    @classmethod
    def _instant(cls, value: Any) -> Instant:
        if isinstance(value, Instant):
            return cls._over_all_times(value)
        kind = value.get("type") if isinstance(value, dict) else None
        if not isinstance(kind, str) or kind not in Instant.kinds:
            raise ValueError(f"`of` needs a table with a `type`, one of: {', '.join(Instant.kinds)}")
        found = Instant.kinds[kind](**{key: item for key, item in value.items() if key != "type"})
        assert isinstance(found, Instant)
        return cls._over_all_times(found)

    @staticmethod
    def _over_all_times(quantity: Instant) -> Instant:
        if quantity.time is not None:
            raise ValueError("an integral runs over all times; leave `time` out of `of`")
        return quantity

    def check(self, scene: Any) -> None:
        """The quantity's own."""
        self.of.check(scene)

    def markers(self) -> tuple[tuple[str, str], ...]:
        """Those of the quantity."""
        return self.of.markers()

    @property
    def physical_dimension(self) -> Dimension:
        """That of the quantity times time."""
        return self.of.physical_dimension.times(LABELLED["time"])

    def unit(self, system_of_units: str) -> str:
        """Unit of the quantity times time."""
        return f"{self.of.unit(system_of_units)} {unit(system_of_units, 'time')}"

    def partials(self, solution: Solution) -> Partials:
        """The quantity's, with trapezoidal weights.

        Raises
        ------
        InputError
            The solution is static.
        """
        whole = solution.whole_run
        if len(whole) < 2:
            raise InputError("an integral over time needs a transient solution. Use `simulate`, or another response.")
        h, first = np.diff(whole), int(np.searchsorted(whole, solution.times[0]))
        weights = (np.append(h, 0) + np.append(0, h)) / 2
        return weighted(self.of, solution, weights[first : first + len(solution.times)])
