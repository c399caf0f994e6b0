"""The command `ffrf check-deformation`: flexible bodies solved again with elements that turn, under the same forces."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import typer
from rich.console import Console

from toolkit.command_line.arguments import Changes, Static, read
from toolkit.command_line.keeping import Models, SceneOrResults, is_results, motion_of, solved
from toolkit.command_line.printed.printing import WIDE, print_verdict, table, warn
from toolkit.foundation.errors import InputError
from toolkit.foundation.terminal import AsJson, Quiet, print_json

if TYPE_CHECKING:
    from pathlib import Path

    from toolkit.system.solution import Solution
    from toolkit.validity.bodies.corotational_check import Comparison


def check_deformation(
    file: SceneOrResults,
    static: Static = False,
    changes: Changes = None,
    models: Models = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Solve the flexible bodies again with elements that turn, under the same forces, and print how far the linear ones are off."""
    from toolkit.validity.bodies.corotational_check import compare_with_corotational, flexible_of

    solution = _solution(file, static, changes, models, quiet)
    found = {body: compare_with_corotational(solution, body) for body in flexible_of(solution)}
    if as_json:
        checked = {body: record_of_check(each, solution) for body, each in found.items()}
        print_json({"deformation": checked, **solution.verdict.record()})
        warn(solution.verdict, quiet)
    else:
        print_check(found, solution)
        print_verdict(solution.verdict)


def _solution(file: Path, static: bool, changes: list[str] | None, models: Path | None, quiet: bool) -> Solution:
    if not static:
        return motion_of(file, changes, models, quiet)()
    if is_results(file):
        raise InputError("--static belongs to a scene; results are of the analysis that they were kept of. Leave it out.")
    return solved(read(file, changes, quiet), "static", quiet)


def record_of_check(found: Comparison, solution: Solution) -> dict[str, Any]:
    """Part of the JSON object for one body."""
    from toolkit.foundation.units import unit

    units = solution.system.scene.units
    length, stress = unit(units, "length"), unit(units, "stress")
    return {
        "time": found.estimate.time,
        "largest_rotation": {"value": found.estimate.rotation, "unit": "rad"},
        "largest_displacement": {"value": found.estimate.displacement, "unit": length},
        "estimated_error": {"value": found.estimate.error, "unit": length},
        "error": {"value": found.error, "unit": length},
        "relative_error": found.relative,
        "largest_stress": {"value": found.stress, "corotational": found.corotational_stress, "unit": stress},
        "stress_error": {"value": found.stress_error, "unit": stress},
    }


def print_check(found: dict[str, Comparison], solution: Solution) -> None:
    """One row per body, then what is compared."""
    from toolkit.foundation.units import unit

    units = solution.system.scene.units
    length, stress = unit(units, "length"), unit(units, "stress")
    rows = table(
        "body", f"displacement, {length}", f"geometric error, {length}", "of displacement", f"estimate, {length}",
        f"stress, {stress}", f"corotational, {stress}", f"largest difference, {stress}",
    )  # fmt: skip
    for body, each in found.items():
        rows.add_row(
            body, f"{each.estimate.displacement:.6g}", f"{each.error:.4g}", f"{each.relative:.2%}", f"{each.estimate.error:.4g}",
            f"{each.stress:.6g}", f"{each.corotational_stress:.6g}", f"{each.stress_error:.4g}",
        )  # fmt: skip
    Console(width=WIDE, highlight=False).print(rows)
    for body, each in found.items():
        typer.echo(
            f"{body} at t = {each.estimate.time:g}: linear elements against corotational ones under the same forces in the body's frame "
            "(joints, loads, and inertia)."
        )
