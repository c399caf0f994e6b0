"""What pressures on the pieces of a solid push them with between their ends, per length, in the axes of the frame."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.compilation.quantities import pressures_of
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chains.chain import Chain
from toolkit.validity.bodies.chains.sides import sides_of


def is_pressed(scene: Scene) -> bool:
    """Whether any load is a pressure."""
    return bool(pressures_of(scene))


def pressure_on_elements(solution: Solution, name: str, behind: Chain, instants: np.ndarray) -> np.ndarray | float:
    """Of a body in pieces, or a part of one, (n_t, n_e, 3); zero of others."""
    scene, found = solution.system.placed, 0.0
    part: Any = scene.body(name)
    whole, own = getattr(part, "whole", name), slice(getattr(part, "first", None), getattr(part, "last", None))
    for load in pressures_of(scene).values():
        if load.body != whole:
            continue
        design = scene.bodies[whole].design_point(scene, "elements", "piece_loads")  # type: ignore[attr-defined]
        if design.model.piece_loads is not None:
            force = np.real(design.value(f"piece_loads.{load.surface}.force"))[own] / sides_of(behind).lengths[:, None]
            factor = np.real(load.pressure) * np.real(load.curve.evaluate(solution.times[instants]))[:, 0]
            found = found + factor[:, None, None] * force
    return found
