"""The command `ffrf tradeoff`: what accuracy costs in a scene, and the cheapest setting that keeps a budget."""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from toolkit.command_line.announcements import bar, compile_before
from toolkit.command_line.arguments import Changes, SceneFile, Variables, design_of, read, split
from toolkit.command_line.printing import prepare_folder, tell
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.terminal import AsJson, Quiet, answered
from toolkit.report.answer import Answer, AnswerTable, Record

if TYPE_CHECKING:
    from toolkit.foundation.verdict import Verdict
    from toolkit.report.drawing import Drawing
    from toolkit.scene.scene import Scene
    from toolkit.studies.tradeoff.tradeoff import JudgedSetting, Tradeoff

Budgets = Annotated[
    list[str] | None,
    typer.Option(
        "--budget",
        metavar="RESPONSE=1e-3",
        help="Largest relative error of a response, or of its gradient by d(RESPONSE)=1e-2; repeatable. all=1e-3 by default.",
    ),
]
GradientBudgets = Annotated[
    list[str] | None,
    typer.Option(metavar="RESPONSE=1e-2", help="Of gradients; by default ten times the budget of the response."),
]
Axes = Annotated[
    str | None,
    typer.Option(
        metavar="step,scheme,...",
        help="What to vary, with values if you like: step=0.1/0.05,scheme,rho_inf=0.5/1,modes=full/8,elements,frames=1/4/every. An "
        "unknown one lists all.",
    ),
]


def tradeoff(
    scene: SceneFile,
    budget: Budgets = None,
    gradient_budget: GradientBudgets = None,
    axes: Axes = None,
    variables: Variables = None,
    gradients: Annotated[bool, typer.Option(help="Whether gradients are measured too, and part of the price.")] = True,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="Folder of the picture, the JSON file and all that is kept.")
    ] = Path("tradeoff"),
    jobs: Annotated[
        int | None, typer.Option(min=1, help="Processes that compute values; times are always measured one after another.")
    ] = None,
    repeats: Annotated[int, typer.Option(min=1, help="Runs whose median is a time.")] = 5,
    changes: Changes = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Measure what accuracy costs: run a grid of settings against a reference, and recommend the cheapest within a budget."""
    from toolkit.studies.tradeoff import tradeoff as study
    from toolkit.studies.tradeoff.frame_axes import framed
    from toolkit.studies.tradeoff.setting import EVERY_ELEMENT

    described = read(scene, changes, quiet)
    names = (design_of(described, variables) if described.design or variables else []) if gradients else []
    pairs = dict(split(change) for change in changes or [])
    planned = study.plan(scene, output, pairs, names, axes, budget or [], gradient_budget or [])
    folder = prepare_folder(output, "tradeoff.json", "tradeoff.png", "tradeoff.svg")
    for formulation in sorted({each.solver.get("formulation") or described.solver.formulation for each in planned.settings}):
        solver = described.solver.model_copy(
            update={"formulation": formulation}
        )  # compiled once, before several processes would do it
        compile_before(described.model_copy(update={"solver": solver}), "transient", bool(names), quiet)
    found = study.tradeoff(planned, partial(bar, quiet=quiet), jobs or os.cpu_count() or 1, repeats)
    verdict = _model_verdict(framed(described, EVERY_ELEMENT) if "frames" in planned.axes else described)
    tell(TradeoffAnswer(found, verdict), as_json, quiet, folder)
    with answered():
        found.check()


def _model_verdict(scene: Scene) -> Verdict:
    """Doubts about the model itself, which no setting fixes, from the motion with the scene's own settings."""
    from toolkit.analyses.sensitivity.preparation import prepare, solve
    from toolkit.foundation.verdict import Caution, Verdict
    from toolkit.validity.bodies.bent_surfaces import bent_surfaces
    from toolkit.validity.bodies.physics import excessive_speeds, large_deformations

    try:
        solution = solve(prepare(scene), "transient")
    except ToolkitError as error:
        return Verdict((Caution("no-own-run", f"the scene does not run with its own settings: {error}", doubt=False),))
    return Verdict.of([*large_deformations(solution), *bent_surfaces(solution), *excessive_speeds(solution)])


