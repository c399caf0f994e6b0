"""One search: a method of a library within planes that cut off what failed, until the conditions of an optimum are met."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from toolkit.studies.design_work import Evaluator
from toolkit.studies.optimization.explored import (
    LONGEST_FIRST_STEP,
    Arrived,
    Cuts,
    Explored,
    Known,
    Renewed,
    SearchResult,
    Spent,
    Turned,
    turned,
)
from toolkit.studies.optimization.methods import METHODS, DesignFailedError, Functions, Method
from toolkit.studies.optimization.program import Optimality, Program
from toolkit.studies.orthonormal_basis import plain
from toolkit.studies.problem import Problem
from toolkit.studies.store import DesignOutcome
from toolkit.studies.study_file import Search as SearchOptions

STEP_NARROWING, STEP_WIDENING, REACHES = 0.5, 2.0, (1e-3, 1.0)
"""By what the longest first step is changed where one was too long or was not, and between which bounds."""
MOST_TRANSFORMED_VARIABLES = 50
"""Variables above which no method begins anew in other ones, in which bounds are constraints like others."""


class Renewal:
    """The renewals of one search.

    Parameters
    ----------
    curved
        Whether the objective tells its curvature.
    top
        Largest z, (n,).
    """

    def __init__(self, curved: bool, top: np.ndarray) -> None:
        self.curved, self.top = curved, top
        self.reach = LONGEST_FIRST_STEP

    def every(self, method: Method) -> int | None:
        """Designs after which a method begins anew; None if it never does."""
        if len(self.top) > MOST_TRANSFORMED_VARIABLES:
            return None
        return method.told if self.curved else method.learned

    def adapt(self, method: Method, used: int) -> None:
        """Go farther, or less far, along the told curvature next time, by the designs that were solved until one was accepted."""
        every = self.every(method) or used
        factor = STEP_WIDENING if used <= every else STEP_NARROWING if used > every + 1 else 1.0
        self.reach = float(np.clip(self.reach * factor, *REACHES)) if self.curved else LONGEST_FIRST_STEP

    def variables(self, method: Method, centre: Known, others: Sequence[Known], multipliers: np.ndarray) -> Turned | None:
        """Variables by the curvature about a design, None where it is not known or the method stays as it is."""
        return None if self.every(method) is None else turned(centre, others, multipliers, self.top, self.reach)


UNIMPORTANT_GAIN = 1e-4
"""Part of an objective by which a lower design that is none is no reason to leave an optimum."""


class EndRule:
    """The rule, told one accepted design after the other.

    Parameters
    ----------
    options
        When the conditions are met.
    curved
        Whether the objective is a mean of squares. Of these what is gained decides alone: a search that is done after a few steps knows
        only steep slopes, beside which all others look small.
    """

    def __init__(self, options: SearchOptions, curved: bool) -> None:
        self.options, self.curved = options, curved
        self.met = False
        self._least: float | None = None

    def ends(self, objective: float, left: Optimality, large: float) -> bool:
        """Whether the search is at an optimum.

        Parameters
        ----------
        objective
            At the design.
        left
            What is left of the conditions there.
        large
            A large change of the objective.
        """
        self.met, least = left.met(self.options.optimality, self.options.feasibility), self._least
        if least is not None and left.violation <= self.options.feasibility:
            counts = min(self.options.optimality * large, UNIMPORTANT_GAIN * abs(least))
            if (self.met and not self.curved) or least - objective <= counts:
                return True
            self._least = None
        if self.met:
            self._least = objective
        return False

    def forget(self) -> None:
        """Begin elsewhere."""
        self.met, self._least = False, None


RETREAT_PART = 0.5
"""Part of the way from a start that failed to a known design that the next one has."""
RESTARTS = 3
"""How often a method that gave up begins anew where it stood, without planes."""
SHARE_OF_FIRST_METHODS = 0.2
"""Part of the designs that each of several methods, but for the last, may solve."""
START_SURROUNDINGS, DESIGNS_AROUND_START = 0.2, 8
"""How wide, in parts of the variables' ranges, and at how many designs a search looks around a start that is stationary."""
SURROUNDINGS_SHIFT = 0.07
"""By which these designs are shifted, so that none of them stands at the start or mirrors another."""
LOWER_OBJECTIVE = 1e-9
"""Part of an objective by which another one is lower, and not by round-off."""
Tell = Callable[[DesignOutcome], None]


def starts_of(problem: Problem, count: int) -> np.ndarray:
    """Designs in which searches begin, (count, n): the first is the scene's own, and more starts leave the first ones as they are.

    The sequence is not scrambled, so that it is the same everywhere; its first point, a corner of the bounds, is left out.
    """
    low, high = problem.bounds
    return np.vstack([problem.start, low + plain(count - 1, len(low)) * (high - low)])


