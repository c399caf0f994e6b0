"""Loads and drivers along a path of equilibria, by its factor: loads that grow in proportion, or all that changes with time."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.equations.equations import Inputs
from toolkit.solvers.static.equilibrium import LEVELS, inputs_at, leading_curves
from toolkit.system.system import System


class Acting(Protocol):
    """Interface of what acts along a path of equilibria, by its factor.

    Everything is linear in the loads, and drivers enter the equations by their values alone.
    """

    def at(self, factor: float) -> Inputs:
        """Inputs of the equations at a factor."""

    def more(self, factor: float) -> Inputs:
        """Inputs with the same drivers, and with loads grown by their derivative by the factor."""

    def driven(self, factor: float) -> np.ndarray:
        """Derivatives d / d factor of the drivers' values, for all time curves (n_curves,)."""


class GrowingLoads:
    """Loads and gravity scaled by the factor, drivers and set values between their first and last value."""

    def __init__(self, system: System, options: RunOptions) -> None:
        self._none, self._full = (inputs_at(system, options, factor) for factor in (0.0, 1.0))
        self._growth = self._full.curves - self._none.curves
        self._leading = leading_curves(system)

    def at(self, factor: float) -> Inputs:
        """Inputs of the equations at a factor."""
        return self._none._replace(curves=self._none.curves + factor * self._growth, scale=float(factor))

    def more(self, factor: float) -> Inputs:
        """Inputs with all loads once more, by which they grow with the factor."""
        found = self.at(factor)
        curves = found.curves  # made for this one
        curves[self._leading] += self._growth[self._leading]
        return found._replace(scale=found.scale + 1.0)

    def driven(self, _factor: float) -> np.ndarray:
        """Derivatives of the drivers' values by the factor: their way from the first to the last value, (n_curves,)."""
        found: np.ndarray = np.real(self._growth)[:, 0]
        return found


class PassingTime:
    """Everything that changes with time, from one time (factor 0) to another (factor 1)."""

    def __init__(self, system: System, first: float, last: float) -> None:
        self._system, self._first, self._span = system, first, last - first
        self._drivers = np.zeros(len(self.at(0.0).curves), bool)
        self._drivers[[c for c in system.plan.joints.curve if c >= 0]] = True

    def at(self, factor: float) -> Inputs:
        """Inputs of the equations at a factor."""
        return self._system.inputs(self._first + factor * self._span, LEVELS)

    def more(self, factor: float) -> Inputs:
        """Inputs with loads grown by their derivative by the factor."""
        found = self.at(factor)
        growth = np.zeros_like(found.curves)
        growth[~self._drivers, 0] = self._span * found.curves[~self._drivers, 1]
        return found._replace(curves=found.curves + growth)

    def driven(self, factor: float) -> np.ndarray:
        """Derivatives of the drivers' values by the factor, (n_curves,)."""
        found: np.ndarray = np.real(self._span * self.at(factor).curves[:, 1])
        return found
