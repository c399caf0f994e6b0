"""Sequential quadratic programming in a box about the last design: one design a step, and every design teaches curvature.

A design that cannot be solved is cut off by a plane half-way to it, along which the search can slide, and nothing that was learnt is lost;
one that is no better makes the box smaller, but its slopes count for the curvature all the same.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from toolkit.studies.optimization.methods.functions import DesignFailedError, Functions, Visited
from toolkit.studies.optimization.methods.quadratic_step import Linearised, quadratic_step
from toolkit.studies.optimization.program import Values

FIRST, LARGEST, SMALLEST = 0.25, 1.0, 1e-9
"""Half of the box's side, in parts of the variables' ranges: at first, at most, and where the search gives up."""
SHRUNK, GROWN, AT_EDGE = 0.35, 2.0, 0.8
"""The box after a bad step, in parts of that; its growth after a good one that went so far towards its edge."""
BAD, POOR, GOOD = 1e-3, 0.25, 0.7
"""Parts of the expected gain: below the first a step is not taken, below the second the box shrinks, above the third it may grow."""
DAMPED = 0.2
"""Least curvature along a step, in parts of what was known (Powell, 1978): the matrix stays positive definite."""
FIRST_PRICE, ABOVE = 1.0, 2.0
"""Price of violated constraints at first, in units of the scaled objective; and by how much it is above the largest multiplier, to which it
comes down by half of the way a step (Powell, 1978)."""
CUT = 0.5
"""How far a step may go on the way to any failed design."""
SPREAD = 1e3
"""Largest first curvature, and the smallest one over 1, in units of the scaled objective."""


def sqp(functions: Functions, z: np.ndarray, low: np.ndarray, high: np.ndarray, visited: Visited, most: int) -> None:
    """Sequential quadratic programming with a trust region (Fletcher, 1987, chapter 14); arguments as of `slsqp`."""
    z = np.clip(z, low, high)
    values, known, size, price, failed = functions(z), _Curvature(np.eye(len(z))), FIRST, FIRST_PRICE, list[np.ndarray]()
    while size > SMALLEST:
        ways = np.array([each - z for each in failed]).reshape(-1, len(z))
        lengths = np.sqrt(np.sum(ways**2, axis=1))
        at = Linearised(values.df, np.append(values.c, CUT * lengths), np.vstack([values.dc, -ways / lengths[:, None]]))
        step = quadratic_step(known.matrix, at, np.maximum(low - z, -size), np.minimum(high - z, size), price)
        if step is None:
            return
        multipliers = step.multipliers[: len(values.c)]
        enough = ABOVE * float(np.max(multipliers, initial=0.0))
        price = max(enough, (price + enough) / 2)
        length, expected = float(np.max(np.abs(step.p))), _merit(values, price) - _foreseen(known.matrix, values, step.p, price)
        if length < SMALLEST:
            return
        if expected <= 0.0:  # round-off of curvatures that beside a cliff are without measure: they are learnt anew
            known, size = _Curvature(np.eye(len(z))), CUT * length
            continue
        there = np.clip(z + step.p, low, high)
        try:
            found = functions(there)
        except DesignFailedError:
            failed.append(there)
            size = CUT * length
            continue
        known.learn(step.p, (found.df - multipliers @ found.dc) - (values.df - multipliers @ values.dc))
        part = (_merit(values, price) - _merit(found, price)) / expected
        if part > BAD:
            z, values = there, found
            visited(np.array(z))
        if part < POOR:
            size = SHRUNK * length
        elif part > GOOD and length > AT_EDGE * size:
            size = min(LARGEST, GROWN * size)


def _merit(values: Values, price: float) -> float:
    """The objective and the price of what is violated."""
    return values.f + price * float(np.sum(np.maximum(0.0, -values.c)))


def _foreseen(curvature: np.ndarray, values: Values, p: np.ndarray, price: float) -> float:
    """The merit after a step, by the quadratic and linear models."""
    violated = np.sum(np.maximum(0.0, -(values.c + values.dc @ p)))
    return float(values.f + values.df @ p + p @ curvature @ p / 2 + price * violated)


@dataclass
class _Curvature:
    """The matrix of Broyden, Fletcher, Goldfarb and Shanno for the Lagrangian, damped."""

    matrix: np.ndarray
    fresh: bool = field(default=True)

    def learn(self, p: np.ndarray, change: np.ndarray) -> None:
        """Take in by how much the slope changes along a step."""
        along = float(p @ change)
        if self.fresh and along > 0.0:
            first = min(max(float(change @ change) / along, 1 / SPREAD), SPREAD)
            self.matrix, self.fresh = first * np.eye(len(p)), False
        ahead = self.matrix @ p
        before = float(p @ ahead)
        share = 1.0 if along >= DAMPED * before else (1 - DAMPED) * before / (before - along)
        mixed = share * change + (1 - share) * ahead
        self.matrix = self.matrix - np.outer(ahead, ahead) / before + np.outer(mixed, mixed) / float(p @ mixed)
