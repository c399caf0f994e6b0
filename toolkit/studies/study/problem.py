"""A study with its scene: everything that can be wrong is found here, before anything is solved."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from toolkit.description.design import CommonVariable
from toolkit.foundation.errors import InputError
from toolkit.foundation.listed_names import listed
from toolkit.responses.load_margin import LoadMargin
from toolkit.responses.response import Response
from toolkit.scene.changed_numbers import with_numbers
from toolkit.scene.names import check_names
from toolkit.scene.scene import Scene
from toolkit.scene_file.gradient_units import variable_unit
from toolkit.scene_file.reader import read_scene
from toolkit.sensitivity.compiled import Compiled
from toolkit.sensitivity.frames.chosen_frames import with_chosen_frames
from toolkit.sensitivity.preparation import Kind, responses_of
from toolkit.studies.study.study_file import LOAD_MARGIN, Study

FURTHER, FAR = 2.0, 10.0
"""Times the wanted load margin up to which a limit point is looked for; and load factor up to which, where the margin is the objective."""
ROUND_OFF = 1e-13
"""Relative change of a response that nothing has to have brought about."""
ONLY = ""
"""Name of the only case of a study that names none."""


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
    """

    study: Study
    scene: Scene
    asked: tuple[str, ...]

    @property
    def kind(self) -> Kind:
        """What is solved for every design."""
        return "static" if self.study.analysis == "statics" else "transient"

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
        return (*self.asked, LOAD_MARGIN) if self.margin_up_to is not None else self.asked

    @cached_property
    def margin_up_to(self) -> float | None:
        """Load factor up to which a limit point is looked for; None if nobody asks for it."""
        limit, wanted = self.study.constraints.get(LOAD_MARGIN), LOAD_MARGIN in self.study.objective.weights
        largest = max((abs(each) for each in limit.limits if each is not None), default=0.0) if limit else 0.0
        return max(FAR if wanted else FURTHER, FURTHER * largest) if limit or wanted else None

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
        chosen = {name: self.scene.responses[name] for name in self.asked}
        return Compiled(self.scene.model_copy(update={"responses": chosen}), self.variables)

    def numbers(self, design: np.ndarray) -> dict[str, float]:
        """Numbers of the scene for a design (n,)."""
        return dict(zip(self.variables, map(float, self.origin + design), strict=True))

    def undecided(self, response: str, values: np.ndarray) -> float:
        """How much of a response of such values round-off may decide: of a place or an angle also what Newton leaves undecided."""
        described, sizes = self.scene.responses.get(response), {"angle": 1.0, "length": self.scene.size}
        size = sizes.get(described.unit_quantity, 0.0) if isinstance(described, Response) else 0.0
        return ROUND_OFF * float(np.max(np.abs(values))) + self.scene.solver.tolerance * size

    def unit_of(self, response: str) -> str:
        """Label of the unit of a response."""
        if response == LOAD_MARGIN:
            return ""
        found = self.scene.responses[response]
        return found.unit(self.scene.units) if isinstance(found, Response) else ""

    def unit_of_variable(self, name: str) -> str:
        """Label of the unit of a variable."""
        return variable_unit(self.scene, self.scene.paths_of(name)[0])


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
    known = responses_of(problem.scene, moving=study.analysis != "statics")
    wanted = [name for name, each in known.items() if not isinstance(each, LoadMargin)] if chosen is None else chosen
    named = {name: where for name in wanted}
    if not named:
        raise InputError(
            f"the scene has no response that {study.analysis} could have. Write some in the study's table [responses]."
        )
    _refuse_unknown(study, problem.scene, named)
    names = tuple(name for name in named if name != LOAD_MARGIN)
    if LOAD_MARGIN in named and problem.margin_up_to is None:
        raise InputError(f"{where}: {LOAD_MARGIN} needs to know how far to look. Write a limit for it under [constraints].")
    return replace(problem, asked=tuple(dict.fromkeys([*names, *problem.asked])))


