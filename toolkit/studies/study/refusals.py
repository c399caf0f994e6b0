"""Names in a study that lead to no response, and what cannot be asked of one."""

from __future__ import annotations

from collections.abc import Mapping

from toolkit.foundation.errors import InputError
from toolkit.foundation.listed_names import listed, meant
from toolkit.responses.load_margin import LoadMargin
from toolkit.scene.scene import Scene
from toolkit.sensitivity.preparation import responses_of
from toolkit.studies.study.study_file import LOAD_MARGIN, Study
from toolkit.studies.study.wanted import in_norm, kind_of, mode_of, norm_of, number_of


def refuse_unknown(study: Study, scene: Scene, places: Mapping[str, str]) -> None:
    """Refuse responses that the analysis does not have; `places` are the keys that name them."""
    statics = kind_of(study) == "static"
    known = responses_of(scene, moving=not statics)
    built_in = ([LOAD_MARGIN] if statics else []) + (["frequency_1", "frequency_2", "..."] if study.analysis == "modes" else [])
    for asked, place in places.items():
        name = _without_norm(study, asked, place)
        if name == LOAD_MARGIN:
            _refuse_no_margin(study, scene, place)
        elif mode_of(study, name) is not None:
            _refuse_no_mode(study, scene, name)
        elif name not in known:
            _refuse_frequency(study, name, place)
            why = f"{study.analysis} does not have it" if name in scene.responses else "there is none of that name"
            why += meant(name, [*known, *built_in])
            raise InputError(
                f"{place}: no response {name!r}, {why}; possible here: {listed([*known, *built_in])}. Others can "
                "be written in the study's table [responses]."
            )
        elif isinstance(scene.responses[name], LoadMargin):
            raise InputError(
                f"{place}: {name!r} does not exist where nothing snaps through. Write {LOAD_MARGIN}, which is built in."
            )


def _without_norm(study: Study, asked: str, place: str) -> str:
    """The response itself of a gradient whose norm is asked for."""
    name, limit = in_norm(asked), study.constraints.get(asked)
    if name is None:
        return asked
    if name == LOAD_MARGIN:
        raise InputError(f"{place}: the load margin is looked for up to a load factor, and cut off there: its gradient leaps.")
    if (inner := in_norm(name)) is not None:
        raise InputError(
            f"{place}: {asked!r} asks for the gradient of a gradient's norm, which would be differences of differences. Write "
            f"{norm_of(inner)!r}."
        )
    if (limit is not None and limit.robust is not None) or (
        study.objective.robust is not None and asked in study.objective.weights
    ):
        raise InputError(f"{place}: norms of gradients are those at the means of uncertain numbers. Leave out `robust`.")
    return name


def _refuse_frequency(study: Study, name: str, place: str) -> None:
    """Refuse a frequency that only modes have built in."""
    if (number := number_of(name)) is None:
        return
    raise InputError(
        f'{place}: {name!r} is built in where analysis = "modes", but the analysis is {study.analysis!r}. Write analysis = "modes", or '
        f'in the study\'s table [responses] one of your own, {{ type = "frequency", number = {number} }}, which counts by their order.'
    )


def _refuse_no_mode(study: Study, scene: Scene, name: str) -> None:
    if name in scene.responses:
        raise InputError(f"responses.{name} is built in where analysis = {study.analysis!r}. Give this one another name.")
    if scene.solver.equilibrium == "spinning":
        raise InputError(
            'analysis: modes are followed about an equilibrium at rest, but the scene\'s solver.equilibrium is "spinning". Write '
            f'analysis = "statics", and instead of {name} a response {{ type = "frequency", number = {number_of(name)} }}.'
        )


def _refuse_no_margin(study: Study, scene: Scene, place: str) -> None:
    if LOAD_MARGIN in scene.responses and not isinstance(scene.responses[LOAD_MARGIN], LoadMargin):
        raise InputError(f"{place}: {LOAD_MARGIN} is built in, but the scene calls another response so. Rename that one.")
    if kind_of(study) != "static" or scene.solver.equilibrium == "spinning" or scene.solver.continuation != "load":
        raise InputError(
            f'{place}: the load margin is that of an equilibrium at rest on a path that has not turned back. Write analysis = "statics", '
            'with the scene\'s solver.equilibrium = "rest" and solver.continuation = "load", or leave it out.'
        )


def refuse_robust_margin(study: Study) -> None:
    limit, why = (
        study.constraints.get(LOAD_MARGIN),
        "the load margin is looked for up to a load factor, and cut off there: it has no mean",
    )
    if limit is not None and limit.robust is not None:
        raise InputError(f"constraints.{LOAD_MARGIN}: {why}. Leave out `robust`; the limit is kept at the means of [uncertain].")
    if study.objective.robust is not None and LOAD_MARGIN in study.objective.weights:
        raise InputError(f"objective: {why}. Leave out `robust`, or choose another response.")
