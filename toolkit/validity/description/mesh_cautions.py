"""Flexible bodies whose mesh is too coarse for their stress, if a scene asks for it, or for their deflections, and those in pieces whose
faces make them softer or stiffer."""

from __future__ import annotations

from collections.abc import Iterator

from toolkit.bodies.model_body import ModelBody
from toolkit.foundation.verdict import SCENE, Caution, check
from toolkit.reduced_model.questions import COARSE, TOO_STIFF, face_questions, mesh_questions
from toolkit.responses.local_stress import LocalStress
from toolkit.responses.over_time import OverTime
from toolkit.responses.stress import StressResponse
from toolkit.scene.scene import Scene


@check("coarse-mesh", (SCENE,))
def cautions_of_meshes(scene: Scene) -> Iterator[Caution]:
    """A doubt for every body with a mesh that is too coarse for its stress, if that is asked for, or for its deflections, or with faces
    between its pieces that count."""
    asked = bodies_of_stress(scene)
    for name, body in scene.bodies.items():
        if isinstance(body, ModelBody):
            limit = COARSE if name in asked else TOO_STIFF
            yield from mesh_questions(scene.model(body.model), f"body {name!r}", doubt=True, limit=limit)
            yield from face_questions(scene.model(body.model), f"body {name!r}", doubt=True)


def bodies_of_stress(scene: Scene) -> set[str]:
    """Bodies whose stress a response asks for."""
    return {each.body for each in map(_looked_at, scene.responses.values()) if isinstance(each, StressResponse | LocalStress)}


def _looked_at(response: object) -> object:
    return _looked_at(response.source) if isinstance(response, OverTime) else response
