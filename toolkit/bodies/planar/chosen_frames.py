"""A flexible body whose number of floating frames was chosen by runs of the scene."""

from __future__ import annotations

from typing import NamedTuple

from toolkit.bodies.planar.flexible import Flexible


class FrameChoice(NamedTuple):
    """What a number of frames was chosen by."""

    wanted: float  # geometric error, in parts of the largest displacement of the body
    error: float  # what the last of these runs leaves, estimated
    numbers: tuple[int, ...]  # of frames, one run after the other
    analysis: str


class ChosenFrames(Flexible):
    """What a scene writes of the body, with a number in the place of `frames = "auto"`."""

    kind = ""

    choice: FrameChoice
