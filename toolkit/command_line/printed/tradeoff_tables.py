"""What `ffrf tradeoff` prints: tables for people, or one JSON object."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import typer
from rich.console import Console

from toolkit.command_line.printed.printing import WIDE, finite_or_none, table

if TYPE_CHECKING:
    from toolkit.studies.tradeoff.judgement import JudgedSetting
    from toolkit.studies.tradeoff.tradeoff import Tradeoff

DISTURBED, BUSY = 1.5, ": the machine is busy with something else, and times that differ by less say nothing"
SHOWN = 30
"""Rows of the table of settings; of more, the Pareto set, those that keep the budget, and the scene's own are shown first."""


def print_tradeoff(found: Tradeoff) -> None:
    """Print reference, settings, failures and recommendation."""
    console = Console(width=WIDE, highlight=False)
    _print_reference(console, found)
    _print_settings(console, found)
    for line in failures(found):
        console.print(line, markup=False)
    if found.recommended:
        _print_recommendation(found, found.recommended)


def failures(found: Tradeoff) -> list[str]:
    """Lines on settings that failed: one for every reason, with what these settings have in common."""
    reasons: dict[str, list[dict[str, str]]] = {}
    for each in found.failed:
        reasons.setdefault(each.outcome.reason, []).append(each.setting.labels)
    lines = []
    for reason, all_labels in reasons.items():
        shared = {axis: label for axis, label in all_labels[0].items() if all(labels[axis] == label for labels in all_labels)}
        words = ", ".join(f"{axis} {label}" for axis, label in shared.items())
        lines.append(f"failed: {words}{f' ({len(all_labels)} settings)' if len(all_labels) > 1 else ''}: {reason}")
    return lines


def _print_reference(console: Console, found: Tradeoff) -> None:
    from toolkit.studies.tradeoff.reference import described

    for line in described(found.reference):
        console.print(line, markup=False)
    rows = table("quantity", "reference", "unit", "its error, relative", "observed order", "budget")
    reference = found.reference
    for quantity, limit in found.plan.budget.items():
        order = reference.order(quantity)
        rows.add_row(
            str(quantity),
            "" if quantity.derived else f"{reference.limits[quantity.response].value:.9g}",
            "" if quantity.derived else reference.units[quantity.response],
            f"{reference.error(quantity):.1e}",
            "-" if order != order else f"{order:.2f}",
            f"{limit:.1e}",
        )
    console.print(rows)
    if not reference.enough:
        console.print(
            "The reference's own error exceeds a tenth of a budget; it counts as an error of every setting.", markup=False
        )


def _print_settings(console: Console, found: Tradeoff) -> None:
    axes = list(found.plan.axes)
    rows = table(
        "",
        *axes,
        *["coordinates"] * _reduced(found),
        "steps",
        "Newton",
        "values, ms",
        "with gradients, ms",
        "largest error",
        "of gradients",
        "of budget",
    )
    best, worked = {id(each) for each in found.pareto}, [each for each in found.settings if not each.outcome.failed]
    chosen = sorted(worked, key=lambda each: not (id(each) in best or each.setting.own or each is found.recommended))[:SHOWN]
    for each in [each for each in worked if any(each is other for other in chosen)]:
        rows.add_row(_mark(found, each, id(each) in best), *_cells(each, axes, _reduced(found)))
    console.print(rows)
    note = (
        "Errors are the largest of those with a budget. >: recommended, *: Pareto set (no other setting is both faster and nearer to the "
        "budget), o: the scene as it stands"
    )
    if len(chosen) < len(worked):
        note += f"; {len(worked) - len(chosen)} more settings are in the JSON file"
    console.print(f"{note}.", markup=False)
    repeats = max((len(each.outcome.whole) for each in worked), default=0)
    if repeats > 1:
        note = (
            f"Times are medians of {repeats} runs, one setting at a time; repeated runs differ by a factor of {found.spread:.2g}"
        )
        console.print(f"{note}{BUSY if found.spread > DISTURBED else ''}.", markup=False)


