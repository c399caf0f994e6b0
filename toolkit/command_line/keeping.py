"""Results files on the command line: where a run is kept, and a kept run instead of a new one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from toolkit.command_line.announcements import Kind, at_work
from toolkit.command_line.arguments import read, split
from toolkit.foundation.errors import InputError

if TYPE_CHECKING:
    from toolkit.analyses.sensitivity.run import Run
    from toolkit.scene.scene import Scene
    from toolkit.system.solution import Solution

Output = Annotated[
    Path | None, typer.Option("--output", metavar="FILE.h5", help="Keep states, stress, responses and gradients in this file.")
]
SceneOrResults = Annotated[
    Path,
    typer.Argument(metavar="FILE", help="A scene (.toml), or results that --output kept (.h5), which are not computed again."),
]
Models = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Folder of the reduced models of a results file, if they are not where they were."),
]


def check_output(path: Path | None, scene: Scene) -> None:
    """Refuse a path for results that is unsuitable, or that the scene begins from, before anything long begins."""
    if path is not None:
        from toolkit.files.results_file import refuse_foreign, refuse_own_start

        refuse_foreign(path)
        refuse_own_start(path, scene.start_file)


def keep(found: Run, path: Path | None, text: str, changes: list[str] | None, quiet: bool = False) -> None:
    """Write the results file, if one was asked for, and report where it is."""
    if path is None:
        return
    from toolkit.files.results_file import save_results

    save_results(found, path, text, dict(split(change) for change in changes or []))
    if not quiet:
        typer.echo(f"results are in {path}; ffrf inspect {path} tells what they are.", err=True)


def text_of(path: Path) -> str:
    """Content of a scene's file that was just read."""
    return path.read_text(encoding="utf-8")


def is_results(path: Path) -> bool:
    """Whether a file is to be read as results: anything that is no scene."""
    return path.suffix != ".toml"


def check_options(file: Path, changes: list[str] | None, models: Path | None) -> None:
    """Refuse a folder, changes of results, and a folder of models with a scene.

    Raises
    ------
    InputError
        What was given is invalid, or does not go together.
    """
    if file.is_dir():
        raise InputError(
            f"{str(file)!r} is a folder. Give the path of a scene (.toml) in it, or of results that --output kept (.h5)."
        )
    if changes and is_results(file):
        raise InputError(f"{str(file)!r} holds the results of a finished run, which --set cannot change. Give the scene instead.")
    if models is not None and not is_results(file):
        raise InputError("--models belongs to a results file; a scene says itself where its models are. Leave it out.")


def motion_of(
    file: Path,
    changes: list[str] | None,
    models: Path | None,
    quiet: bool = False,
    check: Callable[[Scene], None] = lambda _: None,
    static: bool = False,
) -> Callable[[], Solution]:
    """Function that returns the motion of a checked file: results, read now, or a scene, solved when it is called.

    `check` refuses a scene that cannot be used, before it is solved; `static` asks for its equilibrium instead of its motion.
    """
    check_options(file, changes, models)
    if static and is_results(file):
        raise InputError(f"{str(file)!r} holds the results of a finished run: leave --static out, or give the scene.")
    if is_results(file):
        from toolkit.analyses.sensitivity.run import load

        solution = load(file, models).solution
        check(solution.system.scene)
        return lambda: solution
    scene = read(file, changes, quiet)
    check(scene)
    return lambda: solved(scene, "static" if static else "transient", quiet)


def refuse_contrary(static: bool, free_motions: bool, animate: bool, film: bool, times: list[float] | None) -> None:
    """Refuse options of a motion beside those that draw none, which would be taken and do nothing.

    Raises
    ------
    InputError
        They contradict each other.
    """
    if static and (animate or film or times or free_motions):
        raise InputError("--static draws one equilibrium: leave --animate, --film, --time and --free-motions out, or --static.")
    if free_motions and film:
        raise InputError("--free-motions are drawn one by one: leave --film out.")


FRAMES_OF_FREE_MOTION = 20
"""Frames of a free motion that is animated."""


def free_motions_of(file: Path, changes: list[str] | None, times: list[float] | None, frames: int) -> Callable[[], Solution]:
    """Function that returns the free motions of a scene, each in so many states."""
    if is_results(file) or times:
        raise InputError(
            "--free-motions are those of a scene as it is given, without times. Give a scene (.toml), and leave --time out."
        )

    def found() -> Solution:
        from toolkit.analyses.sensitivity.chosen_frames import automatic, with_frames
        from toolkit.analyses.sensitivity.preparation import prepare
        from toolkit.analyses.statics import free_motion_states

        scene = read(file, changes, True)
        whole = dict.fromkeys(automatic(scene), 1)  # nothing deforms: one frame shows it
        return free_motion_states(prepare(with_frames(scene, whole), []), frames)

    return found


def solved(scene: Scene, kind: Kind, quiet: bool) -> Solution:
    """Motion or equilibrium of a scene, with a progress bar; judged as `ffrf simulate` and `ffrf statics` judge it."""
    from toolkit.api.model import compile_model

    with at_work("load steps" if kind == "static" else "time steps", scene, kind, quiet=quiet) as progress:
        found = compile_model(scene).run(kind, progress=progress)
    return replace(found.solution, judge=lambda _: found.verdict)
