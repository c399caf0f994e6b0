"""Mean and standard deviation at an optimum, found out anew: the points that the search took are few."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.verdict import Caution
from toolkit.scene.changed_numbers import with_numbers
from toolkit.studies.distributions.sobol_points import scrambled
from toolkit.studies.engine.outcome import DesignOutcome
from toolkit.studies.study.problem import Problem, by_case
from toolkit.studies.study.study_file import LOAD_MARGIN
from toolkit.studies.study.wanted import Statistic
from toolkit.studies.uncertainty.find_uncertainty import find_uncertainty
from toolkit.studies.uncertainty.uncertain_result import UncertainResult
from toolkit.studies.uncertainty.uncertain_study import uncertain_study

SAMPLES = 2**14
"""Points at which polynomials with gradients are looked at."""
SETTLED = 0.05
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
        near = SETTLED * max(self.judged[1], self.searched[1])
        return all(abs(a - b) <= near for a, b in zip(self.searched, self.judged, strict=True))

    def record(self) -> dict[str, Any]:
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
                f"{other_sigma:.4g} by values and gradients (limit {SETTLED:.0%} of sigma). Give more uncertainty.points.",
            )


def _doubts(judge: UncertainResult) -> Iterator[Caution]:
    """What speaks against the polynomials that judge; what the runs say is said of the optimum itself."""
    known = ("failed-designs", "polynomials", "degree", "extrapolated", "monte-carlo")
    yield from (
        Caution(each.code, f"around the optimum: {each.text}", each.doubt)
        for each in judge.verdict.warnings
        if each.code in known
    )
