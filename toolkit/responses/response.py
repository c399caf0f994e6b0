"""Base of all responses: a number of a solution, with its partial derivatives by the states and by the design."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar, NamedTuple

import numpy as np

from toolkit.description.description import Registered
from toolkit.foundation.dimensions import LABELLED, Dimension
from toolkit.foundation.units import unit
from toolkit.system.solution import Solution


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

    def grips(self, _scene: Any) -> tuple[tuple[str, str], ...]:
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

    def check(self, scene: Any) -> None:
        """Refuse, before anything runs, what this response cannot be asked of the scene; names are checked by the scene itself."""

    def value(self, solution: Solution) -> Any:
        """Value of the response."""
        return self.partials(solution).value

    def gradient(self, solution: Solution) -> np.ndarray:
        """Total design derivative, shape (n_x,)."""
        return self.evaluate(solution)[1]

    def evaluate(self, solution: Solution) -> tuple[Any, np.ndarray]:
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
