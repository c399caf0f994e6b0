"""The command `ffrf optimize`: the best design of a study, what its limits cost, and whether it can be trusted."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from toolkit.command_line.announcements import bar, compile_before
from toolkit.command_line.arguments import StudyFile, with_options
from toolkit.command_line.printing import prepare_folder, tell
from toolkit.foundation.terminal import AsJson, Quiet, answered
from toolkit.report.answer import Answer, AnswerTable, Picture

if TYPE_CHECKING:
    from toolkit.studies.optimization.explored import SearchResult
    from toolkit.studies.optimization.optimum import Optimum
    from toolkit.system.solution import Solution


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
    from toolkit.studies.problem import problem_of
    from toolkit.studies.study_file import Search, naming_study_lines, read_study

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
    tell(OptimumAnswer(found, found.verdict), as_json, quiet, folder, pictures)
    with answered():
        found.check()


def _checked(changed: Mapping[str, object]) -> Mapping[str, object]:
    from toolkit.studies.optimization.methods import METHODS

    if changed.get("method", "slsqp") not in METHODS:
        raise typer.BadParameter(
            f"there is no method {changed['method']!r}. Choose one of: {', '.join(METHODS)}.", param_hint="--method"
        )
    return changed


class OptimumAnswer(Answer):
    """The best design: before and after, the price of its limits, and the course of the searches."""

    result: Optimum

    name = "optimum"

    def tables(self) -> Iterator[AnswerTable | str]:
        """All designs as a file; variables with their bounds, responses, prices of limits, and searches."""
        found, problem, before = self.result, self.result.problem, self.result.values_before
        yield AnswerTable(*found.history, "history")
        bounds = zip(found.variables.items(), problem.start, problem.bounds.T, strict=True)
        rows = [(name, start, value, *ends, problem.unit_of_variable(name)) for (name, value), start, ends in bounds]
        yield AnswerTable(["variable", "start", "optimum", "least", "largest", "unit"], rows)
        responses = [(f, before.get(f, ""), value, found.units[f]) for f, value in found.values.items()]
        yield AnswerTable(["response", "start", "optimum", "unit"], responses)
        if found.prices:
            told = [(f"{x.name} {x.limit}", f"{x.price:.4g}" if x.active else "0", x.unit, x.text) for x in found.prices]
            yield AnswerTable(["limit", "price", "unit", "why"], told)
        head = ["search", "objective", "KKT residual", "to gain", "violation", "designs", "failed", "why"]
        yield AnswerTable(head, [_search(each, bool(problem.curved)) for each in found.searches])
        yield from found.said

    def figures(self) -> Iterator[Picture]:
        """Designs of the searches, and the scene before and after."""
        from toolkit.report.study_drawings import optimization_drawing

        yield optimization_drawing(self.result)
        for name, solution in self.result.before_and_after().items():
            yield EndPicture(name, solution)


def _search(each: SearchResult, curved: bool) -> list[str | int]:
    """Cells about one search."""
    numbers = ["", "", "", ""]
    if each.best is not None and (left := each.optimality) is not None:
        gain = f"{left.gain:.1e}" if curved else ""
        value = float(each.program.objective(each.best.values)[0])
        numbers = [f"{value:.6g}", f"{left.residual:.1e}", gain, f"{left.violation:.1e}"]
    return [f"start {each.lane // 2 + 1}", *numbers, each.evaluations, each.failed, each.ended]


class EndPicture(NamedTuple):
    """Picture of the last state of a solution, in a folder of its name."""

    name: str
    solution: Solution

    def save(self, folder: Path) -> list[Path]:
        """Draw it."""
        from toolkit.render.pictures import render_solution

        return render_solution(self.solution, folder / self.name, instants=[float(self.solution.times[-1])])
