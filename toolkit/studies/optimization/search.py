"""One search: a method of a library within planes that cut off what failed, until the conditions of an optimum are met."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from toolkit.studies.distributions.sobol_points import plain
from toolkit.studies.evaluation.evaluation import Evaluation
from toolkit.studies.evaluation.evaluator import Evaluator
from toolkit.studies.optimization.curvature import LONGEST, NARROWER, REACHES, WIDER, Known, Turned, turned
from toolkit.studies.optimization.cuts import Cuts
from toolkit.studies.optimization.methods.catalogue import METHODS
from toolkit.studies.optimization.methods.functions import DesignFailedError, Functions
from toolkit.studies.optimization.optimality import Optimality, optimality_of
from toolkit.studies.optimization.program import Program, Values

BACK = 0.5
"""Part of the way from a start that failed to a known design that the next one has."""
AGAIN = 3
"""How often a method that gave up begins anew where it stood, without planes."""
BESIDE, LOOKS = 0.2, 8
"""How wide, in parts of the variables' ranges, and at how many designs a search looks around a start that is stationary."""
ASKEW = 0.07
"""By which these designs are shifted, so that none of them stands at the start or mirrors another."""
LOWER = 1e-9
"""Part of an objective by which another one is lower, and not by round-off."""
FIRST_SLOPE = 0.2
"""Largest derivative of the scaled objective at the first design: a method whose first matrix is the identity goes so far at first."""
MANY = 50
"""Variables above which no method begins anew in other ones, in which bounds are constraints like others."""
FIRST_METHODS = 0.2
"""Part of the designs that each of several methods, but for the last, may solve."""
LITTLE = 1e-4
"""Part of an objective by which a lower design that is none is no reason to leave an optimum."""
TYPICAL = 0.25
"""Part of the designs whose largest derivative is below what is typical: wild ones from the beginning of a search do not count."""
Tell = Callable[[Evaluation], None]


class _Ended(Exception):
    """Why a method is to stop; no error."""


class _Arrived(_Ended):
    """The conditions of an optimum are met."""


class _Renewed(_Ended):
    """A method is to begin anew, or the next one: so many designs were solved."""


class _Spent(_Ended):
    """No more designs may be solved, or no more may fail."""


@dataclass(frozen=True)
class Found:
    """How one search ended.

    Attributes
    ----------
    lane
        Its number in the store.
    best
        The design where it ended: feasible and of the least objective, or else the one that violates its constraints least; None if not one
        could be solved.
    optimality
        What is left of the conditions there.
    program
        The functions as they were scaled.
    ended
        Why it ended, in words.
    evaluations, failed
        Designs solved, and how many of them failed.
    """

    lane: int
    start: np.ndarray
    best: Evaluation | None
    optimality: Optimality | None
    program: Program
    ended: str
    evaluations: int
    failed: int
    arrived: bool


