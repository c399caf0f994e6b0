"""Where rates mean something: not in a run without inertia."""

from __future__ import annotations

from typing import Any

from toolkit.foundation.errors import InputError


def refuse_rates_without_inertia(scene: Any, kind: str) -> None:
    """Refuse what is made of velocities or accelerations in a quasi-static run, whose velocities are those of the middle of a step.

    Raises
    ------
    InputError
        Says what can be asked for instead.
    """
    if scene.solver.quasi_static:
        raise InputError(
            f"a quasi-static run (solver.quasi_static) knows no {kind}: it goes from one equilibrium to the next, and its velocities are "
            "those between them. Ask for places and angles, or run with inertia."
        )
