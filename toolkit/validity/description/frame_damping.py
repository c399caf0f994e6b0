"""Mass-proportional damping that differs along a body, which acts on what moves in the body's frame alone."""

from __future__ import annotations

from collections.abc import Iterator

from toolkit.bodies.model_body import MASS_DAMPING, ModelBody
from toolkit.foundation.verdict import Caution
from toolkit.scene.scene import Scene


def damping_in_the_frame(scene: Scene) -> Iterator[Caution]:
    """Bodies with a moving frame, whose elements have mass-proportional damping of their own."""
    given = scene.model_parameters()
    for name, body in scene.bodies.items():
        own = any(path.startswith(f"bodies.{name}.{MASS_DAMPING}_") for path in given)
        if own and isinstance(body, ModelBody) and body.has_frame and body.damping_differs(scene):
            yield Caution(
                "frame-damping",
                f"elements of {name} have mass-proportional damping of their own: it acts on what moves in the body's frame alone, so that "
                "it is less the more the frame moves with the body, and depends on where the frame is tied to it. Give the whole body "
                "one mass-proportional damping, which acts on all of its velocity, or damp the elements by their stiffness.",
            )
