"""Shadow prices of limits: multipliers in the units of the study."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from toolkit.studies.engine.outcome import DesignOutcome
from toolkit.studies.optimization.optimality import Optimality
from toolkit.studies.optimization.program import Program

LEAST = 1e-6
"""Multiplier, relative to the largest slope of the objective, below which a limit costs nothing."""
SLOPE = 1e-3
"""Slope of the scaled objective that counts as zero: at an optimum between all limits, what is left of it is no price."""
DEPENDENT = 1e-6
"""Relative singular value below which slopes of constraints depend on each other."""


@dataclass(frozen=True)
class Price:
    """Shadow price of one limit.

    Attributes
    ----------
    name
        The response, with its case, or the variable.
    limit
        "below 60", "above 1.05".
    price
        Improvement of the objective where the limit gives way by one unit: the derivative of the optimum by the limit, without
        its sign.
    unit
        Unit of the price.
    active
        Whether the limit costs anything.
    text
        The same as a sentence.
    """

    name: str
    limit: str
    price: float
    unit: str
    active: bool
    text: str

    def record(self) -> dict[str, Any]:
        """The price as a JSON object."""
        return {
            "of": self.name,
            "limit": self.limit,
            "price": self.price,
            "unit": self.unit,
            "active": self.active,
            "text": self.text,
        }


def prices(program: Program, best: DesignOutcome, left: Optimality) -> Iterator[Price]:
    """Prices of all constraints, and of the bounds of variables that cost something."""
    problem = program.problem
    of_rows, of_bounds = _active(program, best, left)
    for row, multiplier, active in zip(program.rows, left.multipliers, of_rows, strict=True):
        unit = problem.unit_of(row.response)
        yield _price(program, row.label, row.sign, row.limit, float(multiplier) / row.size, unit, bool(active))
    for sign, bounds, multipliers, active in zip((1.0, -1.0), problem.bounds, left.at_bounds, of_bounds, strict=True):
        for k in np.flatnonzero(active):
            name, scale = problem.variables[k], problem.scales[k]
            yield _price(
                program, name, sign, float(bounds[k]), float(multipliers[k] / scale), problem.unit_of_variable(name), True
            )


def _active(program: Program, best: DesignOutcome, left: Optimality) -> tuple[np.ndarray, np.ndarray]:
    """Which constraints (m,) and bounds (2, n) are active and cost something.

    Their multiplier, relative to the largest slope, is larger than their distance. One of the two is zero at an optimum, and this
    tells which of them is on its way there.
    """
    values, z = program.values(best), program.scaled(best.design)
    largest = max(float(np.max(np.abs(values.df))), SLOPE)
    return left.multipliers > largest * np.maximum(values.c, LEAST), left.at_bounds > largest * np.maximum(
        np.array([z, program.top - z]), LEAST
    )


def _price(program: Program, name: str, sign: float, limit: float, multiplier: float, unit: str, active: bool) -> Price:
    """Price of a limit, from its multiplier for the scaled objective and the limit as it is written."""
    objective, its_unit = objective_of(program)
    price = multiplier * program.unit
    word, more = ("above", "less") if sign > 0 else ("below", "more")
    verb = "lowers" if program.problem.study.objective.sign > 0 else "raises"
    text = (
        f"{name} {word} {limit:.6g}: {f'1 {unit}'.strip()} {more} {verb} {objective} by {price:.4g} {its_unit}".rstrip()
        if active
        else f"{name} {word} {limit:.6g}: costs nothing"
    )
    return Price(name, f"{word} {limit:.6g}", price, _ratio(its_unit, unit), active, text)


def _ratio(above: str, below: str) -> str:
    if not below:
        return above
    return f"{above or '1'}/{f'({below})' if set(below) & set(' /') else below}"


def objective_of(program: Program) -> tuple[str, str]:
    """Name and unit of the objective: those of its response if it has only one."""
    problem, weights = program.problem, program.problem.weights
    if len(weights) == 1 and list(weights.values()) == [1.0]:
        name = next(iter(weights))
        return name, problem.unit_of(name)
    return "the objective", ""


def dependent(program: Program, best: DesignOutcome, left: Optimality) -> bool:
    """Whether active constraints depend on each other, so that prices can be shared between them in many ways."""
    of_rows, of_bounds = _active(program, best, left)
    identity = np.eye(len(best.design))
    rows = np.vstack([program.values(best).dc[of_rows], *(identity[each] for each in of_bounds)])
    return len(rows) > 0 and int(np.linalg.matrix_rank(rows, rtol=DEPENDENT)) < len(rows)
