"""How many frames would bring the geometric error of a body below its limit."""

from __future__ import annotations

import numpy as np

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.scene.resolution import ResolvedScene, cuttable, fewest_cut, most_frames
from toolkit.system.flexible_bodies import elements_of


def divided(scene: ResolvedScene, body: str, excess: float) -> str:
    """What divides a body whose error is so many times what it may be: frames in a number where its model allows them.

    The error falls with the square of the number.
    """
    written = scene.bodies[body]
    if body not in cuttable(scene):
        return "model the body as several bodies in a row"
    now = len(written.cuts) - 1 if isinstance(written, CutBody) else 1
    most = most_frames(scene, body)
    wanted = int(np.ceil(now * np.sqrt(excess))) if np.isfinite(excess) else most + 1
    enough = max(now + 1, fewest_cut(scene, body), wanted)
    if enough > most:
        return (
            f"build the model with more {elements_of(scene, body)}, and as many frames"
            if now == most
            else f"set frames = {most} in its table (one floating frame for each {elements_of(scene, body)[:-1]})"
        )
    return f"set frames = {enough} in its table (splits the body into {enough} floating frames)"
