"""Whether the mesh of a body is fine enough for its stress: what its preprocessing has estimated, in words."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from toolkit.foundation.units import unit
from toolkit.foundation.verdict import Caution
from toolkit.reduced_model.model import ReducedModel

COARSE = 0.15
"""Error in the energy norm above which a mesh is questioned.

Where the exact stress is known, with quadratic elements, the largest stress is then off by a tenth or more; estimates of meshes with few
linear elements are too small by up to a half."""


TOO_STIFF = 0.25
"""The same above which displacements and frequencies are questioned too: the energy is off by its square, a twentieth and more."""


ROUND_OFF = 1e-4
"""Error below which nobody looks for its size: of a body whose exact stress the mesh holds it is round-off."""


def worst_case(model: ReducedModel) -> tuple[str, float] | None:
    """The load case with the largest estimated error; None where nothing was estimated."""
    return max(model.stress_errors.items(), key=lambda each: each[1], default=None)


def told_mesh(model: ReducedModel) -> str:
    """Estimated stress error of the mesh in a sentence; empty where there is none."""
    worst = worst_case(model)
    if worst is None:
        return ""
    of_cases = f"in the energy norm ({worst[0]}, the worst of {len(model.stress_errors)} load cases)"
    if worst[1] < ROUND_OFF:
        return f"stress of this mesh off by less than {100 * ROUND_OFF:g} % {of_cases}"
    return f"stress of this mesh off by some {100 * worst[1]:.2g} % {of_cases}, most of it near {_place(model)}"


def mesh_record(model: ReducedModel) -> dict[str, Any] | None:
    """Estimated stress error of the mesh as numbers with their meanings, for JSON and tables; None where there is none."""
    if not model.stress_errors:
        return None
    return {
        "told": told_mesh(model),
        "measure": "estimated error of the stress in the energy norm, in parts of the stress",
        "cases": dict(model.stress_errors),
        "place": dict(model.stress_error_at),
        "place_unit": unit(model.units, "length"),
    }


def mesh_questions(model: ReducedModel, where: str, doubt: bool = False, limit: float = COARSE) -> Iterator[Caution]:
    """Caution about a mesh that is too coarse, for its stress or by another limit."""
    worst = worst_case(model)
    if worst is not None and worst[1] > limit:
        yield Caution(
            "coarse-mesh",
            f"{where}: {told_mesh(model)}: more than {limit:.0%}. Mesh it finer there{_advice(model)}, and run "
            "ffrf-preprocess again.",
            doubt,
        )


def _advice(model: ReducedModel) -> str:
    """Advice beside a finer mesh: other elements, unless all of the mesh have nodes between their corners, by their names."""
    kinds = json.loads(str(model.composition.get("elements", "{}")))
    quadratic = bool(kinds) and all(kind[-1:].isdigit() for kind in kinds)
    return "" if quadratic else ", or take elements with nodes between their corners"


def _place(model: ReducedModel) -> str:
    place = ", ".join(f"{value:.4g}" for value in model.stress_error_at.values())
    return f"({place}) {unit(model.units, 'length')}"
