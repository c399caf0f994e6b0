"""The designs that one search has solved: each once, as many as the study allows, and the best of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from toolkit.studies.engine.outcome import DesignOutcome
from toolkit.studies.optimization.methods.functions import DesignFailedError
from toolkit.studies.optimization.optimality import Optimality, optimality_of
from toolkit.studies.optimization.program import Program, Values
from toolkit.studies.optimization.promise import promised
from toolkit.studies.optimization.search.curvature import Known
from toolkit.studies.optimization.search.search_result import Spent

FIRST_SLOPE = 0.2
"""Largest derivative of the scaled objective at the first design: a method whose first matrix is the identity goes so far at first."""
TYPICAL = 0.25
"""Part of the designs whose largest derivative is below what is typical: wild ones from the beginning of a search do not count."""
Solve = Callable[[np.ndarray], DesignOutcome]
"""Solves a design, or takes it from where it is kept."""


class Explored:
    """What one search knows.

    Parameters
    ----------
    program
        The functions; they are measured anew where a method begins.
    solve
        Solves a design.
    """

    def __init__(self, program: Program, solve: Solve) -> None:
        self.program, self.solve = program, solve
        self.options = program.problem.study.search
        self.done: dict[bytes, DesignOutcome] = {}
        self.passed: set[bytes] = set()
        """Designs that meet the conditions of an optimum and are none."""

    @property
    def failed(self) -> int:
        """Designs that could not be solved."""
        return sum(each.failed for each in self.done.values())

    @property
    def known(self) -> list[Known]:
        """All others."""
        solved = (each for each in self.done.values() if not each.failed)
        return [Known(self.program.scaled(each.design), self.program.values(each)) for each in solved]

    @property
    def typical(self) -> float:
        """What a large change of the scaled objective is: as the study says, or as the designs that were solved do."""
        given = self.program.problem.study.objective.scale
        if given is not None:
            return given / self.program.unit
        slopes = [np.max(np.abs(self.program.values(each).df)) for each in self.done.values() if not each.failed]
        return float(np.quantile(slopes, TYPICAL))

    def measure_by(self, values: Values) -> None:
        """Set the unit of the objective by its slopes where a method begins."""
        size = float(np.max(np.abs(values.df)))
        self.program = replace(self.program, unit=self.program.unit * (size / FIRST_SLOPE if size > 0 else 1.0))

    def evaluated(self, design: np.ndarray) -> DesignOutcome:
        """The design, which counts if it is new."""
        key = design.tobytes()
        if key not in self.done:
            if len(self.done) >= self.options.evaluations:
                raise Spent(f"{self.options.evaluations} designs were solved, as many as the study allows")
            found = self.done[key] = self.solve(design)
            if found.failed and self.failed >= self.options.most_failures:
                raise Spent(f"{self.failed} designs could not be solved, as many as the study allows")
        return self.done[key]

    def functions(self, z: np.ndarray) -> Values:
        """F and c at z; a design that cannot be solved ends the method."""
        found = self.evaluated(self.program.design(z))
        if found.failed and self.options.failures == "stop":
            raise Spent("a design could not be solved, and the study says to stop there")
        if found.failed:
            raise DesignFailedError(np.array(z))
        return self.program.values(found)

    def left(self, z: np.ndarray, values: Values) -> Optimality:
        """What is left of the conditions of an optimum."""
        return optimality_of(self.program, z, values, self.typical)

    def best(self) -> tuple[DesignOutcome | None, Optimality | None]:
        """The feasible design of the least objective, else the least violated one; with what is left of the conditions."""
        judged = []
        solved = [each for each in self.done.values() if not each.failed]
        if not solved:
            return None, None
        typical = self.typical
        for found in solved:
            values = self.program.values(found)
            left = optimality_of(self.program, self.program.scaled(found.design), values, typical)
            feasible = left.violation <= self.options.feasibility
            met = left.met(self.options.optimality, self.options.feasibility) and found.design.tobytes() not in self.passed
            judged.append(((not met, not feasible,
                            values.f if feasible else left.violation), found, left))  # fmt: skip
        _, found, left = min(judged, key=lambda each: each[0])
        return found, left

    def stand(self, near: float = 0.0) -> np.ndarray:
        """z of the design from which a method begins anew: the best so far. With `near`, until one meets the conditions of an optimum, the
        one from which curvature and slopes promise the lowest objective by steps of at most that part of the ranges: a design that was
        refused because it lies beside the floor of a bent valley may be far ahead along it, and one short step leads back to the floor.
        """
        best, left = self.best()
        assert best is not None
        assert left is not None
        feasible = [each for each in self.known if np.min(each.values.c, initial=0.0) >= -self.options.feasibility]
        if near == 0 or not feasible or left.met(self.options.optimality, self.options.feasibility):
            return self.program.scaled(best.design)
        return min(feasible, key=lambda each: self._promises(each, near * self.program.top)).z

    def _promises(self, known: Known, steps: np.ndarray) -> float:
        """The least objective that steps of at most so much in every variable, (n,), promise."""
        z, values = known
        return values.f - promised(np.minimum(z, steps), np.minimum(self.program.top - z, steps), values)
