"""A random scene with finer models of its flexible bodies: what a doubt about a model is judged by."""

from __future__ import annotations

from typing import Any

from tests.random_scenes.models import finer_file
from toolkit.components.bodies.model_body import ModelBody
from toolkit.scene.scene import Scene

FRAMES = 4
"""Floating frames of a finer body; twice as many change the answers by less than doubts are about."""


def finer_scene(scene: Scene) -> Scene | None:
    """The scene with more elements, all of their shapes, and more frames in its bodies; None where there is nothing to refine."""
    bodies = {name: _finer(scene, body) for name, body in scene.bodies.items()}
    if all(bodies[name] is scene.bodies[name] for name in bodies):
        return None
    return scene.model_copy(update={"bodies": bodies})


def _finer(scene: Scene, body: Any) -> Any:
    if not isinstance(body, ModelBody):
        return body
    file = finer_file(scene.directory, body.model.removesuffix(".h5"))
    return body if file is None else body.model_copy(update={"model": file, "frames": FRAMES})
