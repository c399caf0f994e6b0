"""A study with its scene, checked: everything that can be wrong is found here, before anything is solved."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from toolkit.analyses.sensitivity.compiled import Compiled
from toolkit.analyses.sensitivity.methods import with_frames_for_gradients
from toolkit.analyses.sensitivity.preparation import Kind, responses_of
from toolkit.description.design import CommonVariable
from toolkit.files.gradient_units import variable_unit
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError
from toolkit.responses.least_frequency import LoadMargin
from toolkit.responses.response import MeanSquare, Response
from toolkit.responses.vibration import Frequency
from toolkit.scene.changed_numbers import with_numbers
from toolkit.scene.design_variables import refuse_wrong_variables
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene, check_design_names, check_names
from toolkit.studies.distributions import Uncertain
from toolkit.studies.store import scene_fingerprint
from toolkit.studies.study_file import LOAD_MARGIN, Study, StudyVariable
from toolkit.studies.wanted import (
    OBJECTIVE,
    Statistic,
    UncertainPoints,
    Wanted,
    in_norm,
    kind_of,
    limits_of,
    mode_of,
    norm_of,
    refuse_robust_margin,
    refuse_unknown,
    statistics_of,
    uncertain_points,
    wants_points,
    weights_of,
)

MARGIN_SEARCH_FACTOR, LARGEST_LOAD_FACTOR = 2.0, 10.0
"""Times the wanted load margin up to which a limit point is looked for; and load factor up to which, where the margin is the objective."""
ROUND_OFF = 1e-13
"""Relative change of a response that nothing has to have brought about."""
ONLY = ""
"""Name of the only case of a study that names none."""
BUDGET = {"starts", "evaluations"}
"""Options of a search that change how many designs are solved, and no number of any."""
ELSEWHERE = {"search", "directory", "responses", "scene", "uncertain", "sweep", "uncertainty"}
"""Parts of a study that count otherwise in its fingerprint, or say only which designs are solved."""


@dataclass(frozen=True)
class Problem:
    """A checked study.

    Attributes
    ----------
    study
        As it was written.
    scene
        With all responses of scene and study, and with the variables that move several numbers.
    asked
        Responses that objective and constraints look at, without the load margin.
    points
        Of uncertain numbers, at all of which every design is solved; None if nothing is to be robust.
    norms
        Responses of which the norm of the gradient is asked.
    """

    study: Study
    scene: Scene
    asked: tuple[str, ...]
    points: UncertainPoints | None = None
    norms: tuple[str, ...] = ()

    @property
    def kind(self) -> Kind:
        """What is solved for every design."""
        return kind_of(self.study)

    @cached_property
    def modes(self) -> dict[str, int]:
        """Frequencies that are followed by the shapes of their modes -> their number where the scene stands."""
        return {name: number for name in self.asked if (number := mode_of(self.study, name)) is not None}

    @cached_property
    def shapes(self) -> dict[str, np.ndarray]:
        """Case -> shapes of these modes there, (n_q, modes), as far as they were asked for."""
        return {}

    @property
    def variables(self) -> tuple[str, ...]:
        """Names of the variables, in the order of all arrays."""
        return tuple(self.study.variables)

    @property
    def cases(self) -> dict[str, dict[str, float]]:
        """Name -> numbers that are others in this case."""
        return self.study.cases or {ONLY: {}}

    @property
    def responses(self) -> tuple[str, ...]:
        """All that is evaluated for a design, in the order of all arrays; the load margin is the last."""
        known = (*self.asked, *map(norm_of, self.norms), *self.statistics)
        return (*known, LOAD_MARGIN) if self.margin_up_to is not None else known

    @cached_property
    def labels(self) -> dict[str, tuple[int, int]]:
        """Response, with its case before it where cases have names -> place of case and response in the values of a design."""
        return {label: (i, j) for j, name in enumerate(self.responses) for i, label in enumerate(by_case(self.cases, name))}

    @cached_property
    def statistics(self) -> dict[str, Statistic]:
        """Name -> mean and deviation over uncertain numbers, as far as something is to be robust."""
        return {} if self.points is None else statistics_of(self.study)

    @cached_property
    def weights(self) -> Mapping[str, float]:
        """What the objective is the weighted sum of."""
        return weights_of(self.study, self.points is not None)

    @cached_property
    def squares(self) -> dict[str, MeanSquare]:
        """Mean squares that are to be small: they tell their curvature, by the derivatives of states that the study's method carries."""
        objective, carried = self.study.objective, self.kind == "static" or self.study.search.gradients == "direct"
        wanted = [name for name, weight in objective.weights.items() if carried and objective.sign * weight > 0]
        known = ((name, self.scene.responses.get(name)) for name in wanted)
        return {name: each for name, each in known if isinstance(each, MeanSquare)}

    @cached_property
    def curved(self) -> tuple[str, ...]:
        """What the objective is the weighted sum of, as far as its curvature is told: mean squares, or what is robust of them."""
        return tuple(name for name in self.weights if self.squares and (name in self.statistics or name in self.squares))

    @cached_property
    def limits(self) -> tuple[Wanted, ...]:
        """All limits."""
        return tuple(limits_of(self.study, self.points is not None))

    @cached_property
    def margin_up_to(self) -> float | None:
        """Load factor up to which a limit point is looked for; None if nobody asks for it."""
        limit, wanted = self.study.constraints.get(LOAD_MARGIN), LOAD_MARGIN in self.study.objective.weights
        largest = max((abs(each) for each in limit.limits if each is not None), default=0.0) if limit else 0.0
        return (
            max(LARGEST_LOAD_FACTOR if wanted else MARGIN_SEARCH_FACTOR, MARGIN_SEARCH_FACTOR * largest)
            if limit or wanted
            else None
        )

    @cached_property
    def bounds(self) -> np.ndarray:
        """Least and largest value of every variable, (2, n)."""
        return np.array([each.between for each in self.study.variables.values()]).T

    @cached_property
    def scales(self) -> np.ndarray:
        """What a large change of every variable is, (n,)."""
        ranges = self.bounds[1] - self.bounds[0]
        given = [each.scale for each in self.study.variables.values()]
        return np.array([r if s is None else s for r, s in zip(ranges, given, strict=True)])

    @cached_property
    def origin(self) -> np.ndarray:
        """What is added to the value of every variable to make it the scene's number: where it moves several, their present value."""
        moved = (self.scene.value_of(name) if each.of else 0.0 for name, each in self.study.variables.items())
        return np.array([float(each) for each in moved])

    @cached_property
    def start(self) -> np.ndarray:
        """Where the scene stands, (n,)."""
        return np.array([self.scene.value_of(name) for name in self.variables]) - self.origin

    @cached_property
    def compiled(self) -> Compiled:
        """The scene with the responses that are asked for, compiled with its variables."""
        chosen = {name: self.scene.responses[name] for name in self.asked if name not in self.modes}
        return Compiled(self.scene.model_copy(update={"responses": chosen}), self.variables)

    def numbers(self, design: np.ndarray) -> dict[str, float]:
        """Numbers of the scene for a design (n,)."""
        return dict(zip(self.variables, map(float, self.origin + design), strict=True))

    def undecided(self, response: str, values: np.ndarray) -> float:
        """How much of a response of such values round-off may decide: of a place or an angle also what Newton leaves undecided."""
        if (of := in_norm(response)) is not None:
            return self.undecided(of, values)
        if (several := self.statistics.get(response)) is not None:
            return sum(abs(weight) * self.undecided(name, values) for name, weight in several.weights.items())
        described, sizes = self.scene.responses.get(response), {"angle": 1.0, "length": loaded(self.scene).size}
        size = sizes.get(described.unit_quantity, 0.0) if isinstance(described, Response) else 0.0
        return ROUND_OFF * float(np.max(np.abs(values))) + self.scene.solver.tolerance * size

    def unit_of(self, response: str) -> str:
        """Label of the unit of a response."""
        response = self.statistics[response].of if response in self.statistics else in_norm(response) or response
        if response in (LOAD_MARGIN, OBJECTIVE):
            return ""
        if response in self.modes:
            return Frequency().unit(self.scene.units)
        found = self.scene.responses[response]
        return found.unit(self.scene.units) if isinstance(found, Response) else ""

    def unit_of_variable(self, name: str) -> str:
        """Label of the unit of a variable."""
        return variable_unit(self.scene, self.scene.paths_of(name)[0])

    @property
    def fingerprint(self) -> str:
        """Hash of study, scene, the files that it reads, and the program; more starts or evaluations leave it as it is.

        The order of variables, cases and responses counts: a store has arrays in that order.
        """
        study = self.study
        search = {key: value for key, value in study.search.model_dump(mode="json").items() if key not in BUDGET}
        rest = study.model_dump(mode="json", exclude=ELSEWHERE)
        cases = [(name, list(numbers.items())) for name, numbers in self.cases.items()]
        parts: list[Any] = [rest, search, self.variables, cases, self.responses]
        if self.points is not None:
            options = study.uncertainty.model_dump(mode="json", include={"correlations", "points", "seed"})
            parts += [[(name, each.model_dump(mode="json")) for name, each in study.uncertain.items()], options]
        return scene_fingerprint(self.scene, *parts)


