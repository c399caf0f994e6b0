"""The command `ffrf optimize`: the best design of a study, what its limits cost, and whether it can be trusted."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from toolkit.command_line.announcements import bar, compile_before
from toolkit.command_line.arguments import StudyFile, with_options
from toolkit.command_line.output_folder import prepare_folder
from toolkit.command_line.printed.optimum_tables import print_optimum
from toolkit.command_line.printed.printing import print_answer
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.terminal import AsJson, Quiet, answered

if TYPE_CHECKING:
    from toolkit.studies.optimization.optimum import Optimum


def optimize(
    study: StudyFile,
    method: Annotated[str | None, typer.Option(help="slsqp, trust-constr, mma or ccsa, instead of the study's.")] = None,
    starts: Annotated[int | None, typer.Option(min=1, help="How many searches, instead of the study's.")] = None,
    evaluations: Annotated[int | None, typer.Option(min=1, help="Most designs of one search, instead of the study's.")] = None,
    output: Annotated[
        Path,
        typer.Option("--output", "-o", metavar="DIR", help="Folder of all designs, the JSON file, the table and the pictures."),
    ] = Path("optimum"),
    pictures: Annotated[bool, typer.Option(help="Whether the history, and the design before and after, are drawn.")] = True,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Find the best design of a study; exit with an error if none can be called an optimum. Interrupted studies resume."""
    from toolkit.studies.optimization.optimize import optimized
    from toolkit.studies.study.checked_problem import problem_of
    from toolkit.studies.study.search_options import Search
    from toolkit.studies.study.study_reader import naming_study_lines, read_study

    described = read_study(study)
    given = {"method": method, "starts": starts, "evaluations": evaluations}
    changed = {key: value for key, value in given.items() if value is not None}
    if changed:
        search = with_options("search", Search, {**described.search.model_dump(), **_checked(changed)})
        described = described.model_copy(update={"search": search})
    with naming_study_lines(study):
        problem = problem_of(described)
    folder = prepare_folder(output, "optimum.json", "history.csv", "history.png", "history.svg", "before", "after")
    compile_before(problem.scene, problem.kind, described.search.gradients == "adjoint", quiet)
    with naming_study_lines(study), bar("designs", quiet) as progress:
        found = optimized(problem, folder, progress)
    record = found.record()
    _keep(found, record, folder, pictures, quiet)
    print_answer(lambda: record, lambda: print_optimum(found), found.verdict, as_json, quiet)
    with answered():
        found.check()


def _checked(changed: dict[str, Any]) -> dict[str, Any]:
    from toolkit.studies.optimization.methods.catalogue import METHODS

    if changed.get("method", "slsqp") not in METHODS:
        raise typer.BadParameter(
            f"there is no method {changed['method']!r}. Choose one of: {', '.join(METHODS)}.", param_hint="--method"
        )
    return changed


def _keep(found: Optimum, record: dict[str, Any], folder: Path, pictures: bool, quiet: bool) -> None:
    """Write the JSON file, the table of all designs, and the pictures where they can be drawn."""
    from toolkit.foundation.files.replaced_file import write_whole
    from toolkit.results.csv_tables import write_csv

    write_whole(folder / "optimum.json", json.dumps(record, indent=1, allow_nan=False).encode())
    table = write_csv(folder / "history.csv", *found.history)
    files = [folder / "optimum.json", table, *(_draw(found, folder, quiet) if pictures else [])]
    if not quiet:
        typer.echo(f"{', '.join(map(str, files))} are written.", err=True)


def _draw(found: Optimum, folder: Path, quiet: bool) -> list[Path]:
    from toolkit.render.packages import RenderError, require

    try:
        require("matplotlib")
        from toolkit.render.pictures import render_solution
        from toolkit.report.studies.optimization_drawing import history

        files = history(found).save(folder)
        for name, solution in found.before_and_after().items():
            files += render_solution(solution, folder / name, instants=[float(solution.times[-1])])
    except RenderError as error:
        if not quiet:
            typer.echo(f"no pictures: {error}", err=True)
        return []
    except ToolkitError as error:  # the design is what was asked for; a picture of a scene that cannot be drawn is not
        if not quiet:
            typer.echo(f"not all pictures: {error}", err=True)
        return []
    return files
