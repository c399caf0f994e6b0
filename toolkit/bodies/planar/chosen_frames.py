"""A flexible body whose number of floating frames was chosen by runs of the scene."""

from __future__ import annotations

from toolkit.bodies.cut.frame_choice import FrameChoice
from toolkit.bodies.planar.flexible import Flexible


class ChosenFrames(Flexible):
    """What a scene writes of the body, with a number in the place of `frames = "auto"`."""

    kind = ""

    choice: FrameChoice