def by_case(cases: Iterable[str], name: str) -> list[str]:
    """A response's name in every case: with the case before it where cases have names."""
    return [f"{case}.{name}" if case else name for case in cases]


def problem_of(study: Study, scene: Scene | None = None) -> Problem:
    """A study to be optimised with its scene, which is read unless it is given.

    Raises
    ------
    InputError
        A name is unknown, a start lies outside of its bounds, something contradicts something else, or there is no objective.
    """
    problem = checked(study, scene)
    if not study.objective.weights:
        raise InputError("objective is missing: write [objective] with `minimize` or `maximize`, and what is to be so.")
    _refuse_start_outside(problem)
    return problem


def problem_of_all(
    study: Study, scene: Scene | None = None, chosen: tuple[str, ...] | None = None, where: str = "", table: str = "variables"
) -> Problem:
    """A study of which many responses are asked, at designs that need not be near the one of the scene.

    Parameters
    ----------
    study
        What `read_study` returns, or a Study made in Python.
    scene
        By default the one that the study names.
    chosen
        Responses; by default all that the analysis has.
    where
        The key that names them.
    table
        The one of the study file that the variables stand in.

    Raises
    ------
    InputError
        As of `problem_of`, but for start and objective.
    """
    problem = checked(study, scene, table)
    known = responses_of(problem.scene, moving=problem.kind != "static")
    own = ["frequency_1"] if study.analysis == "modes" else []
    wanted = [*own, *(name for name, each in known.items() if not isinstance(each, LoadMargin))] if chosen is None else chosen
    named = {name: where for name in wanted}
    if not named:
        raise InputError(
            f"the scene has no response that {study.analysis} could have. Write some in the study's table [responses]."
        )
    if table != "variables" and any(in_norm(name) is not None for name in named):
        raise InputError(
            f"{where}: uncertain numbers have no scales by which the norm of a gradient could be measured. Leave it out."
        )
    refuse_unknown(study, problem.scene, named)
    names = tuple(in_norm(name) or name for name in named if name != LOAD_MARGIN)
    norms = _norms([*named, *map(norm_of, problem.norms)], table)
    if LOAD_MARGIN in named and problem.margin_up_to is None:
        raise InputError(f"{where}: {LOAD_MARGIN} needs to know how far to look. Write a limit for it under [constraints].")
    return replace(problem, asked=tuple(dict.fromkeys([*names, *problem.asked])), norms=norms)


