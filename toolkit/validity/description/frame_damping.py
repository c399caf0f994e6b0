"""Mass-proportional damping, of which bodies with several floating frames keep little."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.foundation.verdict import Caution
from toolkit.scene.scene import Scene


def frames_that_damp_less(scene: Scene) -> Iterator[Caution]:
    """Cut bodies with mass-proportional damping: it acts on what moves in the frames of the parts, less the more parts there are."""
    given = scene.model_parameters()
    for name, body in scene.bodies.items():
        path = f"bodies.{name}.damping_mass"
        if isinstance(body, CutBody) and len(body.cuts) > 2 and path in given and np.real(scene.number(path)) > 0:
            yield Caution(
                "frame-damping",
                f"{name} has mass-proportional damping and {len(body.cuts) - 1} floating frames: it acts on what moves in the frame of "
                "each part, and is lost for what moves the frames, so that motions are damped less the more frames there are. Use "
                "stiffness-proportional damping, or one frame.",
            )
