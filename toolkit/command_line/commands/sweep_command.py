"""The command `ffrf sweep`: values and gradients at many designs of a study, as tables and a picture."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from toolkit.command_line.announcements import bar, compile_before
from toolkit.command_line.arguments import Dask, Jobs, StudyFile, with_options
from toolkit.command_line.printing import note, prepare_folder, tell
from toolkit.foundation.terminal import AsJson, Quiet
from toolkit.report.answer import Answer, AnswerTable

if TYPE_CHECKING:
    from toolkit.report.drawing import Drawing
    from toolkit.studies.study_file import Study
    from toolkit.studies.sweep import Swept

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
    from toolkit.studies.executor import Executor
    from toolkit.studies.study_file import naming_study_lines, read_study
    from toolkit.studies.sweep import run_sweep, sweep_problem

    executor = Executor(processes=jobs, dask=dask)
    file = None if designs is None else str(designs.resolve())
    described = _changed(read_study(study), {"points": points, "levels": levels, "count": count, "file": file})
    with naming_study_lines(study):
        problem = sweep_problem(described)
    folder = prepare_folder(output, "sweep.csv", "sweep.json", "sweep.parquet", "sweep.png", "sweep.svg")
    compile_before(problem.scene, problem.kind, described.search.gradients == "adjoint", quiet)
    with naming_study_lines(study), bar("designs", quiet) as progress:
        found = run_sweep(problem, folder, executor, progress)
    more = _parquet(found.columns, folder / "sweep.parquet", quiet)
    tell(SweepAnswer(found, found.verdict), as_json, quiet, folder, pictures, more)


def _changed(study: Study, given: Mapping[str, object]) -> Study:
    """Study with options of the command line; other kinds of designs in the file then count no more.

    Raises
    ------
    InputError
        They contradict each other.
    """
    from toolkit.studies.study_file import Sweep

    changed = {key: value for key, value in given.items() if value is not None}
    if not changed:
        return study
    known = study.sweep.model_dump(exclude_none=True)
    if "points" in changed or "file" in changed:
        known = {key: known[key] for key in ("responses", "gradients") if key in known}
    return study.model_copy(update={"sweep": with_options("sweep", Sweep, {**known, **changed})})


def _parquet(columns: Mapping[str, Sequence[object]], path: Path, quiet: bool) -> list[Path]:
    """Write the table for programs that read columns too, where that can be done; what does not exist is null."""
    from importlib.util import find_spec
    from io import BytesIO

    from toolkit.foundation.files.safe_files import write_whole

    if find_spec("pyarrow") is None:
        note("no Parquet file: pyarrow is not installed. Install: pip install 'ffrf-toolkit[studies]'.", quiet)
        return []
    import pyarrow
    from pyarrow import parquet

    arrays = {name: [None if value != value else value for value in each] for name, each in columns.items()}
    content = BytesIO()
    parquet.write_table(pyarrow.table(arrays), content)
    write_whole(path, content.getvalue())
    return [path]


class SweepAnswer(Answer):
    """Many designs: bounds of the variables, and where responses are least and largest."""

    result: Swept

    name = "sweep"
    written = "{files} are written; all designs are in {folder}."

    def tables(self) -> Iterator[AnswerTable | str]:
        """All designs as a file; variables with their bounds, and extremes of the responses."""
        columns, swept = self.result.columns, self.record()["sweep"]
        yield AnswerTable(
            [*columns], [["" if cell != cell else cell for cell in row] for row in zip(*columns.values(), strict=True)], "sweep"
        )
        unit = self.result.problem.unit_of_variable
        variables = [(name, each["least"], each["largest"], unit(name)) for name, each in swept["variables"].items()]
        yield AnswerTable(["variable", "least", "largest", "unit"], variables)
        ends = [(name, each["least"], each["largest"], each["unit"]) for name, each in swept["responses"].items()]
        rows = [(name, low["value"], low["design"], high["value"], high["design"], unit) for name, low, high, unit in ends]
        yield AnswerTable(["response", "least", "of design", "largest", "of design", "unit"], rows)
        yield self.result.said

    def figures(self) -> Iterator[Drawing]:
        """Responses over the variables."""
        from toolkit.report.study_drawings import sweep_drawing

        yield sweep_drawing(self.result)
