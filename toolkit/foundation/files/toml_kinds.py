"""Scenes, studies and files of flexible bodies are taken for one another: told apart by their first keys, with what takes each."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from toolkit.foundation.errors import InputError

Kind = Literal["scene", "study", "body"]

OF_SCENES = {"bodies", "joints", "loads"}
OF_BODIES = {"airfoil", "mesh", "matrices", "beams"}
OF_STUDIES = {"variables", "objective", "analysis", "uncertain", "constraints"}
NAMES: dict[Kind, str] = {"scene": "a scene", "study": "a study", "body": "a file that a reduced model is built from"}


def refuse_other(table: Mapping[str, Any], path: Path, wanted: Kind) -> None:
    """Refuse a file of another kind, before all its keys are unknown.

    Raises
    ------
    InputError
        It says what the file is, and what to type.
    """
    kind = _kind(table)
    if kind is None or kind == wanted:
        return
    told = (
        f"{path.name} is a study of the scene {str(table['scene'])[:80]!r}"
        if kind == "study"
        else f"{path.name} is {NAMES[kind]}"
    )
    raise InputError(f"{told}, not {NAMES[wanted]}. {_ADVICE[wanted, kind](path)}")


def _kind(table: Mapping[str, Any]) -> Kind | None:
    """Kind of a file, "scene", "study" or "body"; None if its keys do not say."""
    if table.keys() & OF_SCENES:
        return "scene"
    if "scene" in table and table.keys() & OF_STUDIES:
        return "study"
    return "body" if table.keys() & OF_BODIES and "responses" not in table else None


def _of_study(path: Path) -> str:
    return f"`ffrf optimize {path}`, `ffrf sweep` and `ffrf uncertainty` take it"


def _where_a_study_is(path: Path) -> str:
    beside = path.with_name("study.toml")
    if beside.is_file():
        return f"Beside it is a study: give {beside}."
    return (
        f"A study is a file of its own, which begins with scene = {path.name!r} and says under [variables] which numbers may be changed; "
        "`ffrf new wing` writes one."
    )


_ADVICE = {
    ("scene", "study"): lambda path: f"Give that scene here; {_of_study(path)}.",
    ("scene", "body"): lambda path: (
        f"Build its reduced model with `ffrf-preprocess {path}`, and name that as the model of a body in a scene."
    ),
    ("study", "scene"): _where_a_study_is,
    ("study", "body"): lambda path: (
        f"Build its reduced model with `ffrf-preprocess {path}`, for a scene of which a study says what may be changed."
    ),
    ("body", "scene"): lambda path: (
        f"Analyse it with `ffrf simulate {path}`; what is built here are the files that describe its flexible bodies."
    ),
    ("body", "study"): lambda path: f"What is built here are the files that describe flexible bodies; {_of_study(path)}.",
}
"""Advice by (kind that was wanted, kind that is there): what to do."""