def checked(study: Study, scene: Scene | None = None, table: str = "variables") -> Problem:
    """A study with its scene, as far as all its purposes have it in common."""
    if not isinstance(study, Study):
        raise InputError(f"a study is what `read_study` returns, or a Study made in Python, not {type(study).__name__}.")
    if not study.variables:
        raise InputError("variables is empty: write [variables] with numbers of the scene, and between which bounds they may be.")
    scene = read_scene(study.directory / study.scene) if scene is None else scene
    scene = with_chosen_frames(scene, "static" if study.analysis == "statics" else "transient")
    _refuse_known("responses", study.responses, scene.responses, "a response of that name stands in the scene already.")
    if LOAD_MARGIN in study.responses:
        raise InputError(f"responses.{LOAD_MARGIN} is built in. Leave it out.")
    several = {name: CommonVariable(of=each.of, factors=each.factors) for name, each in study.variables.items() if each.of}
    _refuse_known(table, several, scene.design, "the scene has a variable of that name already.")
    updated = {"responses": {**scene.responses, **study.responses}, "design": {**scene.design, **several}}
    scene = scene.model_copy(update=updated)
    check_names(scene.points, scene.bodies, scene.joints, scene.loads, scene.responses)
    _refuse_variables(study, scene, table)
    problem = Problem(study, scene, _asked(study, scene))
    _refuse_cases(problem)
    return problem


def _refuse_known(table: str, names: Iterable[str], known: Iterable[str], why: str) -> None:
    if (twice := next((name for name in names if name in set(known)), None)) is not None:
        raise InputError(f"{table}.{twice}: {why} Give this one another name.")


def _refuse_variables(study: Study, scene: Scene, table: str) -> None:
    """Refuse variables that lead nowhere, and two that drive the same number."""
    for name in study.variables:
        try:
            scene.design_variables([name])
        except InputError as error:
            raise InputError(f"{table}.{name}: {error}") from error
    try:
        scene.design_variables(list(study.variables))
    except InputError as error:
        raise InputError(f"{table}: {error}") from error


def _asked(study: Study, scene: Scene) -> tuple[str, ...]:
    """Responses that objective and constraints look at, all of which the analysis has."""
    places = {
        **dict.fromkeys(study.objective.weights, "objective"),
        **{name: f"constraints.{name}" for name in study.constraints},
    }
    _refuse_unknown(study, scene, places)
    return tuple(name for name in places if name != LOAD_MARGIN)


def _refuse_unknown(study: Study, scene: Scene, places: Mapping[str, str]) -> None:
    """Refuse responses that the analysis does not have; `places` are the keys that name them."""
    statics = study.analysis == "statics"
    known = responses_of(scene, moving=not statics)
    for name, place in places.items():
        if name == LOAD_MARGIN:
            _refuse_no_margin(study, scene, place)
        elif name not in known:
            why = f"{study.analysis} does not have it" if name in scene.responses else "there is none of that name"
            raise InputError(
                f"{place}: no response {name!r}, {why}; possible here: {listed([*known, *([LOAD_MARGIN] if statics else [])])}. Others can "
                "be written in the study's table [responses]."
            )
        elif isinstance(scene.responses[name], LoadMargin):
            raise InputError(
                f"{place}: {name!r} does not exist where nothing snaps through. Write {LOAD_MARGIN}, which is built in."
            )


def _refuse_no_margin(study: Study, scene: Scene, place: str) -> None:
    if LOAD_MARGIN in scene.responses and not isinstance(scene.responses[LOAD_MARGIN], LoadMargin):
        raise InputError(f"{place}: {LOAD_MARGIN} is built in, but the scene calls another response so. Rename that one.")
    if study.analysis != "statics" or scene.solver.equilibrium == "spinning" or scene.solver.continuation != "load":
        raise InputError(
            f'{place}: the load margin is that of an equilibrium at rest on a path that has not turned back. Write analysis = "statics", '
            'with the scene\'s solver.equilibrium = "rest" and solver.continuation = "load", or leave it out.'
        )


def _refuse_start_outside(problem: Problem) -> None:
    for name, value, low, high in zip(problem.variables, problem.start, *problem.bounds, strict=True):
        if not low <= value <= high:
            raise InputError(
                f"variables.{name}: the scene stands at {value:.6g}, which is not between {low:g} and {high:g}. Widen the bounds, or begin "
                "elsewhere by changing the scene."
            )


def _refuse_cases(problem: Problem) -> None:
    """Refuse cases that set what a variable drives, or what is no number of the scene."""
    driven = {path: name for name in problem.variables for path in problem.scene.paths_of(name)}
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


def by_case(cases: Iterable[str], name: str) -> list[str]:
    """A response's name in every case: with the case before it where cases have names."""
    return [f"{case}.{name}" if case else name for case in cases]
