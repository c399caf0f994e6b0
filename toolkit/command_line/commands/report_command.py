"""The command `ffrf report`: everything about a scene on one page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from toolkit.command_line.announcements import Progress, at_work, bar
from toolkit.command_line.arguments import Changes, prepare_folder, read, split
from toolkit.command_line.keeping import Models, SceneOrResults, check_options, is_results, text_of
from toolkit.command_line.printed.printing import warn
from toolkit.foundation.errors import InputError
from toolkit.foundation.terminal import AsJson, Quiet, print_json

if TYPE_CHECKING:
    from toolkit.report.material import Material

PARTS = ("forward-difference", "central-difference", "complex-step", "certificate", "figures", "animation")
"""What a report's time goes to, in the order of the work."""


def report(
    file: SceneOrResults,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder of the report.")] = Path("report"),
    judges: Annotated[
        bool, typer.Option(help="Compute the gradients by differences and complex step too; seconds per variable.")
    ] = True,
    changes: Changes = None,
    models: Models = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Write a page with figures, tables and numbers about a scene or its results."""
    from toolkit.render.packages import require

    require("matplotlib")
    from toolkit.report.write import write_report

    check_options(file, changes, models)
    material = _from_results(file, models) if is_results(file) else _from_scene(file, changes, quiet)
    folder = prepare_folder(output)
    with bar("report", quiet) as progress:
        if judges and not is_results(file):
            from toolkit.report.material import judge

            material = judge(material, _part(progress))
        path = write_report(material, folder, f"Report of {file.name}", _part(progress))
    verdict = material.results.verdict
    if as_json:
        print_json({"report": str(path), **verdict.record()})
    else:
        typer.echo(str(path))
    warn(verdict, quiet)


def refuse_space(dimension: int, file: Path) -> None:
    """Refuse scenes in space before anything is computed.

    Raises
    ------
    InputError
        The scene is not planar; says which commands show one in space.
    """
    from toolkit.scene.space import SPACES

    if dimension not in SPACES or not SPACES[dimension].reported:
        raise InputError(
            f"{file.name!r} is a scene in space, and the figures of a report are planar. ffrf render {file.name} --animate draws it with "
            "its curves, ffrf simulate --output FILE.h5 and ffrf export FILE.h5 --paraview DIR make a time series of it."
        )


def _from_results(file: Path, models: Path | None) -> Material:
    from toolkit.report.material import Material
    from toolkit.results.restore import restore_solution
    from toolkit.results.results_file import load_results

    results = load_results(file)
    refuse_space(int(results.scene.table.get("dimension", 2)), file)
    return Material(restore_solution(results, models), results)


def _from_scene(file: Path, changes: list[str] | None, quiet: bool) -> Material:
    from toolkit.report.material import Material
    from toolkit.results.collect import collect
    from toolkit.sensitivity.clock import repeated
    from toolkit.sensitivity.direct import direct

    scene, text = read(file, changes, quiet), text_of(file)
    refuse_space(scene.dimension, file)
    names = list(scene.design)
    with at_work("time steps", scene, "transient", names, quiet) as progress:
        found = direct(scene, names, "transient", progress, repeated)
    return Material(found.solution, collect(found, text, dict(split(change) for change in changes or [])))


def _part(progress: Progress):
    """One bar for all parts: each is a hundredth of its share."""

    def moved(part: str, done: int, total: int) -> None:
        progress(100 * PARTS.index(part) + round(100 * done / total), 100 * len(PARTS))

    return moved
