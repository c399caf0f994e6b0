"""Checks of a scene's numbers: those that are invalid are refused by name before anything is compiled."""

from __future__ import annotations

import numpy as np

from toolkit.bodies.model_body import ModelBody
from toolkit.foundation.errors import InputError
from toolkit.joints.joint import BetweenPoints
from toolkit.loads.springs import PointSpring
from toolkit.reduced_model.questions import check_parameters
from toolkit.scene.resolution import ResolvedScene
from toolkit.scene.scene import Scene

SAME_PLACE = 1e-12
"""Distance of two points, relative to the model size, below which no direction leads from one to the other."""


def check_numbers(scene: ResolvedScene) -> None:
    """Refuse scenes without a moving body, parameters that no body has, and pairs of points without a direction.

    Raises
    ------
    InputError
        Names the path and what would be right.
    """
    if not scene.bodies:
        raise InputError("the scene has no body, so nothing can move. Add one to its table [bodies].")
    for name, body in scene.bodies.items():
        if isinstance(body, ModelBody):
            check_parameters(body.model_values(), scene.model(body.model).nominal, f"bodies.{name}", scene.dimension)
    for user, pair in pairs(scene).items():
        first, second = (np.real(scene.position(point)) for point in pair)
        if np.abs(first - second).max() <= SAME_PLACE * scene.size:
            raise InputError(
                f"{user} leads from point {pair[0]!r} to point {pair[1]!r}, which are at the same place, so it has no direction. "
                "Move one of them."
            )


def pairs(scene: Scene) -> dict[str, tuple[str, str]]:
    """Everything that has a direction from one point to another: rods, distance joints, springs along a line."""
    rods = {f"bodies.{name}": getattr(body, "between", None) for name, body in scene.bodies.items()}
    links = {f"joints.{name}": joint.points for name, joint in scene.joints.items() if isinstance(joint, BetweenPoints)}
    springs = {f"loads.{name}": load.points for name, load in scene.loads.items() if isinstance(load, PointSpring)}
    return {user: pair for user, pair in {**rods, **links, **springs}.items() if pair is not None}