def _mark(found: Tradeoff, each: JudgedSetting, best: bool) -> str:
    return (">" if each is found.recommended else "") + "*" * best + "o" * each.setting.own


def _reduced(found: Tradeoff) -> bool:
    """Whether settings have other reduced models, and so other numbers of coordinates."""
    return any(each.setting.skin for each in found.settings)


def _cells(each: JudgedSetting, axes: list[str], reduced: bool) -> list[str]:
    outcome, (primal, whole) = each.outcome, each.outcome.medians
    errors = [
        f"{each.largest(derived):.1e}" if each.largest(derived) == each.largest(derived) else "-" for derived in (False, True)
    ]
    labels = [each.setting.labels[axis] for axis in axes]
    counts = [*[str(outcome.coordinates)] * reduced, str(outcome.steps), str(outcome.newton_iterations)]
    return [*labels, *counts, f"{1e3 * primal:.3g}", f"{1e3 * whole:.3g}", *errors, f"{each.ratio:.2g}"]


def _print_recommendation(found: Tradeoff, best: JudgedSetting) -> None:
    from toolkit.studies.tradeoff.recommendation import frames, next_steps, skin_fragments, solver_fragment

    own = next((each for each in found.settings if each.setting.own and not each.outcome.failed), None)
    gain = f", {own.price / best.price:.2g} times the speed of the scene as it stands" if own and own is not best else ""
    typer.echo(
        f"Cheapest within the budget: {best.setting} ({1e3 * best.price:.3g} ms{gain}). In place of the scene's [solver]:\n"
    )
    typer.echo(solver_fragment(found.plan.case, best.setting))
    for body, text in skin_fragments(found.plan.case, best.setting).items():
        typer.echo(
            f"\nIn the skin file of {body}, which ffrf-preprocess builds again, in place of the tables of these names:\n\n{text}"
        )
    for body, numbers in frames(found.plan.case, best.setting).items():
        typer.echo(f"\nIn the scene's bodies.{body}: {', '.join(f'{key} = {n}' for key, n in numbers.items())}")
    for line in next_steps(found.plan.case, best.setting):
        typer.echo(f"\n{line}")


def record_of(found: Tradeoff) -> dict[str, Any]:
    """JSON object of a tradeoff study."""
    from toolkit.studies.tradeoff.recommendation import changes, skin_fragments, solver_fragment

    reference, best, case = found.reference, found.recommended, found.plan.case
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
            "values": {
                f: {"value": finite_or_none(each.value), "unit": reference.units[f]} for f, each in reference.limits.items()
            },
            "gradients": {f: {x: finite_or_none(each.value) for x, each in of.items()} for f, of in reference.slopes.items()},
            "relative_errors": {str(quantity): finite_or_none(reference.error(quantity)) for quantity in found.plan.budget},
            "orders": {str(quantity): finite_or_none(reference.order(quantity)) for quantity in found.plan.budget},
            "small_enough": reference.enough,
        },
        "budget": {str(quantity): limit for quantity, limit in found.plan.budget.items()},
        "settings": [_record(each, any(each is other for other in found.pareto)) for each in found.settings],
        "recommended": recommended,
    }


def _record(each: JudgedSetting, best: bool) -> dict[str, Any]:
    outcome, (primal, whole) = each.outcome, each.outcome.medians
    return {
        "setting": each.setting.labels,
        "own": each.setting.own,
        "failure": outcome.reason or None,
        "pareto": best,
        "within_budget": each.kept,
        "part_of_budget": finite_or_none(each.ratio),
        "relative_errors": {str(quantity): finite_or_none(error) for quantity, error in each.errors.items()},
        "median_s": {"values": finite_or_none(primal), "with_gradients": finite_or_none(whole)},
        "repeats": len(outcome.whole),
        "steps": outcome.steps,
        "newton_iterations": outcome.newton_iterations,
        "coordinates": outcome.coordinates,
    }
