"""How an optimum is printed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer
from rich.console import Console

from toolkit.command_line.printed.printing import WIDE, table

if TYPE_CHECKING:
    from toolkit.studies.optimization.optimum import Optimum


def print_optimum(found: Optimum) -> None:
    """Print variables with their bounds, responses before and after, the price of limits, and the course of the searches."""
    console = Console(width=WIDE, highlight=False)
    problem = found.problem
    variables = table("variable", "start", "optimum", "least", "largest", "unit")
    for k, (name, value) in enumerate(found.variables.items()):
        low, high = problem.bounds[:, k]
        row = (f"{problem.start[k]:.6g}", f"{value:.6g}", f"{low:.6g}", f"{high:.6g}", problem.unit_of_variable(name))
        variables.add_row(name, *row)
    console.print(variables)
    responses, before, units = table("response", "start", "optimum", "unit"), found.values_before, found.units
    for name, value in found.values.items():
        responses.add_row(name, f"{before[name]:.6g}" if name in before else "", f"{value:.6g}", units[name])
    console.print(responses)
    limits = table("limit", "price", "unit", "why")
    for price in found.prices:
        limits.add_row(f"{price.name} {price.limit}", f"{price.price:.4g}" if price.active else "0", price.unit, price.text)
    if found.prices:
        console.print(limits)
    _print_searches(console, found)
    for line in found.said:
        typer.echo(line)


def _print_searches(console: Console, found: Optimum) -> None:
    searches = table("search", "objective", "KKT residual", "to gain", "violation", "designs", "failed", "why")
    for each in found.searches:
        if each.best is None or each.optimality is None:
            numbers = ("", "", "", "")
        else:
            value = float(each.program.objective(each.best.values)[0])
            left, gain = each.optimality, f"{each.optimality.gain:.1e}" if found.problem.curved else ""
            numbers = (f"{value:.6g}", f"{left.residual:.1e}", gain, f"{left.violation:.1e}")
        searches.add_row(f"start {each.lane // 2 + 1}", *numbers, str(each.evaluations), str(each.failed), each.ended)
    console.print(searches)
