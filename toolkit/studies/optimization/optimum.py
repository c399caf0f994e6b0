"""What an optimisation returns."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from toolkit.analyses.sensitivity.preparation import prepare, solve
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.scene.changed_numbers import with_numbers
from toolkit.scene.scene import Scene
from toolkit.studies.find_uncertainty import find_uncertainty
from toolkit.studies.optimization.explored import SearchResult
from toolkit.studies.optimization.program import Price, objective_of
from toolkit.studies.optimization.verification import Verification, scene_at
from toolkit.studies.orthonormal_basis import scrambled
from toolkit.studies.problem import Problem, by_case
from toolkit.studies.store import DesignOutcome
from toolkit.studies.study_file import LOAD_MARGIN
from toolkit.studies.uncertain_result import UncertainResult
from toolkit.studies.uncertain_study import uncertain_study
from toolkit.studies.wanted import Statistic
from toolkit.system.solution import Solution

if TYPE_CHECKING:
    from toolkit.foundation.value_types import Record

SAMPLES = 2**14
"""Points at which polynomials with gradients are looked at."""
MOMENT_DIFFERENCE = 0.05
"""By how much, in parts of sigma, mean and sigma of the two ways may differ."""


@dataclass(frozen=True)
class RobustnessCheck:
    """Mean and standard deviation of what is to be robust, in one case.

    Attributes
    ----------
    name
        Of the response, with its case.
    searched
        Both by the points of the search.
    judged
        Both by polynomials that are fitted to values and gradients by the uncertain numbers, as `ffrf uncertainty` does at this design.
    """

    name: str
    searched: tuple[float, float]
    judged: tuple[float, float]

    @property
    def settled(self) -> bool:
        """Whether both ways agree."""
        near = MOMENT_DIFFERENCE * max(self.judged[1], self.searched[1])
        return all(abs(a - b) <= near for a, b in zip(self.searched, self.judged, strict=True))

    def record(self) -> Record:
        """Keys of a JSON object."""
        both = {"searched": self.searched, "judged": self.judged}
        return {way: dict(zip(("mean", "sigma"), found, strict=True)) for way, found in both.items()}


def compared(problem: Problem, found: DesignOutcome) -> tuple[list[RobustnessCheck], list[Caution]]:
    """What a design's means and deviations are by another way, and what there is to say about that."""
    if problem.points is None or found.failed:
        return [], []
    try:
        judge = _judge(problem, found)
    except ToolkitError as error:
        return [], [Caution("robust-points", f"mean and sigma at the optimum could not be found out anew: {error}")]
    each = list(_compared(problem, found, judge))
    return each, [*_unsettled(each), *_doubts(judge)]


def _judge(problem: Problem, found: DesignOutcome) -> UncertainResult:
    """The study's uncertain numbers at a design, with as many designs and random designs as [uncertainty] says."""
    study, scene = problem.study, with_numbers(problem.scene, problem.numbers(found.design))[0]
    named = {name: each for name, each in scene.design.items() if not (name in study.uncertain and study.uncertain[name].of)}
    asked = tuple(dict.fromkeys(name for each in problem.statistics.values() for name in each.weights))
    kept = {name: each for name, each in study.constraints.items() if name != LOAD_MARGIN and name in asked}
    study = study.model_copy(
        update={"responses": {}, "constraints": kept, "uncertainty": study.uncertainty.model_copy(update={"responses": asked})}
    )
    return find_uncertainty(uncertain_study(study, scene.model_copy(update={"design": named})))


def _compared(problem: Problem, found: DesignOutcome, judge: UncertainResult) -> Iterator[RobustnessCheck]:
    joint, options = judge.study.joint, judge.study.options
    germs = joint.germs_of(scrambled(SAMPLES, len(joint.marginals), options.seed))
    several = {each.of: each for each in problem.statistics.values()}
    for of, each in several.items():
        mean, sigma = (problem.responses.index(f"{word} of {of}") for word in ("mean", "sigma"))
        for row, (case, label) in enumerate(zip(problem.cases, by_case(problem.cases, of), strict=True)):
            searched = float(found.values[row, mean]), float(found.values[row, sigma])
            yield RobustnessCheck(label, searched, _by_polynomials(judge, each, case, germs))


def _by_polynomials(judge: UncertainResult, each: Statistic, case: str, germs: np.ndarray) -> tuple[float, float]:
    labels = {name: by_case([case], name)[0] for name in each.weights}
    if len(labels) == 1:
        ((name, weight),) = each.weights.items()
        known = judge.responses[labels[name]]
        return weight * known.mean, abs(weight) * known.sigma
    values = sum(weight * judge.values(labels[name], germs) for name, weight in each.weights.items())
    return float(np.mean(values)), float(np.std(values))