def checked(study: Study, scene: Scene | None = None, table: str = "variables") -> Problem:
    """A study with its scene, as far as all its purposes have it in common."""
    if not isinstance(study, Study):
        raise InputError(f"a study is what `read_study` returns, or a Study made in Python, not {type(study).__name__}.")
    if not study.variables:
        raise InputError("variables is empty: write [variables] with numbers of the scene, and between which bounds they may be.")
    scene = read_scene(study.directory / study.scene) if scene is None else scene
    _refuse_known("responses", study.responses, scene.responses, "a response of that name stands in the scene already.")
    if LOAD_MARGIN in study.responses:
        raise InputError(f"responses.{LOAD_MARGIN} is built in. Leave it out.")
    scene = scene.model_copy(update={"responses": {**scene.responses, **study.responses}})
    scene = _with_several(scene, study.variables, table)
    check_names(scene.points, scene.bodies, scene.joints, scene.loads, scene.responses)
    refuse_wrong_variables(scene, study.variables, table)
    differentiated = study.variables if table == "variables" and study.analysis != "modes" else ()
    scene = with_frames_for_gradients(scene, kind_of(study), differentiated)
    points = None
    if table == "variables" and wants_points(study):
        refuse_robust_margin(study)
        scene = _with_several(scene, study.uncertain, "uncertain")
        refuse_wrong_variables(scene, study.uncertain, "uncertain")
        points = uncertain_points(study, scene)
    problem = Problem(study, scene, _asked(study, scene), points, _norms([*study.objective.weights, *study.constraints], table))
    _refuse_cases(problem)
    return problem


