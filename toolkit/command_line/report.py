"""What a command prints about a run: one JSON object, or tables for people."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from toolkit.command_line.remarks import remarks

if TYPE_CHECKING:
    from toolkit.sensitivity.analysis import Result
    from toolkit.validity.verdict import Verdict

WIDE = 1000
"""Columns of the output: a number that the terminal wraps is better than one that is cut."""
LEFT = ("unit", "by", "why")
"""Columns of words."""
MOST_COLUMNS = 8
"""More design variables than this stand one below the other."""


def print_json(record: dict[str, Any]) -> None:
    """Print one JSON object; everything in it is finite or null."""
    typer.echo(json.dumps(record, indent=2, allow_nan=False))


def print_result(result: Result, as_json: bool, quiet: bool = False) -> None:
    """Print values, units and gradients of all responses, how far flexible bodies deform, what the run cost, and whether to trust it."""
    from toolkit.command_line.deformation import print_deformations, record_of_deformations
    from toolkit.validity.deformation import deformations

    found = deformations(result.solution)
    if as_json:
        deformed = {"deformation": record_of_deformations(result.solution, found)} if found else {}
        print_json(record_of(result) | deformed)
        warn(result.verdict, quiet)
        return
    print_tables(result)
    print_deformations(result.solution, found)
    for line in remarks(result):
        Console(width=WIDE, highlight=False).print(line, markup=False)
    print_verdict(result.verdict)


def print_verdict(verdict: Verdict) -> None:
    """Whether the numbers can be trusted, and all that has to be known about them."""
    Console(width=WIDE, highlight=False).print(str(verdict), markup=False)


def warn(verdict: Verdict, quiet: bool = False) -> None:
    """The same on standard error, where standard output belongs to JSON or to names of files."""
    for caution in () if quiet else verdict.warnings:
        typer.echo(f"{'warning' if caution.doubt else 'note'}: {caution.text}", err=True)


def print_files(files: Sequence[Path], verdict: Verdict, as_json: bool, quiet: bool = False) -> None:
    """Print the names of files that show a run, and what has to be known about that."""
    if as_json:
        print_json({"files": [str(file) for file in files], **verdict.record()})
    else:
        typer.echo("\n".join(str(file) for file in files))
    warn(verdict, quiet)


def record_of(result: Result) -> dict[str, Any]:
    """The JSON object of a run; a number that does not exist is None."""
    from toolkit.gradient_units import gradient_units
    from toolkit.validity.start_state import start_record

    scene = result.solution.system.scene
    return {
        "responses": {
            name: {"value": finite_or_none(value), "unit": result.units[name]} for name, value in result.values.items()
        },
        "gradients": {
            name: {variable: finite_or_none(slope) for variable, slope in slopes.items()}
            for name, slopes in result.gradients.items()
        },
        "gradient_units": gradient_units(scene, result.gradients),
        **({"start": start_record(result.solution)} if result.solution.steps else {}),
        "run": {
            "method": result.method,
            "reason": result.reason,
            "steps": result.solution.load_steps or result.solution.steps,
            "newton_iterations": result.solution.newton_iterations,
            "wall_s": {"primal": result.wall_primal, "sensitivity": result.wall_sensitivity},
            **path_record(result),
        },
        **result.verdict.record(),
    }


def path_record(result: Result) -> dict[str, Any]:
    """What a static solution has passed on its path, if that was followed past limit points."""
    path = result.solution.path
    if not path or not path.passed_limit:
        return {}
    return {
        "beyond_snap_through": True,
        "limit_points": [{"load_factor": each.load_factor, "coordinate": each.coordinate} for each in path.limit_points],
        "unstable_equilibria_under_full_load": path.unstable_crossings,
    }


def finite_or_none(value: float) -> float | None:
    """JSON knows no nan."""
    return value if math.isfinite(value) else None


def print_tables(result: Result) -> None:
    """Values and gradients as tables."""
    console = Console(width=WIDE, highlight=False)
    values = table("response", "value", "unit")
    for name, value in result.values.items():
        values.add_row(name, f"{value:.6g}", result.units[name])
    console.print(values)
    variables = next(iter(result.gradients.values()), {})
    if variables:
        wide = len(variables) > MOST_COLUMNS
        of, by = [_in_unit(name, result.units[name]) for name in result.gradients], _variables_in_units(result, list(variables))
        gradients = table("gradient by", *(of if wide else by))
        for name, label in zip(variables if wide else result.gradients, by if wide else of, strict=True):
            slopes = [each[name] for each in result.gradients.values()] if wide else result.gradients[name].values()
            gradients.add_row(label, *(f"{slope:.6g}" for slope in slopes))
        console.print(gradients)


def _in_unit(name: str, unit: str) -> str:
    return f"{name}, {unit}" if unit else name


def _variables_in_units(result: Result, names: list[str]) -> list[str]:
    """Design variables with their units: a gradient is in that of its response over that of its variable."""
    from toolkit.gradient_units import variable_unit

    scene = result.solution.system.scene
    return [_in_unit(name, variable_unit(scene, scene.path_of(scene.design.get(name, name)))) for name in names]


def print_frequencies(frequencies: list[float]) -> None:
    """Table of eigenfrequencies."""
    found = table("mode", "frequency in Hz")
    for number, frequency in enumerate(frequencies, 1):
        found.add_row(str(number), f"{frequency:.6g}")
    Console(width=WIDE, highlight=False).print(found)
    if frequencies and frequencies[0] < 0:
        typer.echo("A negative frequency f means an unstable equilibrium: motions grow like exp(2 pi |f| t).")


def table(first: str, *others: str) -> Table:
    """An empty table: a column of words, columns of numbers."""
    made = Table(box=SIMPLE)
    made.add_column(first)
    for name in others:
        made.add_column(name, justify="left" if name in LEFT else "right")
    return made
