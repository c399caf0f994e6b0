"""Base of all responses: a number of a solution, with its partial derivatives by the states and by the design."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple, Self

import numpy as np
from pydantic import model_validator

from toolkit.description.description import NotNegative, Quantity, Registered
from toolkit.description.run_options import time_grid
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import LABELLED, Dimension, unit
from toolkit.system.solution import Solution

if TYPE_CHECKING:
    from toolkit.foundation.value_types import Scalar
    from toolkit.scene.resolution import ResolvedScene


class Partials(NamedTuple):
    """A response's value and its partial derivatives; None stands for zero. With the states' design derivatives

        dvalue = sum over time (value_q . dq + value_v . dv + value_a . da + value_lam . dlam) + value_x

    An undefined derivative is nan.
    """

    value: Any
    q: np.ndarray | None = None  # (n_t, n_q)
    v: np.ndarray | None = None  # (n_t, n_q)
    multipliers: np.ndarray | None = None  # (n_t, n_lam)
    design: np.ndarray | None = None  # (n_x,)
    a: np.ndarray | None = None  # (n_t, n_q)


STATES = ("q", "v", "a", "multipliers")
"""States that a value can depend on, by the names in `Partials` and in a solution."""


class Response(Registered):
    """Base of all responses; a new one is one subclass with `partials`."""

    quantity: ClassVar[str] = "none"
    """Name of the quantity, for its unit: a key of `toolkit.foundation.units`."""

    @property
    def needs_motion(self) -> bool:
        """Whether it exists for a transient solution only; a static analysis leaves it out."""
        return False

    @property
    def needs_rest(self) -> bool:
        """Whether it exists for an equilibrium only; a transient analysis leaves it out."""
        return False

    @abstractmethod
    def partials(self, solution: Solution) -> Partials:
        """Value and partial derivatives; complex-safe in the value."""

    def markers(self) -> tuple[tuple[str, str], ...]:
        """Pairs (body, point) that the response refers to, so that the compilation provides them."""
        return ()

    def grips(self, _scene: ResolvedScene) -> tuple[tuple[str, str], ...]:
        """Pairs (body, point) that the response refers to in a scene, where they depend on it."""
        return self.markers()

    @property
    def unit_quantity(self) -> str:
        """Name of the quantity for its unit, where it depends on the response's options."""
        return self.quantity

    @property
    def physical_dimension(self) -> Dimension:
        """Physical dimension of the value."""
        return LABELLED[self.unit_quantity]

    def unit(self, system_of_units: str) -> str:
        """Label of the unit in a system of units."""
        return unit(system_of_units, self.unit_quantity)

    def check(self, scene: ResolvedScene) -> None:
        """Refuse, before anything runs, what this response cannot be asked of the scene; names are checked by the scene itself."""

    def value(self, solution: Solution) -> Scalar:
        """Value of the response."""
        return self.partials(solution).value

    def gradient(self, solution: Solution) -> np.ndarray:
        """Total design derivative, shape (n_x,)."""
        return self.evaluate(solution)[1]

    def evaluate(self, solution: Solution) -> tuple[Scalar, np.ndarray]:
        """Value of the response and its total design derivative, shape (n_x,)."""
        partials = self.partials(solution)
        total = np.zeros(solution.system.n_x) if partials.design is None else partials.design.astype(float)
        for state in STATES:
            partial, derivative = getattr(partials, state), getattr(solution, f"d{state}")
            if partial is not None and derivative.shape[-1]:
                felt = felt_steps(partial)
                total = total + np.einsum("ti,tix->x", np.real(partial[felt]), derivative[felt])
        return partials.value, total


class MeanSquare(Response):
    """Base of weighted sums of squares of other numbers r_k of a solution."""

    @abstractmethod
    def curvature(self, solution: Solution) -> np.ndarray:
        """Gauss-Newton Hessian: second derivative by the design without the curvature of r_k, (n_x, n_x).

            f = sum of w_k r_k^2,   H = 2 sum of w_k dr_k dr_k^T

        What is left out is the curvature of r_k times r_k: nothing where they are small, or where the design moves them linearly.
        """


def felt_steps(partial: np.ndarray) -> np.ndarray | slice:
    """Steps at which a derivative (n_t, n) is not zero, or all if these are most."""
    felt = np.flatnonzero(partial.any(axis=1))
    return felt if 2 * len(felt) < len(partial) else slice(None)


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

    def check(self, scene: ResolvedScene) -> None:
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

    def value(self, solution: Solution) -> Scalar:
        """Value of the response, evaluated at its own step alone."""
        return self.at(solution, self.step(solution)).value

    def evaluate(self, solution: Solution) -> tuple[Scalar, np.ndarray]:
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


def magnitude(vector: np.ndarray, change: Callable[[], np.ndarray]) -> tuple[Scalar, np.ndarray]:
    """Length of a vector, and the vector's direction; `change` gives the vector's total design derivative, (2, n_x).

    A vector that is zero and stays zero has a length that stays zero: its direction counts as zero. If it is zero but would change,
    the length has a kink and the direction is nan.
    """
    length = np.sqrt(vector @ vector)
    if length.real != 0:
        return length, vector / length
    return length, np.full(len(vector), np.nan if np.any(change()) else 0.0)


class OnePoint(Instant):
    """Base of responses that refer to one point of a body.

    Attributes
    ----------
    body
        Name of the body.
    point
        Name of the point on it.
    """

    body: str
    point: str

    @model_validator(mode="after")
    def _of_a_body(self) -> Self:
        if self.body == "ground":
            raise ValueError(f"the ground does not move, so that it has no {self.kind}; name a body that moves")
        return self

    def markers(self) -> tuple[tuple[str, str], ...]:
        """Pair of body and point."""
        return ((self.body, self.point),)


def refuse_axis(axis: Sequence[float] | None, scene: ResolvedScene, angle: str) -> None:
    """Refuse an axis in the plane, and an angle without one in space; `angle` is its name in words.

    Raises
    ------
    InputError
        The axis is missing, has no direction, or is one too many.
    """
    if scene.space.rotations_add != (axis is None) or (axis is not None and not any(axis)):
        raise InputError(
            f"a {angle} in space needs an `axis` with a direction, for example [0, 0, 1]; one in the plane has none."
        )
