"""What a scene's numbers cannot mean, refused by name before anything is compiled."""

from __future__ import annotations

import numpy as np

from toolkit.bodies.flexible import Flexible
from toolkit.errors import InputError
from toolkit.scene import Scene

SAME_PLACE = 1e-12
"""Distance of two points, relative to the scene's size, below which no direction leads from one to the other."""


def check_numbers(scene: Scene) -> None:
    """Refuse scenes without a moving body, parameters that are not positive, and pairs of points without a direction.

    Raises
    ------
    InputError
        Names the path and what would be right.
    """
    if not scene.bodies:
        raise InputError("the scene has no body, so nothing can move. Add one to its table [bodies].")
    for name, body in scene.bodies.items():
        if isinstance(body, Flexible):
            nominal = scene.model(body.model).nominal
            for parameter, value in body.model_values().items():
                absent = np.real(value) == nominal.get(parameter)  # damping, or a shape mode, that may be zero in the file
                if not np.real(value) > 0 and not absent:
                    raise InputError(f"bodies.{name}.{parameter} = {np.real(value):g} must be a positive number.")
    size = scene.size
    for user, pair in pairs(scene).items():
        first, second = (np.real(scene.position(point)) for point in pair)
        if np.abs(first - second).max() <= SAME_PLACE * size:
            raise InputError(
                f"{user} leads from point {pair[0]!r} to point {pair[1]!r}, which are at the same place, so it has no direction. "
                "Move one of them."
            )


def pairs(scene: Scene) -> dict[str, tuple[str, str]]:
    """Everything that runs between two points: rods, distance joints, springs."""
    groups = (("bodies", "between", scene.bodies), ("joints", "points", scene.joints), ("loads", "points", scene.loads))
    found = {f"{group}.{name}": getattr(item, key, None) for group, key, items in groups for name, item in items.items()}
    return {user: pair for user, pair in found.items() if pair is not None}
