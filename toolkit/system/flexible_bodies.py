"""Flexible bodies of a scene by name: their reduced model, and where their elastic coordinates are."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.bodies.model_body import ModelBody
from toolkit.description.design import BodyPoint
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.solution import Solution


def flexible_body(scene: ResolvedScene, body: str) -> ModelBody:
    """Flexible body of that name.

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


def deforming(scene: ResolvedScene) -> dict[str, ModelBody]:
    """Flexible bodies that have coordinates; of a cut body its parts."""
    return {
        name: body for name, body in scene.all_bodies().items() if isinstance(body, ModelBody) and not isinstance(body, CutBody)
    }


def elastic_coordinates(solution: Solution, body: str) -> Any:
    """Places of a body's elastic coordinates on the second axis of q.

    They are a slice, or the numbers of those of all parts of a cut body.
    """
    if isinstance(found := solution.system.scene.bodies.get(body), CutBody):
        return solution.system.numbering.first[body] + found.elastic_places
    whole = solution.coordinates(body)
    return slice(whole.start + flexible_body(solution.system.scene, body).frame_size, whole.stop)


def design_point(scene: ResolvedScene, body: str, *parts: str) -> DesignPoint:
    """The reduced model of a flexible body at the scene's parameter values; `parts` as of `Scene.model`."""
    return flexible_body(scene, body).design_point(scene, *parts)


def is_in_pieces(scene: ResolvedScene, body: str) -> bool:
    """Whether a flexible body, or that which it is part of, is a solid in pieces."""
    return scene.model(flexible_body(scene, body).model).in_pieces


def elements_of(scene: ResolvedScene, body: str) -> str:
    """Word by which a flexible body, or a part of one, calls its elements."""
    return scene.model(flexible_body(scene, body).model).elements_called


def used_interfaces(scene: ResolvedScene, body: str) -> list[str]:
    """Interface points of a flexible body's reduced model that the scene has points at, in order."""
    known = design_point(scene, body, "interfaces").model.interfaces or {}
    mine = {point.interface for point in scene.points.values() if isinstance(point, BodyPoint) and point.body == body}
    return sorted(mine & {*known})


def spins_of(solution: Solution, body: str, instants: Any = slice(None)) -> np.ndarray:
    """Angular velocity (n_t, 3) of a flexible body's frame at some instants of a run, in the axes of its reduced model."""
    where, found = solution.coordinates(body), flexible_body(solution.system.scene, body)
    return found.spins(np.real(solution.q[instants][:, where]), np.real(solution.v[instants][:, where]))
