"""Hints on an error that a body's frame may explain: one that is fixed to the ground by mistake, or one that is not."""

from __future__ import annotations

from collections.abc import Iterable

from toolkit.bodies.body import Body
from toolkit.bodies.model_body import ModelBody
from toolkit.foundation.errors import quoted
from toolkit.reduced_model.model import MEAN_AXES
from toolkit.scene.scene import Scene


def grounded(scene: Scene) -> dict[str, Body]:
    """Bodies of the scene whose frame is fixed to the ground."""
    return {name: body for name, body in scene.bodies.items() if not body.has_frame}


def floats_with_its_clamp(scene: Scene, name: str) -> bool:
    """Whether a body is a flexible one that its own model clamps, in a frame that moves."""
    body = scene.bodies.get(name)
    return isinstance(body, ModelBody) and body.has_frame and scene.model(body.model).reference_condition != MEAN_AXES


def hint_of_grounded(scene: Scene, joints: Iterable[str]) -> str:
    """A sentence on the grounded bodies that take part in joints; empty if there are none."""
    fixed, joined = grounded(scene), {body for joint in joints for body in scene.joints[joint].bodies}
    named = [name for name in fixed if name in joined]
    if not named:
        return ""
    which = f"Body {named[0]!r} is" if len(named) == 1 else f"Bodies {quoted(named)} are"
    return f' {which} fixed to the ground by frame = "grounded", the likely cause if it is a part of the mechanism: write frame = "moving".'


def hint_of_floating(scene: Scene, bodies: Iterable[str]) -> str:
    """A sentence on the bodies that `frame = "grounded"` would hold by the clamp of their models; empty if there are none."""
    named = [name for name in dict.fromkeys(bodies) if floats_with_its_clamp(scene, name)]
    if not named:
        return ""
    which = f"Body {named[0]!r} moves" if len(named) == 1 else f"Bodies {quoted(named)} move"
    return f' {which} with the frame; frame = "grounded" fixes what the reduced model clamps to the ground.'
