"""The command `ffrf uncertainty`: how sure responses are whose scene has uncertain numbers."""

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
    from toolkit.studies.uncertainty.uncertain_result import UncertainResult


def uncertainty(
    study: StudyFile,
    runs: Annotated[int | None, typer.Option(min=2, help="Designs with gradients, instead of the study's.")] = None,
    monte_carlo: Annotated[
        int | None, typer.Option("--monte-carlo", min=0, help="Random designs without gradients, instead of the study's.")
    ] = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="Folder of all designs, the JSON file and the picture.")
    ] = Path("uncertainty"),
    pictures: Annotated[bool, typer.Option(help="Whether the distributions are drawn.")] = True,
    jobs: Jobs = 1,
    dask: Dask = "",
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Find mean, spread, shares of variables, quantiles and probabilities of uncertain responses. Interrupted studies resume."""
    from toolkit.studies.distributions.uncertain_numbers import Uncertainty
    from toolkit.studies.engine.executor import Executor
    from toolkit.studies.study.study_reader import naming_study_lines, read_study
    from toolkit.studies.uncertainty.find_uncertainty import find_uncertainty
    from toolkit.studies.uncertainty.uncertain_study import uncertain_study

    executor, described = Executor(processes=jobs, dask=dask), read_study(study)
    given = {key: value for key, value in {"runs": runs, "monte_carlo": monte_carlo}.items() if value is not None}
    if given:
        wanted = {**described.uncertainty.model_dump(), **given}
        described = described.model_copy(update={"uncertainty": with_options("uncertainty", Uncertainty, wanted)})
    with naming_study_lines(study):
        checked = uncertain_study(described)
    folder = prepare_folder(output, "uncertainty.json", "uncertainty.png", "uncertainty.svg")
    compile_before(checked.problem.scene, checked.problem.kind, described.search.gradients == "adjoint", quiet)
    with naming_study_lines(study), bar("designs", quiet) as progress:
        found = find_uncertainty(checked, folder, executor, progress)
    record = found.record()
    _keep(found, record, folder, pictures, quiet)
    print_answer(lambda: record, lambda: _print(found), found.verdict, as_json, quiet)


def _keep(found: UncertainResult, record: dict[str, Any], folder: Path, pictures: bool, quiet: bool) -> None:
    """Write the JSON file, and the picture where it can be drawn."""
    from toolkit.foundation.files.replaced_file import write_whole

    write_whole(folder / "uncertainty.json", json.dumps(record, indent=1, allow_nan=False).encode())
    files = [folder / "uncertainty.json", *(save_drawing(lambda: _drawing(found), folder, quiet) if pictures else [])]
    if not quiet:
        typer.echo(f"{', '.join(map(str, files))} are written; all designs are in {folder}.", err=True)


def _drawing(found: UncertainResult) -> Drawing:
    from toolkit.report.studies.uncertainty_drawing import uncertainty_drawing

    return uncertainty_drawing(found)


def _print(found: UncertainResult) -> None:
    """Print uncertain numbers, responses with their spread, shares of their variance, quantiles and probabilities."""
    console, problem = Console(width=WIDE, highlight=False), found.study.problem
    numbers = table("uncertain", "mean", "sigma", "unit")
    for name, each in zip(problem.variables, found.study.joint.marginals, strict=True):
        numbers.add_row(name, f"{each.mean:.6g}", f"{each.sigma:.3g}", problem.unit_of_variable(name))
    console.print(numbers)
    _print_spreads(console, found)
    _print_shares(console, found)
    quantiles = table("quantile", *(f"{share:g}" for share in found.study.options.quantiles))
    for name, spread in found.responses.items():
        quantiles.add_row(name, *(f"{value:.6g}" for value in spread.quantiles.values()))
    console.print(quantiles)
    limits = table("probability", "polynomials", "random designs")
    for name, spread in found.responses.items():
        for words, share in spread.beyond.items():
            random = "" if spread.sampled is None else "{:.3g} +- {:.1g}".format(*spread.sampled.beyond[words])
            limits.add_row(f"{name} {words}", f"{share:.3g}", random)
    if limits.row_count:
        console.print(limits)
    typer.echo(found.said)


def _print_spreads(console: Console, found: UncertainResult) -> None:
    """Print mean and sigma by polynomials, by first derivatives, and by random designs."""
    rows = table("response", "mean", "sigma", "+- of both", "unit", "degree", "left out", "first order", "random designs")
    for name, each in found.responses.items():
        first = "" if each.first_order is None else "{:.6g}, {:.3g}".format(*each.first_order)
        random = (
            ""
            if each.sampled is None
            else f"{each.sampled.mean[0]:.6g}, {each.sampled.sigma[0]:.3g} +- {each.sampled.sigma[1]:.1g}"
        )
        numbers = (
            f"{each.mean:.6g}",
            f"{each.sigma:.4g}",
            f"{each.error:.1g}",
            each.unit,
            str(each.degree),
            f"{each.left_out:.1e}",
        )
        rows.add_row(name, *numbers, first, random)
    console.print(rows)


def _print_shares(console: Console, found: UncertainResult) -> None:
    """Print Sobol's indices: of a number alone, and together with others."""
    names = found.study.problem.variables
    shares = table("share of the variance", *names)
    for name, each in found.responses.items():
        if each.alone is not None and each.together is not None:
            shares.add_row(name, *(f"{each.alone[x]:.3f} ({each.together[x]:.3f})" for x in names))
    if shares.row_count:
        console.print(shares)
