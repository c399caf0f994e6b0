"""What a command prints about a run: one JSON object, or tables for people."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import typer
from rich.console import Console

from toolkit.command_line.printed.deformation import print_deformations, record_of_deformations
from toolkit.command_line.printed.printing import WIDE, finite_or_none, print_verdict, table, warn
from toolkit.command_line.printed.remarks import remarks
from toolkit.foundation.terminal import print_json

if TYPE_CHECKING:
    from toolkit.sensitivity.run import Run


def print_result(result: Run, as_json: bool, quiet: bool = False) -> None:
    """Print values, units and gradients of all responses, how far flexible bodies deform, what the run cost, and whether to trust it."""
    from toolkit.validity.bodies.bent_surfaces import geometric_errors

    found = geometric_errors(result.solution)
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


def record_of(result: Run) -> dict[str, Any]:
    """JSON object of a run; a number that does not exist is None."""
    from toolkit.scene_file.gradient_units import gradient_units
    from toolkit.validity.start.start_state import start_record

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


def path_record(result: Run) -> dict[str, Any]:
    """Record of what a static solution has passed on its path, if that was followed past limit points."""
    path = result.solution.path
    if not path or not path.passed_limit:
        return {}
    return {
        "beyond_snap_through": True,
        "limit_points": [{"load_factor": each.load_factor, "coordinate": each.coordinate} for each in path.limit_points],
        "unstable_equilibria_under_full_load": path.unstable_crossings,
    }


def print_tables(result: Run) -> None:
    """Print values and gradients as tables."""
    from toolkit.results.short_tables import table_of_gradients, table_of_values

    for found in filter(None, (table_of_values(result), table_of_gradients(result))):
        shown = table(*found.columns)
        for row in found.rows:
            shown.add_row(*row)
        Console(width=WIDE, highlight=False).print(shown)


def print_frequencies(frequencies: list[float], damping: list[float] | None = None) -> None:
    """Print a table of eigenfrequencies, and of damping in parts of the critical one."""
    found = table("mode", "frequency in Hz", *([] if damping is None else ["damping ratio"]))
    for number, frequency in enumerate(frequencies, 1):
        found.add_row(str(number), f"{frequency:.6g}", *([] if damping is None else [f"{damping[number - 1]:.3g}"]))
    Console(width=WIDE, highlight=False).print(found)
    if frequencies and frequencies[0] < 0:
        typer.echo("A negative frequency f means an unstable equilibrium: motions grow like exp(2 pi |f| t).")