class SearchRun:
    """One search."""

    def __init__(self, program: Program, evaluator: Evaluator, lane: int, warm: bool, tell: Tell) -> None:
        def solve(design: np.ndarray) -> DesignOutcome:
            found = evaluator(lane, design, warm)
            tell(found)
            return found

        self.explored, self.lane = Explored(program, solve), lane
        self.options = program.problem.study.search
        self.rule = EndRule(self.options, bool(program.problem.curved))
        self.renewal = Renewal(bool(program.problem.curved), program.top)
        self.last: np.ndarray | None = None
        self.until: int | None = None

    def run(self, start: np.ndarray, known: np.ndarray | None) -> SearchResult:
        """Search from a start; where that fails, from designs on the way to a known one."""
        explored = self.explored
        try:
            z = self._first(start, known)
            if z is not None and self.rule.met:
                z = self._beside(z)
            ended = "no design near the start could be solved" if z is None else self._by_methods(z)
            arrived = False
        except Arrived:
            ended, arrived = "the conditions of an optimum are met", True
        except Spent as why:
            ended, arrived = str(why), False
        best, left = explored.best()
        if best is not None and left is not None and best.design.tobytes() not in explored.passed:
            arrived = arrived or left.met(self.options.optimality, self.options.feasibility)
        return SearchResult(self.lane, start, best, left, explored.program, ended, len(explored.done), explored.failed, arrived)

    def _first(self, start: np.ndarray, known: np.ndarray | None) -> np.ndarray | None:
        """The first design that can be solved, on the way from the start to the known one; it sets the unit of the objective."""
        program = self.explored.program
        z, back = program.scaled(start), None if known is None else program.scaled(known)
        for _ in range(1 if back is None else 4):
            found = self.explored.evaluated(program.design(z))
            if not found.failed:
                self.explored.measure_by(program.values(found))
                self._visited(z)
                return z
            if back is not None:
                z = back + RETREAT_PART * (z - back)
        return None

    def _beside(self, z: np.ndarray) -> np.ndarray:
        """A better design around a stationary start, which is no optimum then."""
        best = _best_beside(self.explored, z)
        if best is not z:
            self.explored.passed.add(self.explored.program.design(z).tobytes())
            self.rule.forget()
            self.last = best
            self.explored.measure_by(self.explored.functions(best))
        return best

    def _by_methods(self, z: np.ndarray) -> str:
        """Run all methods, one after the other. Returns why the last was given up."""
        *first, last = self.options.method
        for method in first:
            most = max(1, int(SHARE_OF_FIRST_METHODS * self.options.evaluations))
            try:
                self._within_cuts(method, z, len(self.explored.done) + most)
            except Renewed:
                self.last = self.explored.stand()
        return self._within_cuts(last, z)

    def _within_cuts(self, method: str, z: np.ndarray, until: int | None = None) -> str:
        """Run a method until so many designs are solved; what failed is cut off by a plane for the next run of it. Returns why it was
        given up."""
        done, cuts, again, curvature = self.explored.done, Cuts(), 0, self._turned(method)
        every = self.renewal.every(METHODS[method])
        while True:
            centre = self.last if self.last is not None else z
            before = len(done)
            self.until = min((each for each in (until, every and before + every) if each is not None), default=None)
            try:
                self._run(method, cuts.around(self.explored.functions), centre, curvature)
            except DesignFailedError as failure:
                if not cuts.add(self.last if self.last is not None else z, failure.z):
                    return "designs all around cannot be solved: it stands at the edge of what can"
                curvature = self._turned(method)
                continue
            except Renewed:
                if until is not None and len(done) >= until:
                    raise
                self.renewal.adapt(METHODS[method], len(done) - before)
                self.last = self.explored.stand(METHODS[method].near)
                cuts.release(self.last)
                curvature = self._turned(method)
                continue
            if self.rule.met:
                raise Arrived
            cuts, curvature = Cuts(), self._turned(method)
            again += len(done) == before or self.last is None or bool(np.array_equal(self.last, centre))
            if again > RESTARTS:
                return "the method made no progress any more"

    def _run(self, method: str, functions: Functions, centre: np.ndarray, curvature: Turned | None) -> None:
        """Run a method from a design, in variables that are turned if the curvature there is known."""
        run, most, n, top = METHODS[method].run, self.options.evaluations, len(centre), self.explored.program.top
        centre = np.clip(centre, METHODS[method].inside * top, (1 - METHODS[method].inside) * top)
        if curvature is None:
            run(functions, centre, np.zeros(n), top, self._accepted, most)
        else:
            here = Turned(centre, curvature.axes, top)
            free = np.full(n, np.inf)
            run(here.functions(functions), np.zeros(n), -free, free, lambda y: self._accepted(here.z(y)), most)

    def _accepted(self, z: np.ndarray) -> None:
        self._visited(z)
        if self.until is not None and len(self.explored.done) >= self.until:
            raise Renewed

    def _turned(self, method: str) -> Turned | None:
        """Variables by the curvature where the search stands, None where it is not known."""
        if self.last is None or self.renewal.every(METHODS[method]) is None:
            return None
        centre = Known(self.last, self.explored.functions(self.last))
        multipliers = self.explored.left(*centre).multipliers
        return self.renewal.variables(METHODS[method], centre, self.explored.known, multipliers)

    def _visited(self, z: np.ndarray) -> None:
        """A design that the method has accepted: the next run begins at this one, unless the search ends there."""
        values, z = self.explored.functions(z), np.clip(z, 0.0, self.explored.program.top)
        if self.last is not None and np.array_equal(z, self.last):
            return
        self.last = z
        large = max(float(np.max(np.abs(values.df))), self.explored.typical)
        if self.rule.ends(values.f, self.explored.left(z, values), large):
            raise Arrived


def _best_beside(explored: Explored, z: np.ndarray) -> np.ndarray:
    """The best feasible one of some designs around z, z itself if none is lower."""
    here, best, top = explored.functions(z), z, explored.program.top
    least = here.f - LOWER_OBJECTIVE * max(1.0, abs(here.f))
    for point in plain(DESIGNS_AROUND_START, len(z)):
        there = np.clip(z + START_SURROUNDINGS * top * (2 * point - 1 + SURROUNDINGS_SHIFT), 0.0, top)
        try:
            values = explored.functions(there)
        except DesignFailedError:
            continue
        if values.f < least and np.min(values.c, initial=0.0) >= -explored.options.feasibility:
            least, best = values.f, there
    return best
