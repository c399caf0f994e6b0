"""The command `ffrf sweep`: values and gradients at many designs of a study, as tables and a picture."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from toolkit.command_line.announcements import bar, compile_before
from toolkit.command_line.arguments import Dask, Jobs, StudyFile, with_options
from toolkit.command_line.output_folder import prepare_folder
from toolkit.command_line.pictures import save_drawing
from toolkit.command_line.printed.printing import WIDE, print_answer, table
from toolkit.foundation.terminal import AsJson, Quiet

if TYPE_CHECKING:
    from toolkit.report.drawing import Drawing
    from toolkit.studies.study.study_file import Study
    from toolkit.studies.sweep.swept import Swept

Points = Annotated[str | None, typer.Option(help="grid, latin-hypercube or sobol, instead of the study's.")]


def sweep(
    study: StudyFile,
    points: Points = None,
    levels: Annotated[int | None, typer.Option(min=1, help="Values of every variable of a grid.")] = None,
    count: Annotated[int | None, typer.Option(min=1, help="Designs of a latin-hypercube or sobol sweep.")] = None,
    designs: Annotated[
        Path | None, typer.Option(metavar="FILE.csv", help="A table of designs instead, with a column for every variable.")
    ] = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="Folder of all designs, the tables and the picture.")
    ] = Path("sweep"),
    pictures: Annotated[bool, typer.Option(help="Whether the designs are drawn.")] = True,
    jobs: Jobs = 1,
    dask: Dask = "",
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Solve many designs of a study, and write values and gradients into tables. Interrupted studies resume."""
    from toolkit.studies.engine.executor import Executor
    from toolkit.studies.study.study_reader import naming_study_lines, read_study
    from toolkit.studies.sweep.sweep import run_sweep, sweep_problem

    executor = Executor(processes=jobs, dask=dask)
    file = None if designs is None else str(designs.resolve())
    described = _changed(read_study(study), {"points": points, "levels": levels, "count": count, "file": file})
    with naming_study_lines(study):
        problem = sweep_problem(described)
    folder = prepare_folder(output, "sweep.csv", "sweep.json", "sweep.parquet", "sweep.png", "sweep.svg")
    compile_before(problem.scene, problem.kind, described.search.gradients == "adjoint", quiet)
    with naming_study_lines(study), bar("designs", quiet) as progress:
        found = run_sweep(problem, folder, executor, progress)
    record = found.record()
    _keep(found, record, folder, pictures, quiet)
    print_answer(lambda: record, lambda: _print(found, record), found.verdict, as_json, quiet)


def _changed(study: Study, given: dict[str, Any]) -> Study:
    """Study with options of the command line; other kinds of designs in the file then count no more.

    Raises
    ------
    InputError
        They contradict each other.
    """
    from toolkit.studies.study.sweep_options import Sweep

    changed = {key: value for key, value in given.items() if value is not None}
    if not changed:
        return study
    known = study.sweep.model_dump(exclude_none=True)
    if "points" in changed or "file" in changed:
        known = {key: known[key] for key in ("responses", "gradients") if key in known}
    return study.model_copy(update={"sweep": with_options("sweep", Sweep, {**known, **changed})})


def _keep(found: Swept, record: dict[str, Any], folder: Path, pictures: bool, quiet: bool) -> None:
    """Write the tables, the JSON file, and the picture where it can be drawn."""
    from toolkit.foundation.files.replaced_file import write_whole
    from toolkit.studies.sweep.tables import has_parquet, write_csv, write_parquet

    files, columns = [folder / "sweep.csv", folder / "sweep.json"], found.columns
    write_csv(columns, files[0])
    write_whole(files[1], json.dumps(record, indent=1, allow_nan=False).encode())
    if has_parquet():
        files.append(folder / "sweep.parquet")
        write_parquet(columns, files[-1])
    elif not quiet:
        typer.echo("no Parquet file: pyarrow is not installed. Install: pip install 'ffrf-toolkit[studies]'.", err=True)
    files += save_drawing(lambda: _drawing(found), folder, quiet) if pictures else []
    if not quiet:
        typer.echo(f"{', '.join(map(str, files))} are written; all designs are in {folder}.", err=True)


def _drawing(found: Swept) -> Drawing:
    from toolkit.report.studies.sweep_drawing import sweep_drawing

    return sweep_drawing(found)


def _print(found: Swept, record: dict[str, Any]) -> None:
    """Print variables with their bounds, and where responses are least and largest."""
    console, problem = Console(width=WIDE, highlight=False), found.problem
    variables = table("variable", "least", "largest", "unit")
    for name, bounds in record["sweep"]["variables"].items():
        variables.add_row(name, f"{bounds['least']:.6g}", f"{bounds['largest']:.6g}", problem.unit_of_variable(name))
    console.print(variables)
    responses = table("response", "least", "of design", "largest", "of design", "unit")
    for name, each in record["sweep"]["responses"].items():
        ends = [text for end in ("least", "largest") for text in (f"{each[end]['value']:.6g}", str(each[end]["design"]))]
        responses.add_row(name, *ends, each["unit"])
    console.print(responses)
    typer.echo(found.said)
