"""A study as a nonlinear program: minimise F(z) where all c(z) >= 0, in variables and values scaled to the size of one.

    z = (x - least) / scale,   F = sign * sum over cases / F_0,   c = (value - above) / size  or  (below - value) / size

Signs and units are put back where prices are told, in `prices`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from toolkit.studies.engine.outcome import DesignOutcome
from toolkit.studies.study.problem import Problem, by_case


class Row(NamedTuple):
    """One constraint: a limit of a response in one case."""

    response: str
    case: int
    sign: float
    limit: float
    size: float
    label: str
    """Response, with its case before it where cases have names."""


class Values(NamedTuple):
    """Objective and constraints of a design with their derivatives by z."""

    f: float
    df: np.ndarray
    c: np.ndarray
    dc: np.ndarray
    curvature: np.ndarray | None = None
    """Second derivative of the objective, (n, n), as far as the responses tell it; None if none does."""


@dataclass(frozen=True)
class Program:
    """The functions of a problem.

    Attributes
    ----------
    problem
        The checked study.
    unit
        F_0, what the objective is measured in.
    """

    problem: Problem
    unit: float = 1.0

    @property
    def rows(self) -> list[Row]:
        """All constraints, cases within limits within responses."""
        found = []
        for wanted in self.problem.limits:
            size = wanted.limit.scale or abs(wanted.bound) or 1.0
            labels = by_case(self.problem.cases, wanted.response)
            found += [Row(wanted.response, case, wanted.sign, wanted.bound, size, label) for case, label in enumerate(labels)]
        return found

    def scaled(self, design: np.ndarray) -> np.ndarray:
        """z of a design (n,)."""
        found: np.ndarray = (design - self.problem.bounds[0]) / self.problem.scales
        return found

    def design(self, z: np.ndarray) -> np.ndarray:
        """The design of a z (n,), within its bounds to the last bit."""
        low, high = self.problem.bounds
        return np.clip(low + z * self.problem.scales, low, high)

    @property
    def top(self) -> np.ndarray:
        """z of the largest values of all variables; that of the least is zero."""
        return self.scaled(self.problem.bounds[1])

    def objective(self, values: Any) -> tuple[Any, np.ndarray]:
        """The objective as the study states it, from values (cases, responses), and its derivatives by them, of the same shape."""
        wanted = self.problem.study.objective
        weights = np.array([self.problem.weights.get(name, 0.0) for name in self.problem.responses])
        each = values @ weights
        if wanted.over_cases == "sum":
            return np.sum(each), np.broadcast_to(weights, values.shape)
        sharp = wanted.sign * (wanted.aggregation or 1.0)
        peak = np.max(sharp * each.real)
        shares = np.exp(sharp * each - peak)
        total = np.sum(shares)
        return (peak + np.log(total)) / sharp, (shares / total)[:, None] * weights

    def values(self, found: DesignOutcome) -> Values:
        """F, c and their derivatives for a design that did not fail."""
        scales, study = self.problem.scales, self.problem.study
        value, weights = self.objective(found.values)
        slope = np.einsum("cr,crx->x", weights, found.gradients) * scales
        factor, places = study.objective.sign / self.unit, {name: k for k, name in enumerate(self.problem.responses)}
        rows = self.rows
        c = np.array([r.sign * (found.values[r.case, places[r.response]] - r.limit) / r.size for r in rows])
        dc = [r.sign * found.gradients[r.case, places[r.response]] * scales / r.size for r in rows]
        curved = factor * self._curvature(weights, found) if self.problem.curved else None
        return Values(factor * float(value), factor * slope, c, np.array(dc).reshape(len(rows), len(scales)), curved)

    def _curvature(self, weights: np.ndarray, found: DesignOutcome) -> np.ndarray:
        """Second derivative of the objective by z, for its derivatives by the responses (cases, responses)."""
        scales, places = self.problem.scales, [self.problem.responses.index(name) for name in self.problem.curved]
        total: np.ndarray = np.einsum("cr,crxy->xy", weights[:, places], found.curvatures)
        return total * np.outer(scales, scales)
