"""The command `ffrf uncertainty`: how sure responses are whose scene has uncertain numbers."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from toolkit.command_line.announcements import bar, compile_before
from toolkit.command_line.arguments import Dask, Jobs, StudyFile, with_options
from toolkit.command_line.printing import prepare_folder, tell
from toolkit.foundation.terminal import AsJson, Quiet
from toolkit.report.answer import Answer, AnswerTable

if TYPE_CHECKING:
    from toolkit.report.drawing import Drawing
    from toolkit.studies.uncertain_result import Spread, UncertainResult


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
    from toolkit.studies.distributions import Uncertainty
    from toolkit.studies.executor import Executor
    from toolkit.studies.find_uncertainty import find_uncertainty
    from toolkit.studies.study_file import naming_study_lines, read_study
    from toolkit.studies.uncertain_study import uncertain_study

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
    tell(UncertaintyAnswer(found, found.verdict), as_json, quiet, folder, pictures)


class UncertaintyAnswer(Answer):
    """Uncertain responses: their spread, the shares of the numbers in it, quantiles and probabilities."""

    result: UncertainResult

    name = "uncertainty"
    written = "{files} are written; all designs are in {folder}."

    def tables(self) -> Iterator[AnswerTable | str]:
        """Uncertain numbers, then responses by polynomials, by first derivatives and by random designs."""
        study, responses, names = self.result.study, self.result.responses, self.result.study.problem.variables
        numbers = zip(names, study.joint.marginals, strict=True)
        rows = [(name, each.mean, f"{each.sigma:.3g}", study.problem.unit_of_variable(name)) for name, each in numbers]
        yield AnswerTable(["uncertain", "mean", "sigma", "unit"], rows)
        head = ["response", "mean", "sigma", "+- of both", "unit", "degree", "left out", "first order", "random designs"]
        yield AnswerTable(head, [(name, *_spread(each)) for name, each in responses.items()])
        known = {
            f: (each.alone, each.together)
            for f, each in responses.items()
            if each.alone is not None and each.together is not None
        }
        shares = [(f, *(f"{alone[x]:.3f} ({whole[x]:.3f})" for x in names)) for f, (alone, whole) in known.items()]
        if shares:
            yield AnswerTable(["share of the variance", *names], shares)
        levels = [f"{share:g}" for share in study.options.quantiles]
        yield AnswerTable(["quantile", *levels], [(name, *each.quantiles.values()) for name, each in responses.items()])
        limits = [(f"{f} {words}", *_beyond(each, words)) for f, each in responses.items() for words in each.beyond]
        if limits:
            yield AnswerTable(["probability", "polynomials", "random designs"], limits)
        yield self.result.said

    def figures(self) -> Iterator[Drawing]:
        """Distributions of the responses, and what they come from."""
        from toolkit.report.study_drawings import uncertainty_drawing

        yield uncertainty_drawing(self.result)


def _spread(each: Spread) -> list[str | float]:
    """Mean and sigma by polynomials with their error, by first derivatives, and by random designs."""
    first = "" if each.first_order is None else "{:.6g}, {:.3g}".format(*each.first_order)
    drawn = each.sampled
    random = "" if drawn is None else f"{drawn.mean[0]:.6g}, {drawn.sigma[0]:.3g} +- {drawn.sigma[1]:.1g}"
    return [each.mean, f"{each.sigma:.4g}", f"{each.error:.1g}", each.unit, each.degree, f"{each.left_out:.1e}", first, random]


def _beyond(each: Spread, words: str) -> tuple[str, str]:
    """Probability of a limit by polynomials and by random designs."""
    random = "" if each.sampled is None else "{:.3g} +- {:.1g}".format(*each.sampled.beyond[words])
    return f"{each.beyond[words]:.3g}", random
