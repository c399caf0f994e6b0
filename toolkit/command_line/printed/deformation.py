"""What commands say about the small deformations that the formulation assumes: a table, and a part of the JSON object."""

from __future__ import annotations

from collections.abc import Mapping
from math import isnan
from typing import TYPE_CHECKING, Any

from rich.console import Console

from toolkit.command_line.printed.printing import WIDE, finite_or_none, table
from toolkit.foundation.units import unit

if TYPE_CHECKING:
    from toolkit.system.solution import Solution
    from toolkit.validity.bodies.bent_surfaces import Measured

Deformations = Mapping[str, "Measured | None"]


def record_of_deformations(solution: Solution, found: Deformations) -> dict[str, Any]:
    """Part of the JSON object of a run: null for a body of which no meter knows anything."""
    from toolkit.validity.bodies.deformation import LIMIT

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
    """Print a table with one row per flexible body."""
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
        words = ["-" if isnan(number) else f"{number:.3g}" for number in numbers] if numbers else ["not available"] * 5
        rows.add_row(body, *words)
    Console(width=WIDE, highlight=False).print(rows)
