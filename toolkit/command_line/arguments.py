"""What a user writes on the command line: the scene, its changed values, the names of variables and methods."""

from __future__ import annotations

import fnmatch
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer

from toolkit.command_line import completion
from toolkit.foundation.errors import InputError, listed
from toolkit.foundation.files.safe_files import told_outside

if TYPE_CHECKING:
    from toolkit.description.description import Description
    from toolkit.scene.scene import Scene

Table = TypeVar("Table", bound="Description")

EVERY = "all"
"""Stands for every number of the scene, unless the scene declares a design variable of that name."""


SceneFile = Annotated[Path, typer.Argument(metavar="SCENE.toml", help="The scene.")]
Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="PATH=VALUE", help="Replace a value of the scene, e.g. points.A.x=73.", autocompletion=completion.changes
    ),
]
Variables = Annotated[
    str | None,
    typer.Option(
        metavar="t_w,x_A,...",
        help="Short names or paths, or `all` numbers of the scene; by default all it declares.",
        autocompletion=completion.variables,
    ),
]
Static = Annotated[bool, typer.Option("--static", help="Of the static end state instead of the motion.")]
KeepAll = Annotated[
    bool,
    typer.Option(
        "--keep-all", help="Put back what the scene does not require: frames that rest, all file groups, all derivatives."
    ),
]
StudyFile = Annotated[Path, typer.Argument(metavar="STUDY.toml", help="The study.")]
Jobs = Annotated[int, typer.Option(min=1, help="How many designs are solved at once, each in a process of its own.")]
Dask = Annotated[
    str, typer.Option(metavar="ADDRESS", help="Dask scheduler whose workers solve the designs instead, e.g. tcp://10.0.0.1:8786.")
]


def read(path: Path, changes: list[str] | None, quiet: bool = False) -> Scene:
    """Scene with its changed values; a note lists what it takes from outside of its folder."""
    from toolkit.files.scene_reader import read_scene

    pairs = dict(split(change) for change in changes or [])
    scene = read_scene(path, pairs)
    if not quiet and (elsewhere := told_outside(path, scene.read_files())):
        typer.echo(f"note: {elsewhere}", err=True)
    return scene


def split(change: str) -> tuple[str, str]:
    """Path and value of `path=value`."""
    path, equals, value = (part.strip() for part in change.partition("="))
    if not (path and equals and value):
        raise typer.BadParameter(f"{change!r} is not of the form path=value, for example points.A.x=73.", param_hint="--set")
    return path, value


def with_options(table: str, kind: type[Table], wanted: Mapping[str, object]) -> Table:
    """Table of a study in which options of the command line replace values of the file.

    Raises
    ------
    InputError
        An option is out of its range, or contradicts another one.
    """
    from pydantic import ValidationError

    from toolkit.description.validation_messages import messages

    try:
        return kind.model_validate(wanted)
    except ValidationError as error:
        reasons = " ".join(messages(error, kind, wanted, "", {}))
        raise InputError(f"the options of the command line and the study's [{table}]: {reasons}") from error


def design_of(scene: Scene, names: str | None) -> list[str]:
    """Names of the design variables that were asked for.

    Raises
    ------
    InputError
        No variable is named, or none is named and the scene declares none.
    """
    chosen = list(scene.design) if names is None else [name.strip() for name in names.split(",") if name.strip()]
    if chosen == [EVERY] and EVERY not in scene.design:
        return scene.available_paths()
    if any("*" in name for name in chosen):
        chosen = [path for name in chosen for path in (_like(scene, name) if "*" in name else [name])]
    if not chosen:
        why = "the scene declares none in its table [design]" if names is None else "--variables names none"
        known = f"short names of the scene: {', '.join(scene.design)}; " if scene.design else ""
        raise InputError(
            f"no design variable: {why}. Name some with --variables; {known}available paths: {listed(scene.available_paths())}."
        )
    return chosen


def _like(scene: Scene, pattern: str) -> list[str]:
    """All paths that a pattern such as bodies.skin.thickness_* stands for."""
    found = fnmatch.filter(scene.available_paths(), pattern)
    if not found:
        raise InputError(f"no path is like {pattern!r}; available: {listed(scene.available_paths())}.")
    return found