class Search:
    """What one search knows."""

    def __init__(self, program: Program, evaluator: Evaluator, lane: int, warm: bool, tell: Tell) -> None:
        self.program, self.evaluator, self.lane, self.warm, self.tell = program, evaluator, lane, warm, tell
        self.options = program.problem.study.search
        self.done: dict[bytes, Evaluation] = {}
        self.last: np.ndarray | None = None
        self.met = False
        self.least: float | None = None
        self.passed: set[bytes] = set()
        self.renewal: int | None = None
        self.reach = LONGEST

    @property
    def failed(self) -> int:
        """Designs that could not be solved."""
        return sum(each.failed for each in self.done.values())

    @property
    def _typical(self) -> float:
        """What a large change of the scaled objective is: as the study says, or as the designs that were solved do."""
        given = self.program.problem.study.objective.scale
        if given is not None:
            return given / self.program.unit
        slopes = [np.max(np.abs(self.program.values(each).df)) for each in self.done.values() if not each.failed]
        return float(np.quantile(slopes, TYPICAL))

    def run(self, start: np.ndarray, known: np.ndarray | None) -> Found:
        """Search from a start; where that fails, from designs on the way to a known one."""
        try:
            z = self._first(start, known)
            if z is not None and self.met:
                z = self._beside(z)
            ended = "no design near the start could be solved" if z is None else self._by_methods(z)
            arrived = False
        except _Arrived:
            ended, arrived = "the conditions of an optimum are met", True
        except _Spent as why:
            ended, arrived = str(why), False
        best, left = self._best()
        if best is not None and left is not None and best.design.tobytes() not in self.passed:
            arrived = arrived or left.met(self.options.optimality, self.options.feasibility)
        return Found(self.lane, start, best, left, self.program, ended, len(self.done), self.failed, arrived)

    def _first(self, start: np.ndarray, known: np.ndarray | None) -> np.ndarray | None:
        """The first design that can be solved, on the way from the start to the known one; it sets the unit of the objective."""
        z, back = self.program.scaled(start), None if known is None else self.program.scaled(known)
        for _ in range(1 if back is None else 4):
            found = self._evaluated(self.program.design(z))
            if not found.failed:
                self._begin_at(self.program.values(found))
                self._visited(z)
                return z
            if back is not None:
                z = back + BACK * (z - back)
        return None

    def _beside(self, z: np.ndarray) -> np.ndarray:
        """The best of some designs around a stationary start, which may be a maximum or a saddle, as where a mechanism is symmetric."""
        here, best = self._functions(z), z
        least = here.f - LOWER * max(1.0, abs(here.f))
        for point in plain(LOOKS, len(z)):
            there = np.clip(z + BESIDE * self.program.top * (2 * point - 1 + ASKEW), 0.0, self.program.top)
            try:
                values = self._functions(there)
            except DesignFailedError:
                continue
            if values.f < least and np.min(values.c, initial=0.0) >= -self.options.feasibility:
                least, best = values.f, there
        if best is not z:
            self.passed.add(self.program.design(z).tobytes())
            self.met, self.least, self.last = False, None, best
            self._begin_at(self._functions(best))
        return best

    def _begin_at(self, values: Values) -> None:
        """Set the unit of the objective by its slopes where a method begins."""
        size = float(np.max(np.abs(values.df)))
        self.program = replace(self.program, unit=self.program.unit * (size / FIRST_SLOPE if size > 0 else 1.0))

    def _by_methods(self, z: np.ndarray) -> str:
        """Run all methods, one after the other. Returns why the last was given up."""
        *first, last = self.options.method
        for method in first:
            try:
                self._within_cuts(method, z, len(self.done) + max(1, int(FIRST_METHODS * self.options.evaluations)))
            except _Renewed:
                self.last = self._stand()
        return self._within_cuts(last, z)

    def _within_cuts(self, method: str, z: np.ndarray, until: int | None = None) -> str:
        """Run a method until so many designs are solved; what failed is cut off by a plane for the next run of it. Returns why it was
        given up."""
        cuts, again, curvature = Cuts(), 0, self._turned(method)
        while True:
            centre = self.last if self.last is not None else z
            before = len(self.done)
            self.renewal = min((each for each in (until, self._renewed(method)) if each is not None), default=None)
            try:
                self._run(method, cuts.around(self._functions), centre, curvature)
            except DesignFailedError as failure:
                if not cuts.add(self.last if self.last is not None else z, failure.z):
                    return "designs all around cannot be solved: it stands at the edge of what can"
                continue
            except _Renewed:
                if until is not None and len(self.done) >= until:
                    raise
                self._adapt(method, len(self.done) - before)
                self.last = self._stand()
                curvature = self._turned(method)
                continue
            if self.met:
                raise _Arrived
            cuts, curvature = Cuts(), self._turned(method)
            again += len(self.done) == before or self.last is None or bool(np.array_equal(self.last, centre))
            if again > AGAIN:
                return "the method made no progress any more"

    def _run(self, method: str, functions: Functions, centre: np.ndarray, curvature: Turned | None) -> None:
        """Run a method from a design, in variables that are turned if the curvature there is known."""
        run, most, n, top = METHODS[method].run, self.options.evaluations, len(centre), self.program.top
        centre = np.clip(centre, METHODS[method].inside * top, (1 - METHODS[method].inside) * top)
        if curvature is None:
            run(functions, centre, np.zeros(n), top, self._accepted, most)
        else:
            here = Turned(centre, curvature.axes, top)
            free = np.full(n, np.inf)
            run(here.functions(functions), np.zeros(n), -free, free, lambda y: self._accepted(here.z(y)), most)

    def _accepted(self, z: np.ndarray) -> None:
        self._visited(z)
        if self.renewal is not None and len(self.done) >= self.renewal:
            raise _Renewed

    def _stand(self) -> np.ndarray:
        """The best design so far, from which a method begins anew."""
        best, _ = self._best()
        assert best is not None
        return self.program.scaled(best.design)

    def _every(self, method: str) -> int | None:
        """Designs after which a method begins anew in other variables."""
        return METHODS[method].told if self.program.problem.curved else METHODS[method].learned

    def _renewed(self, method: str) -> int | None:
        every = self._every(method)
        return None if every is None or len(self.program.top) > MANY else len(self.done) + every

    def _adapt(self, method: str, used: int) -> None:
        """Go farther, or less far, along the told curvature next time, by the designs that were solved until one was accepted."""
        every = self._every(method) or used
        factor = WIDER if used <= every else NARROWER if used > every + 1 else 1.0
        self.reach = float(np.clip(self.reach * factor, *REACHES)) if self.program.problem.curved else LONGEST

    def _turned(self, method: str) -> Turned | None:
        """Variables by the curvature where the search stands, None where it is not known."""
        if self.last is None or self._renewed(method) is None:
            return None
        known = [
            Known(self.program.scaled(each.design), self.program.values(each)) for each in self.done.values() if not each.failed
        ]
        centre = Known(self.last, self._functions(self.last))
        left = optimality_of(self.program, self.last, centre.values, self._typical)
        return turned(centre, known, left.multipliers, self.program.top, self.reach)

    def _evaluated(self, design: np.ndarray) -> Evaluation:
        key = design.tobytes()
        if key not in self.done:
            if len(self.done) >= self.options.evaluations:
                raise _Spent(f"{self.options.evaluations} designs were solved, as many as the study allows")
            found = self.evaluator(self.lane, design, self.warm)
            self.done[key] = found
            self.tell(found)
            if found.failed and self.failed >= self.options.most_failures:
                raise _Spent(f"{self.failed} designs could not be solved, as many as the study allows")
        return self.done[key]

    def _functions(self, z: np.ndarray) -> Values:
        """F and c at z; a design that cannot be solved ends the method."""
        found = self._evaluated(self.program.design(z))
        if found.failed and self.options.failures == "stop":
            raise _Spent("a design could not be solved, and the study says to stop there")
        if found.failed:
            raise DesignFailedError(np.array(z))
        return self.program.values(found)

    def _visited(self, z: np.ndarray) -> None:
        """A design that the method has accepted: the next run begins at this one, unless it is an optimum, and the method, which leaves a
        saddle, finds another one next, or nothing that is lower by what counts. Of mean squares that decides alone: a search that is done
        after a few steps knows only steep slopes, beside which all others look small."""
        values, z = self._functions(z), np.clip(z, 0.0, self.program.top)
        if self.last is not None and np.array_equal(z, self.last):
            return
        left = optimality_of(self.program, z, values, self._typical)
        met, least = left.met(self.options.optimality, self.options.feasibility), self.least
        self.last, self.met = z, met
        if least is not None and left.violation <= self.options.feasibility:
            counts = min(self.options.optimality * max(float(np.max(np.abs(values.df))), self._typical), LITTLE * abs(least))
            if (met and not self.program.problem.curved) or least - values.f <= counts:
                raise _Arrived
            self.least = None
        if met:
            self.least = values.f

    def _best(self) -> tuple[Evaluation | None, Optimality | None]:
        """The feasible design of the least objective, else the least violated one; with what is left of the conditions."""
        judged = []
        for found in self.done.values():
            if not found.failed:
                z, values = self.program.scaled(found.design), self.program.values(found)
                left = optimality_of(self.program, z, values, self._typical)
                feasible = left.violation <= self.options.feasibility
                met = left.met(self.options.optimality, self.options.feasibility) and found.design.tobytes() not in self.passed
                judged.append(((not met, not feasible,
                                values.f if feasible else left.violation), found, left))  # fmt: skip
        if not judged:
            return None, None
        _, found, left = min(judged, key=lambda each: each[0])
        return found, left