def _unsettled(compared: list[RobustnessCheck]) -> Iterator[Caution]:
    for each in compared:
        if not each.settled:
            (mean, sigma), (other_mean, other_sigma) = each.searched, each.judged
            yield Caution(
                "robust-points",
                f"{each.name} has mean {mean:.5g} and sigma {sigma:.4g} at the points of the search, but {other_mean:.5g} and "
                f"{other_sigma:.4g} by values and gradients (limit {MOMENT_DIFFERENCE:.0%} of sigma). Give more uncertainty.points.",
            )


def _doubts(judge: UncertainResult) -> Iterator[Caution]:
    """What speaks against the polynomials that judge; what the runs say is said of the optimum itself."""
    known = ("failed-designs", "polynomials", "degree", "extrapolated", "monte-carlo")
    yield from (
        Caution(each.code, f"around the optimum: {each.text}", each.doubt)
        for each in judge.verdict.warnings
        if each.code in known
    )


class NoOptimumError(ToolkitError, ArithmeticError):
    """A study has no design that can be called an optimum."""


@dataclass(frozen=True)
class Optimum:
    """The best design of a study, and how far it can be trusted.

    Attributes
    ----------
    problem
        The study with its scene.
    search
        The search that found it.
    searches
        All of them, in the order of their starts.
    again
        The design solved anew.
    prices
        What its limits cost.
    verdict
        Whether it is an optimum, and can be trusted.
    first
        The design that the scene stands at, None if it cannot be solved.
    solved
        All designs of all searches, in their order.
    wall
        Time of all searches, also before an interruption, and of solving the optimum again, in s.
    robust
        Means and deviations over uncertain numbers by two ways, of what is to be robust.
    """

    problem: Problem
    search: SearchResult
    searches: tuple[SearchResult, ...]
    again: Verification
    prices: tuple[Price, ...]
    verdict: Verdict
    first: DesignOutcome | None
    solved: tuple[DesignOutcome, ...]
    wall: float
    robust: tuple[RobustnessCheck, ...] = ()

    @property
    def design(self) -> DesignOutcome:
        """The design as the search had it."""
        assert self.search.best is not None
        return self.search.best

    @property
    def variables(self) -> dict[str, float]:
        """Variable -> its value."""
        return dict(zip(self.problem.variables, map(float, self.design.design), strict=True))

    @property
    def numbers(self) -> dict[str, float]:
        """Numbers of the scene, as `Model.at` takes them: a variable that moves several is the first of them here."""
        return self.problem.numbers(self.design.design)

    @property
    def objective(self) -> float:
        """The objective as the study states it."""
        return float(self.search.program.objective(self.design.values)[0])

    @property
    def optimality(self) -> float:
        """KKT residual in parts of the objective's scale, or of its largest derivative."""
        assert self.search.optimality is not None
        return self.search.optimality.residual

    @property
    def gain(self) -> float | None:
        """What is left to gain by curvature and slopes, in parts of the objective; None where the objective tells no curvature."""
        return _gain(self.problem, self.search)

    @property
    def values(self) -> dict[str, float]:
        """Response, with its case before it where cases have names -> value of the run with finer steps, or of the search without one."""
        found = {
            label: float(value)
            for k, name in enumerate(self.problem.responses)
            for label, value in zip(by_case(self.problem.cases, name), self.design.values[:, k], strict=True)
        }
        for case, result in self.again.results.items():
            found |= {by_case([case], name)[0]: float(value) for name, value in result.values.items()}
        return found

    @property
    def units(self) -> dict[str, str]:
        """Response, with its case -> label of its unit."""
        known = dict.fromkeys([*self.problem.responses, *(name for each in self.again.results.values() for name in each.values)])
        return {label: self.problem.unit_of(name) for name in known for label in by_case(self.problem.cases, name)}

    @property
    def values_before(self) -> dict[str, float]:
        """What objective and constraints look at where the scene stands; empty if that cannot be solved."""
        if self.first is None:
            return {}
        names = [by_case(self.problem.cases, name) for name in self.problem.responses]
        return {
            label: float(value)
            for labels, values in zip(names, self.first.values.T, strict=True)
            for label, value in zip(labels, values, strict=True)
        }

    @property
    def history(self) -> tuple[list[str], list[list[Any]]]:
        """Head and rows of a table of all designs in the order in which every search solved them: number of the search and of its design,
        variables, responses, and why it failed."""
        labels = [by_case(self.problem.cases, name) for name in self.problem.responses]
        head = ["search", "design", *self.problem.variables, *(label for each in labels for label in each), "failed because"]
        rows = []
        for k in range(len(self.searches)):
            solved = [each for each in self.solved if each.lane // 2 == k]
            for number, each in enumerate(solved, 1):
                values = [""] * (len(head) - 3 - len(each.design)) if each.failed else each.values.T.ravel().tolist()
                rows.append([k + 1, number, *each.design.tolist(), *values, each.reason])
        return head, rows

    @property
    def scene(self) -> Scene:
        """The scene at the optimum, in the first case: `compile` takes it."""
        return scene_at(self.problem, next(iter(self.problem.cases)), self.design.design)

    def before_and_after(self) -> dict[str, Solution]:
        """Runs of the first case: "before", where the scene stands, if that can be solved, and "after", at the optimum."""
        case = next(iter(self.problem.cases))
        found = {}
        if self.first is not None:
            found["before"] = solve(prepare(scene_at(self.problem, case, self.first.design)), self.problem.kind)
        if case in self.again.results:
            found["after"] = self.again.results[case].solution
        return found

    @property
    def said(self) -> list[str]:
        """The distance to snap-through, and what it took, as sentences."""
        lines = []
        for case, (factor, found) in self.again.margins.items():
            where = f"{case}: " if case else ""
            lines.append(
                f"{where}snaps through at {factor:.4g} times the load."
                if found
                else f"{where}nothing snaps through up to {factor:.4g} times the load."
            )
        for each in self.robust:
            unit, (mean, sigma) = self.units.get(f"mean of {each.name}", ""), each.judged
            lines.append(f"{each.name}, by values and gradients: mean {mean:.6g}, sigma {sigma:.4g} {unit}".rstrip() + ".")
        return [*lines, f"{self.evaluations} designs, {self.failed} of which could not be solved, in {self.wall:.1f} s."]

    @property
    def evaluations(self) -> int:
        """Designs that were solved."""
        return sum(each.evaluations for each in self.searches)

    @property
    def failed(self) -> int:
        """How many of them could not be."""
        return sum(each.failed for each in self.searches)

    @property
    def success(self) -> bool:
        """Whether it is an optimum: feasible, stationary, and found again along the path from the unloaded state."""
        return not set(self.verdict.codes) & {"not-optimal", "infeasible", "not-found-again"}

    def _wall_of(self, search: SearchResult) -> float:
        return sum(each.seconds for each in self.solved if each.lane == search.lane)

    def check(self) -> None:
        """Raise what is to be said if it is no optimum.

        Raises
        ------
        NoOptimumError
            Says what is missing.
        """
        if not self.success:
            why = [each.text for each in self.verdict.warnings if each.code in ("not-optimal", "infeasible", "not-found-again")]
            raise NoOptimumError("no optimum was found: " + " ".join(why))

    def record(self) -> Record:
        """The JSON object."""
        name, unit = objective_of(self.search.program)
        margins = {case: {"load_factor": value, "found": found} for case, (value, found) in self.again.margins.items()}
        values, units = self.values, self.units
        return {
            "success": self.success,
            "objective": {"of": name, "value": self.objective, "unit": unit},
            "optimum": {
                "variables": self.variables,
                "responses": {each: {"value": values[each], "unit": units[each]} for each in values},
                "multipliers": [each.record() for each in self.prices],
                "snap_through": margins.get("", margins) or None,
                "changes_by_finer_steps": self.again.changes,
                "robust": {each.name: each.record() for each in self.robust} or None,
            },
            "optimality": self.optimality,
            "gain": self.gain,
            "violation": self.search.optimality.violation if self.search.optimality else None,
            "evaluations": self.evaluations,
            "failed": self.failed,
            "wall_s": self.wall,
            "searches": [{**_search_record(self.problem, each), "wall_s": self._wall_of(each)} for each in self.searches],
            **self.verdict.record(),
        }


def _search_record(problem: Problem, found: SearchResult) -> Record:
    best, left = found.best, found.optimality
    return {
        "start": dict(zip(problem.variables, map(float, found.start), strict=True)),
        "variables": None if best is None else dict(zip(problem.variables, map(float, best.design), strict=True)),
        "objective": None if best is None else float(found.program.objective(best.values)[0]),
        "optimality": None if left is None else left.residual,
        "gain": _gain(problem, found),
        "violation": None if left is None else left.violation,
        "evaluations": found.evaluations,
        "failed": found.failed,
        "arrived": found.arrived,
        "ended": found.ended,
    }


def _gain(problem: Problem, found: SearchResult) -> float | None:
    return found.optimality.gain if problem.curved and found.optimality else None