DISTURBED, BUSY = 1.5, ": the machine is busy with something else, and times that differ by less say nothing"
MOST_ROWS = 30
"""Rows of the table of settings; of more, the Pareto set, those that keep the budget, and the scene's own are shown first."""


class TradeoffAnswer(Answer):
    """What accuracy costs: the reference, all settings, and the one that is recommended."""

    result: Tradeoff

    name = "tradeoff"

    def record(self) -> Record:
        """JSON object."""
        from toolkit.studies.tradeoff.tradeoff import changes, skin_fragments, solver_fragment

        found, reference, best, case = self.result, self.result.reference, self.result.recommended, self.result.plan.case
        recommended = None if best is None else {
            "setting": best.setting.labels,
            "scene": solver_fragment(case, best.setting),
            "set": changes(case, best.setting),
            "skins": skin_fragments(case, best.setting),
        }  # fmt: skip
        return {
            "reference": {
                "steps": [setting.solver["step"] for setting in reference.in_time[-3:]],
                "elements": [setting.skin["skin.elements"] for setting in reference.in_mesh],
                "values": {f: {"value": each.value, "unit": reference.units[f]} for f, each in reference.limits.items()},
                "gradients": {f: {x: each.value for x, each in of.items()} for f, of in reference.slopes.items()},
                "relative_errors": {str(quantity): reference.error(quantity) for quantity in found.plan.budget},
                "orders": {str(quantity): reference.order(quantity) for quantity in found.plan.budget},
                "small_enough": reference.enough,
            },
            "budget": {str(quantity): limit for quantity, limit in found.plan.budget.items()},
            "settings": [_record(each, any(each is other for other in found.pareto)) for each in found.settings],
            "recommended": recommended,
            **self.verdict.record(),
        }

    def tables(self) -> Iterator[AnswerTable | str]:
        """Reference, settings, failures and recommendation."""
        from toolkit.studies.tradeoff.reference import described

        reference = self.result.reference
        yield from described(reference)
        rows = []
        for quantity, limit in self.result.plan.budget.items():
            value, unit, order = "", "", reference.order(quantity)
            if not quantity.derived:
                value, unit = f"{reference.limits[quantity.response].value:.9g}", reference.units[quantity.response]
            error = f"{reference.error(quantity):.1e}"
            rows.append((quantity, value, unit, error, "-" if order != order else f"{order:.2f}", f"{limit:.1e}"))
        yield AnswerTable(["quantity", "reference", "unit", "its error, relative", "observed order", "budget"], rows)
        if not reference.enough:
            yield "The reference's own error exceeds a tenth of a budget; it counts as an error of every setting."
        yield from _settings(self.result)
        yield from failures(self.result)
        if self.result.recommended:
            yield from _recommendation(self.result, self.result.recommended)

    def figures(self) -> Iterator[Drawing]:
        """Errors over times, where a setting worked."""
        from toolkit.report.work_precision import work_precision

        if len(self.result.failed) < len(self.result.settings):
            yield work_precision(self.result)


def failures(found: Tradeoff) -> Iterator[str]:
    """Lines on settings that failed: one for every reason, with what these settings have in common."""
    reasons: dict[str, list[dict[str, str]]] = {}
    for each in found.failed:
        reasons.setdefault(each.outcome.reason, []).append(each.setting.labels)
    for reason, labels in reasons.items():
        words = ", ".join(f"{axis} {label}" for axis, label in labels[0].items() if all(each[axis] == label for each in labels))
        yield f"failed: {words}{f' ({len(labels)} settings)' if len(labels) > 1 else ''}: {reason}"


