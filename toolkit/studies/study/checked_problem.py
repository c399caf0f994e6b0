"""A study with its scene, checked: everything that can be wrong is found here, before anything is solved."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from toolkit.description.design import CommonVariable
from toolkit.foundation.errors import InputError
from toolkit.responses.load_margin import LoadMargin
from toolkit.scene.changed_numbers import with_numbers
from toolkit.scene.design_variables import refuse_wrong_variables
from toolkit.scene.names import check_design_names, check_names
from toolkit.scene.scene import Scene
from toolkit.scene_file.reader import read_scene
from toolkit.sensitivity.frames_for_gradients import with_frames_for_gradients
from toolkit.sensitivity.preparation import responses_of
from toolkit.studies.distributions.uncertain_numbers import Uncertain
from toolkit.studies.study.problem import Problem
from toolkit.studies.study.refusals import refuse_robust_margin, refuse_unknown
from toolkit.studies.study.study_file import LOAD_MARGIN, Study, StudyVariable
from toolkit.studies.study.uncertain_points import uncertain_points
from toolkit.studies.study.wanted import in_norm, kind_of, norm_of, wants_points


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
