"""Responses at one time."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from functools import partial
from typing import Annotated, Any

import numpy as np

from toolkit.description.description import NotNegative
from toolkit.description.quantity import Quantity
from toolkit.description.time_grid import time_grid
from toolkit.foundation.errors import InputError
from toolkit.responses.response import STATES, Partials, Response
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
        """Whether a time is named, which a transient solution alone has; the end is also the time of a static solution."""
        return self.time is not None

    def check(self, scene: Any) -> None:
        """Refuse a time that is none of the steps.

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
        """Number of the step at `time` among the given times; errors as `step`."""
        if self.time is None:
            return len(times) - 1
        step = int(np.argmin(np.abs(times - self.time)))
        if abs(times[step] - self.time) > 1e-9 * max(times[-1], 1e-300):
            raise InputError(
                f"there is no time step at t = {self.time:g}; the nearest is {times[step]:g}. "
                "Choose a time that is a multiple of solver.step, or a step that divides it."
            )
        return step

    def instants(self, solution: Solution) -> Callable[[int], Partials]:
        """Function of the step that returns `at`; a kind with something to prepare for all steps does it here, once."""
        return partial(self.at, solution)

    def value(self, solution: Solution) -> Any:
        """Value of the response, evaluated at its own step alone."""
        return self.at(solution, self.step(solution)).value

    def evaluate(self, solution: Solution) -> tuple[Any, np.ndarray]:
        """Value of the response and its total design derivative, shape (n_x,), evaluated at its own step alone."""
        step = self.step(solution)
        found = self.at(solution, step)
        return found.value, slope_at(found, solution, step)

    def partials(self, solution: Solution) -> Partials:
        """Value and partial derivatives at the chosen step; the derivatives by all other states are zero."""
        weights = np.zeros(len(solution.times))
        weights[self.step(solution)] = 1
        return weighted(self.instants(solution), solution, weights)


def weighted(look: Callable[[int], Partials], solution: Solution, weights: np.ndarray) -> Partials:
    """Sum over time of weights (n_t,) times a quantity, which `look` gives for a step."""
    value: Any = 0.0
    arrays: dict[str, np.ndarray] = {}
    design = np.zeros(solution.system.n_x)
    for n in map(int, np.flatnonzero(weights)):
        part = look(n)
        value = value + weights[n] * part.value
        for name in STATES:
            slope = getattr(part, name)
            if slope is not None:
                if name not in arrays:
                    arrays[name] = np.zeros(getattr(solution, name).shape)
                arrays[name][n] += weights[n] * np.real(slope)
        if part.design is not None:
            design += weights[n] * np.real(part.design)
    return Partials(value, **arrays, design=design)


def slope_at(found: Partials, solution: Solution, step: int) -> np.ndarray:
    """Total design derivative (n_x,) of a quantity whose partial derivatives at a step are given."""
    total = np.zeros(solution.system.n_x) if found.design is None else np.real(found.design).astype(float)
    pairs = ((getattr(found, state), getattr(solution, f"d{state}")) for state in STATES)
    known = ((partial, derivative) for partial, derivative in pairs if partial is not None and derivative.shape[-1])
    return total + sum(np.real(partial) @ derivative[step] for partial, derivative in known)


def magnitude(vector: np.ndarray, change: Callable[[], np.ndarray]) -> tuple[Any, np.ndarray]:
    """Length of a vector, and the vector's direction; `change` gives the vector's total design derivative, (2, n_x).

    A vector that is zero and stays zero has a length that stays zero: its direction counts as zero. If it is zero but would change,
    the length has a kink and the direction is nan.
    """
    length = np.sqrt(vector @ vector)
    if length.real != 0:
        return length, vector / length
    return length, np.full(len(vector), np.nan if np.any(change()) else 0.0)