def _settings(found: Tradeoff) -> Iterator[AnswerTable | str]:
    """Table of settings in the order of their times, and what its marks and numbers mean."""
    axes, reduced = list(found.plan.axes), any(each.setting.skin for each in found.settings)
    counts = [*["coordinates"] * reduced, "steps", "Newton"]
    head = ["", *axes, *counts, "values, ms", "with gradients, ms", "largest error", "of gradients", "of budget"]
    best, worked = {id(each) for each in found.pareto}, [each for each in found.settings if not each.outcome.failed]
    first = sorted(worked, key=lambda each: not (id(each) in best or each.setting.own or each is found.recommended))
    chosen = {id(each) for each in first[:MOST_ROWS]}
    shown = [each for each in worked if id(each) in chosen]
    marks = [(">" if each is found.recommended else "") + "*" * (id(each) in best) + "o" * each.setting.own for each in shown]
    yield AnswerTable(head, [(mark, *_cells(each, axes, reduced)) for mark, each in zip(marks, shown, strict=True)])
    note = (
        "Errors are the largest of those with a budget. >: recommended, *: Pareto set (no other setting is both faster and nearer to the "
        "budget), o: the scene as it stands"
    )
    more = len(worked) - len(shown)
    yield f"{note}; {more} more settings are in the JSON file." if more else f"{note}."
    repeats = max((len(each.outcome.whole) for each in worked), default=0)
    if repeats > 1:
        differ = f"repeated runs differ by a factor of {found.spread:.2g}{BUSY if found.spread > DISTURBED else ''}"
        yield f"Times are medians of {repeats} runs, one setting at a time; {differ}."


def _cells(each: JudgedSetting, axes: list[str], reduced: bool) -> list[str | int]:
    """Cells of a setting; its number of coordinates where settings have other reduced models."""
    outcome, (primal, whole) = each.outcome, each.outcome.medians
    errors = ["-" if error != error else f"{error:.1e}" for error in (each.largest(False), each.largest(True))]
    counts = [*[outcome.coordinates] * reduced, outcome.steps, outcome.newton_iterations]
    labels = [each.setting.labels[axis] for axis in axes]
    return [*labels, *counts, f"{1e3 * primal:.3g}", f"{1e3 * whole:.3g}", *errors, f"{each.ratio:.2g}"]


def _recommendation(found: Tradeoff, best: JudgedSetting) -> Iterator[str]:
    """What to write into the scene's files, and what to do next."""
    from toolkit.studies.tradeoff.tradeoff import frames, next_steps, skin_fragments, solver_fragment

    case, own = found.plan.case, next((each for each in found.settings if each.setting.own and not each.outcome.failed), None)
    gain = f", {own.price / best.price:.2g} times the speed of the scene as it stands" if own and own is not best else ""
    yield f"Cheapest within the budget: {best.setting} ({1e3 * best.price:.3g} ms{gain}). In place of the scene's [solver]:\n"
    yield solver_fragment(case, best.setting)
    for body, text in skin_fragments(case, best.setting).items():
        yield f"\nIn the skin file of {body}, which ffrf-preprocess builds again, in place of the tables of these names:\n\n{text}"
    for body, numbers in frames(case, best.setting).items():
        yield f"\nIn the scene's bodies.{body}: {', '.join(f'{key} = {n}' for key, n in numbers.items())}"
    for line in next_steps(case, best.setting):
        yield f"\n{line}"


def _record(each: JudgedSetting, best: bool) -> Record:
    outcome, (primal, whole) = each.outcome, each.outcome.medians
    return {
        "setting": each.setting.labels,
        "own": each.setting.own,
        "failure": outcome.reason or None,
        "pareto": best,
        "within_budget": each.kept,
        "part_of_budget": each.ratio,
        "relative_errors": {str(quantity): error for quantity, error in each.errors.items()},
        "median_s": {"values": primal, "with_gradients": whole},
        "repeats": len(outcome.whole),
        "steps": outcome.steps,
        "newton_iterations": outcome.newton_iterations,
        "coordinates": outcome.coordinates,
    }
