"""Flexible bodies of a scene by name: their reduced model, and where their elastic coordinates are."""

from __future__ import annotations

from typing import Any

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.bodies.model_body import ModelBody
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution


def flexible_body(scene: Scene, body: str) -> ModelBody:
    """The flexible body of that name.

    Raises
    ------
    InputError
        There is no such body, or it is not flexible; lists those that are.
    """
    found = scene.body(body)
    if not isinstance(found, ModelBody):
        flexible = [name for name, each in scene.bodies.items() if isinstance(each, ModelBody)]
        raise InputError(
            f"body {body!r} is not flexible, so it has no stress or shape; flexible bodies: {', '.join(flexible) or 'none'}."
        )
    return found


def deforming(scene: Scene) -> dict[str, ModelBody]:
    """The flexible bodies that have coordinates: of a cut body its parts."""
    return {
        name: body for name, body in scene.all_bodies().items() if isinstance(body, ModelBody) and not isinstance(body, CutBody)
    }


def elastic_coordinates(solution: Solution, body: str) -> Any:
    """Where the elastic coordinates of a body are on the second axis of q: a slice, or the numbers of those of all parts of a cut body."""
    if isinstance(found := solution.system.scene.bodies.get(body), CutBody):
        return solution.system.numbering.first[body] + found.elastic_places
    whole = solution.coordinates(body)
    return slice(whole.start + flexible_body(solution.system.scene, body).frame_size, whole.stop)


def design_point(scene: Scene, body: str, *parts: str) -> DesignPoint:
    """The reduced model of a flexible body at the scene's parameter values; `parts` as of `Scene.model`."""
    return flexible_body(scene, body).design_point(scene, *parts)
