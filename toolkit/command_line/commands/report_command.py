"""The command `ffrf report`: everything about a scene on one page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from toolkit.command_line.announcements import Progress, at_work, bar
from toolkit.command_line.arguments import Changes, read, split
from toolkit.command_line.keeping import Models, SceneOrResults, check_options, is_results, text_of
from toolkit.command_line.printing import prepare_folder, warn
from toolkit.foundation.terminal import AsJson, Quiet, print_json

if TYPE_CHECKING:
    from toolkit.report.material import ReportMaterial
    from toolkit.scene.scene import Scene

PARTS = ("forward-difference", "central-difference", "complex-step", "certificate", "figures", "animation")
"""Parts of a report that take time, in the order of the work."""


def report(
    file: SceneOrResults,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder of the report.")] = Path("report"),
    judges: Annotated[
        bool | None,
        typer.Option(
            "--judges/--no-judges",
            help="Compute the gradients by differences and complex step too; by default where it takes seconds.",
        ),
    ] = None,
    changes: Changes = None,
    models: Models = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Write a page with figures, tables and numbers about a scene or its results."""
    from toolkit.render.packages import require

    require("matplotlib")  # which the report imports
    from toolkit.report.write import refuse_foreign_files, write_report

    check_options(file, changes, models)
    refuse_foreign_files(output, file)
    material = _from_results(file, models) if is_results(file) else _from_scene(file, changes, quiet)
    folder = prepare_folder(output)
    with bar("report", quiet) as progress:
        if judges is not False and not is_results(file):
            from toolkit.report.material import judge

            material = judge(material, _part(progress), everything=bool(judges))
        path = write_report(material, folder, title_of(file), _part(progress))
    verdict = material.results.verdict
    if as_json:
        print_json({"report": str(path), **verdict.record()})
    else:
        typer.echo(str(path))
    warn(verdict, quiet)


def title_of(file: Path) -> str:
    """Title of the page: name of the scene, or of its folder where its file is called scene or results."""
    name = file.resolve().parent.name if file.stem in ("scene", "results") else file.stem
    return f"{name[:1].upper()}{name[1:]}".replace("_", " ")


def _refuse_undrawn(scene: Scene) -> None:
    """Refuse a scene that cannot be drawn on this machine, before anything long is computed."""
    from toolkit.render.pictures import refuse_what_cannot_be_drawn
    from toolkit.render.readable_units import View

    refuse_what_cannot_be_drawn(scene, View())


def _from_results(file: Path, models: Path | None) -> ReportMaterial:
    from toolkit.analyses.sensitivity.run import restored
    from toolkit.files.results_file import load_results
    from toolkit.report.material import ReportMaterial

    results = load_results(file)
    solution = restored(results, models).solution
    _refuse_undrawn(solution.system.scene)
    return ReportMaterial(solution, results)


def _from_scene(file: Path, changes: list[str] | None, quiet: bool) -> ReportMaterial:
    from toolkit.analyses.sensitivity.methods import gradients_by, with_frames_for_gradients
    from toolkit.files.results import collect
    from toolkit.report.material import ReportMaterial

    scene, text = read(file, changes, quiet), text_of(file)
    _refuse_undrawn(scene)
    names = list(scene.design)
    with at_work("time steps", scene, "transient", names, quiet) as progress:
        framed = with_frames_for_gradients(scene, "transient", names)
        found = gradients_by("direct", framed, names, "transient", progress, timed=True)
    return ReportMaterial(found.solution, collect(found, text, dict(split(change) for change in changes or [])))


def _part(progress: Progress):
    """Progress function for named parts on one bar, of which each part takes the same share."""

    def moved(part: str, done: int, total: int) -> None:
        progress(100 * PARTS.index(part) + round(100 * done / total), 100 * len(PARTS))

    return moved