def _with_several(scene: Scene, named: Mapping[str, StudyVariable | Uncertain], table: str) -> Scene:
    """The scene with the variables that move several numbers."""
    several = {name: CommonVariable(of=each.of, factors=each.factors) for name, each in named.items() if each.of}
    _refuse_known(table, several, scene.design, "there is a variable of that name already.")
    check_design_names(several, table)
    return scene.model_copy(update={"design": {**scene.design, **several}})


def _refuse_known(table: str, names: Iterable[str], known: Iterable[str], why: str) -> None:
    if (twice := next((name for name in names if name in set(known)), None)) is not None:
        raise InputError(f"{table}.{twice}: {why} Give this one another name.")


def _refuse_start_outside(problem: Problem) -> None:
    for name, value, low, high in zip(problem.variables, problem.start, *problem.bounds, strict=True):
        if not low <= value <= high:
            raise InputError(
                f"variables.{name}: the scene stands at {value:.6g}, which is not between {low:g} and {high:g}. Widen the bounds, or begin "
                "elsewhere by changing the scene."
            )


def _refuse_cases(problem: Problem) -> None:
    """Refuse cases that set what a variable or an uncertain number drives, or what is no number of the scene."""
    own = () if problem.points is None else problem.points.names
    driven = {path: name for name in (*own, *problem.variables) for path in problem.scene.paths_of(name)}
    for case, numbers in problem.cases.items():
        for name in numbers:
            for path in problem.scene.paths_of(name):
                if path in driven:
                    raise InputError(
                        f"cases.{case}: {name!r} is driven by the variable {driven[path]!r}. A case sets what no variable drives."
                    )
        try:
            with_numbers(problem.scene, numbers)
        except InputError as error:
            raise InputError(f"cases.{case}: {error}") from error


def _asked(study: Study, scene: Scene) -> tuple[str, ...]:
    """Responses that objective and constraints look at, all of which the analysis has."""
    places = {
        **dict.fromkeys(study.objective.weights, "objective"),
        **{name: f"constraints.{name}" for name in study.constraints},
    }
    refuse_unknown(study, scene, places)
    return tuple(dict.fromkeys(in_norm(name) or name for name in places if name != LOAD_MARGIN))


def _norms(names: Iterable[str], table: str) -> tuple[str, ...]:
    """Responses of which the norm of the gradient is asked; uncertain numbers have no scales that it could be measured by."""
    found = tuple(dict.fromkeys(of for name in names if (of := in_norm(name)) is not None))
    return found if table == "variables" else ()
