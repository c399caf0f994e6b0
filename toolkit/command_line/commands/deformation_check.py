"""The command `ffrf check-deformation`: flexible bodies solved again with elements that turn, under the same forces."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import typer
from rich.console import Console

from toolkit.command_line.arguments import Changes, Static, Variables, design_of, read
from toolkit.command_line.keeping import Models, SceneOrResults, is_results, motion_of, solved
from toolkit.command_line.printed.printing import WIDE, finite_or_none, print_verdict, table, warn
from toolkit.foundation.errors import InputError
from toolkit.foundation.terminal import AsJson, Quiet, print_json

if TYPE_CHECKING:
    from pathlib import Path

    from toolkit.sensitivity.certificate.whole_mechanism import Mechanism
    from toolkit.system.solution import Solution
    from toolkit.validity.bodies.corotational.comparison import Comparison


def check_deformation(
    file: SceneOrResults,
    static: Static = False,
    variables: Variables = None,
    changes: Changes = None,
    models: Models = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Solve flexible bodies again with elements that turn: alone under the same forces, and the whole mechanism with its gradients."""
    from toolkit.foundation.verdict import Verdict
    from toolkit.sensitivity.certificate.whole_mechanism import compare_mechanism
    from toolkit.validity.bodies.corotational.comparison import compare_with_corotational, flexible_of

    solution = _solution(file, static, changes, models, quiet)
    scene = solution.system.scene
    names = design_of(scene, variables) if scene.design or variables else []
    whole = compare_mechanism(solution, names)
    alone = [body for body in flexible_of(solution) if body in scene.bodies]
    if whole is not None and not scene.space.turning_elements:  # the mechanism alone tells of beams in space
        alone = [body for body in alone if body not in whole.elements]
    found = {body: compare_with_corotational(solution, body) for body in alone}
    verdict = Verdict.of([*solution.verdict.warnings, *(whole.cautions() if whole else [])], solution.verdict.measures)
    if as_json:
        checked = {body: record_of_check(each, solution) for body, each in found.items()}
        print_json({"deformation": checked, "mechanism": whole and record_of_mechanism(whole), **verdict.record()})
        warn(verdict, quiet)
    else:
        if found:
            print_check(found, solution)
        if whole is not None:
            print_mechanism(whole)
        print_verdict(verdict)


def _solution(file: Path, static: bool, changes: list[str] | None, models: Path | None, quiet: bool) -> Solution:
    if not static:
        return motion_of(file, changes, models, quiet)()
    if is_results(file):
        raise InputError("--static belongs to a scene; results are of the analysis that they were kept of. Leave it out.")
    return solved(read(file, changes, quiet), "static", quiet)


def record_of_check(found: Comparison, solution: Solution) -> dict[str, Any]:
    """JSON object of one body's check."""
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


def record_of_mechanism(found: Mechanism) -> dict[str, Any]:
    """JSON object of the check of the whole mechanism."""
    record: dict[str, Any] = {
        "elements": dict(found.elements),
        "distances": dict(found.distances),
        "failure": found.failure or None,
    }
    if found.own is None or found.corotational is None:
        return record
    own, exact = found.own, found.corotational
    responses = {f: {"value": value, "corotational": exact.values[f], "unit": own.units[f]} for f, value in own.values.items()}
    gradients = {
        f: {
            x: {
                "value": finite_or_none(slope),
                "corotational": finite_or_none(exact.gradients[f][x]),
                "central_difference": found.quotients[f].get(x),
            }
            for x, slope in slopes.items()
        }
        for f, slopes in own.gradients.items()
    }
    return {**record, "responses": responses, "gradients": gradients}


def print_mechanism(found: Mechanism) -> None:
    """Print distances of the bodies, then values and gradients of both mechanisms."""
    if found.own is None or found.corotational is None:
        return
    console, own, exact = Console(width=WIDE, highlight=False), found.own, found.corotational
    values = table("response", "of these frames", "a frame to every element", "off by", "unit")
    for f, value in own.values.items():
        values.add_row(f, f"{value:.6g}", f"{exact.values[f]:.6g}", _off(value, exact.values[f]), own.units[f])
    slopes = table("gradient", "by", "of these frames", "a frame to every element", "off by", "its central difference")
    for f, row in own.gradients.items():
        for x, slope in row.items():
            true, quotient = exact.gradients[f][x], found.quotients[f].get(x)
            said = "wrong sign" if slope * true < 0 else _off(slope, true)
            slopes.add_row(f, x, f"{slope:.6g}", f"{true:.6g}", said, "-" if quotient is None else f"{quotient:.6g}")
    console.print(values)
    if own.gradients:
        console.print(slopes)
    for body, count in found.elements.items():
        apart = (
            f": nodes are up to {found.distances[body]:.2%} of the largest displacement from where they are with the frames of the scene"
            if body in found.distances
            else ""
        )
        frames = "1 frame" if count == 1 else f"{count} frames"
        typer.echo(f"The whole mechanism, joints in place, with {frames} in {body}, one to every element{apart}.")


def _off(value: float, true: float) -> str:
    return f"{value / true - 1:.2%}" if true else "-"


def print_check(found: dict[str, Comparison], solution: Solution) -> None:
    """Print one row per body, then what is compared."""
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
