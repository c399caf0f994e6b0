"""A study as a nonlinear program: minimise F(z) where all c(z) >= 0, in variables and values scaled to the size of one.

    z = (x - least) / scale,   F = sign * sum over cases / F_0,   c = (value - above) / size  or  (below - value) / size

Signs and units are put back where prices are told, in `prices`.

How much lower the objective is at best, by its curvature and the slopes of constraints at one design.

    gain = max over p of  -(df . p + p . H p / 2),    c + dc p >= 0,   0 <= z + p <= top

With x = L^T p + L^-1 df and H = L L^T this is the shortest x within half-spaces, which non-negative least squares find (Lawson and Hanson,
Solving Least Squares Problems, 1974, chapter 23). A residual of slopes says nothing of it as long as nobody knows how flat the valley is.

How nearly a design meets the conditions of Karush, Kuhn and Tucker, and at which multipliers.

    dF = sum of lam_i dc_i,   lam >= 0,   lam_i c_i = 0,   c >= 0;   bounds of variables are constraints like all others

The multipliers are those of non-negative least squares of the first and the third condition together, so that nothing has to be decided
about which constraints are active.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.optimize import nnls

from toolkit.studies.problem import Problem, by_case
from toolkit.studies.store import DesignOutcome

if TYPE_CHECKING:
    from toolkit.foundation.value_types import Record


class ConstraintRow(NamedTuple):
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
    def rows(self) -> list[ConstraintRow]:
        """All constraints, cases within limits within responses."""
        found = []
        for wanted in self.problem.limits:
            size = wanted.limit.scale or abs(wanted.bound) or 1.0
            labels = by_case(self.problem.cases, wanted.response)
            found += [
                ConstraintRow(wanted.response, case, wanted.sign, wanted.bound, size, label) for case, label in enumerate(labels)
            ]
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


LEAST_CURVATURE = 1e-12
"""Curvature, in parts of the largest, or of the largest slope if that is more, below which none is told from zero: bounds of variables say
how far to go there."""


def promised(down: np.ndarray, up: np.ndarray, values: Values) -> float:
    """The gain, in units of the scaled objective; zero where the objective tells no curvature.

    Parameters
    ----------
    down, up
        How far every variable may go down and up, (n,); infinite where it has no bound.
    values
        The functions.
    """
    steep = float(np.max(np.abs(values.df)))
    if values.curvature is None or steep == 0:
        return 0.0
    curved, directions = np.linalg.eigh(values.curvature)
    axes = directions / np.sqrt(np.maximum(curved, LEAST_CURVATURE * max(curved[-1], steep)))
    slope = values.df @ axes
    length = float(np.sqrt(slope @ slope))
    n = len(down)
    slack = np.maximum(np.concatenate([values.c, down, up]), 0.0)  # what is violated a little may stay so
    limits = np.isfinite(slack)
    rows = np.vstack([values.dc.reshape(-1, n), np.eye(n), -np.eye(n)])[limits] @ axes
    x = _shortest(rows, (rows @ slope - slack[limits]) / length)
    return 0.5 * length**2 * max(0.0, 1.0 - float(x @ x))


def _shortest(rows: np.ndarray, least: np.ndarray) -> np.ndarray:
    """The shortest x of rows x >= least, which at least one x no longer than one keeps."""
    matrix = np.vstack([rows.T, least])
    wanted = np.zeros(len(matrix))
    wanted[-1] = 1.0
    multipliers, _ = nnls(matrix, wanted)
    left = matrix @ multipliers - wanted
    found: np.ndarray = -left[:-1] / left[-1]
    return found


ROUND_OFF = 1e-12
"""Part of the objective that no derivative decides."""
CERTAIN_GAIN = 1e-3
"""Part of what may be left to gain, below which slopes are not asked."""
ZERO_OBJECTIVE = 1e-4
"""Objective, in parts of its scale, beside which smaller ones are none: a mean of squares may end at zero."""


class Optimality(NamedTuple):
    """What is left of the conditions at a design.

    Attributes
    ----------
    residual
        Largest entry of what multipliers cannot balance, and of the products of multipliers and constraints, in parts of the objective's
        scale, or of its largest derivative there if that is more: by less than this part it would change over the whole range of a
        variable. A number that is added to the objective changes nothing.
    violation
        Largest violation of a constraint, in parts of its size.
    multipliers
        Of all constraints, (m,).
    at_bounds
        Multipliers of the least and the largest values of the variables, (2, n).
    gain
        What is to be gained at most by the curvature that the objective tells, and by the slopes of the constraints, in parts of the
        objective; zero where it tells none. A search of few designs has seen steep slopes only, beside which a residual looks small.
    """

    residual: float
    violation: float
    multipliers: np.ndarray
    at_bounds: np.ndarray
    gain: float = 0.0

    def met(self, optimality: float, feasibility: float) -> bool:
        """Whether nothing of size is left; where next to nothing is to be gained, slopes need not be small beside those of other designs,
        all of which may stand at the optimum."""
        flat = self.residual <= optimality or 0 < self.gain <= CERTAIN_GAIN * optimality
        return flat and self.gain <= optimality and self.violation <= feasibility


def optimality_of(program: Program, z: np.ndarray, found: Values, typical: float) -> Optimality:
    """What is left at z; `typical` is a large change of the scaled objective."""
    n, identity = len(z), np.eye(len(z))
    constraints = np.concatenate([found.c, z, program.top - z])
    slopes = np.vstack([found.dc, identity, -identity])
    matrix = np.vstack([slopes.T, np.diag(constraints)])
    wanted = np.concatenate([found.df, np.zeros(len(constraints))])
    multipliers, _ = nnls(matrix, wanted)
    left = np.abs(matrix @ multipliers - wanted)
    scale = max(float(np.max(np.abs(found.df))), typical, ROUND_OFF * abs(found.f), np.finfo(float).tiny)
    violation = max(0.0, float(np.max(-constraints)))
    m = len(found.c)
    gain = promised(z, program.top - z, found) / max(abs(found.f), ZERO_OBJECTIVE * scale)
    return Optimality(float(np.max(left)) / scale, violation, multipliers[:m], multipliers[m:].reshape(2, n), gain)


LEAST_MULTIPLIER = 1e-6
"""Multiplier, relative to the largest slope of the objective, below which a limit costs nothing."""
ZERO_SLOPE = 1e-3
"""Slope of the scaled objective that counts as zero: at an optimum between all limits, what is left of it is no price."""
DEPENDENT_SLOPES = 1e-6
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

    def record(self) -> Record:
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
    largest = max(float(np.max(np.abs(values.df))), ZERO_SLOPE)
    return left.multipliers > largest * np.maximum(values.c, LEAST_MULTIPLIER), left.at_bounds > largest * np.maximum(
        np.array([z, program.top - z]), LEAST_MULTIPLIER
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
    return len(rows) > 0 and int(np.linalg.matrix_rank(rows, rtol=DEPENDENT_SLOPES)) < len(rows)
