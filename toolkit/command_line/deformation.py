"""What commands say about the small deformations that the formulation assumes: a table, a part of the JSON object, warnings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import typer
from rich.console import Console

from toolkit.command_line.report import WIDE, finite_or_none, table
from toolkit.errors import ConvergenceError
from toolkit.units import unit

if TYPE_CHECKING:
    from toolkit.scene import Scene
    from toolkit.solution import Solution
    from toolkit.validity.deformation import Deformation

Deformations = Mapping[str, "Deformation | None"]


@contextmanager
def watched_speed(scene: Scene, quiet: bool) -> Iterator[None]:
    """Warn before the run of bodies that start faster than their critical speed, and when it fails, of the speeds that may be why."""
    from toolkit.validity.critical_speed import critical_speed, spinning_bodies, too_fast_at_start

    fast = {body: speeds for body, *speeds in too_fast_at_start(scene)}
    for body, speeds in {} if quiet else fast.items():
        typer.echo(too_fast(body, *speeds), err=True)
    try:
        yield
    except ConvergenceError:
        for body in spinning_bodies(scene):
            if body not in fast and not quiet:
                typer.echo(
                    f"note: a frame that spins faster than {critical_speed(scene, body):.4g} rad/s, the critical speed of {body}, diverges "
                    "in linear FFRF with any step, because centrifugal stiffening is not in it.",
                    err=True,
                )
        raise


def too_fast(body: str, speed: float, critical: float) -> str:
    """The warning of a body that spins beyond its critical speed."""
    return (
        f"warning: {body} spins with {speed:.4g} rad/s, faster than its critical speed of {critical:.4g} rad/s. Linear FFRF lacks "
        "centrifugal stiffening, so that the body bends out without bound or to a wrong state. Spin it slower, or make several bodies "
        "in a row of it."
    )


def warn_of_deformations(solution: Solution, found: Deformations) -> None:
    """Say on standard error which bodies are out of the range of small deformations, or have come to spin too fast."""
    from toolkit.validity.critical_speed import too_fast_at_start, too_fast_in_motion
    from toolkit.validity.deformation import LIMIT

    scene = solution.system.scene
    for body, each in found.items():
        if each is not None and each.exceeded:
            typer.echo(
                f"warning: {body} leaves the range of small deformations: it turns by up to {each.rotation:.2g} rad in its frame, and "
                f"elements that turn with it would be off by about {each.error:.2g} {unit(scene.units, 'length')} under the same "
                f"forces, {each.relative:.1%} of its displacement (limit {LIMIT:.0%}). ffrf check-deformation computes this error; a "
                "stiffer body, or several bodies in a row instead of one, make it smaller.",
                err=True,
            )
    told = {body for body, *_ in too_fast_at_start(scene)}
    for body, *speeds in too_fast_in_motion(solution):
        if body not in told:
            typer.echo(too_fast(body, *speeds), err=True)


def record_of_deformations(solution: Solution, found: Deformations) -> dict[str, Any]:
    """Part of the JSON object of a run: null for a body whose reduced model does not hold its elements."""
    from toolkit.validity.deformation import LIMIT

    length = unit(solution.system.scene.units, "length")
    return {
        body: each
        and {
            "largest_rotation": {"value": finite_or_none(each.rotation), "unit": "rad"},
            "largest_displacement": {"value": finite_or_none(each.displacement), "unit": length},
            "geometric_error": {"value": finite_or_none(each.error), "unit": length},
            "relative_to_displacement": finite_or_none(each.relative),
            "relative_to_size": finite_or_none(each.error / each.size),
            "limit": LIMIT,
            "time": each.time,
        }
        for body, each in found.items()
    }


def print_deformations(solution: Solution, found: Deformations) -> None:
    """A table with one row per flexible body."""
    if not found:
        return
    length = unit(solution.system.scene.units, "length")
    rows = table(
        "deformation of",
        "largest rotation, rad",
        f"displacement, {length}",
        f"geometric error, {length}",
        "of displacement",
        "of size",
    )
    for body, each in found.items():
        numbers = each and (each.rotation, each.displacement, each.error, each.relative, each.error / each.size)
        rows.add_row(body, *(f"{number:.3g}" for number in numbers or ()), *([] if numbers else ["not available"] * 5))
    Console(width=WIDE, highlight=False).print(rows)
