"""A flexible body in space whose number of floating frames was chosen by runs of the scene."""

from __future__ import annotations

from typing import ClassVar

from toolkit.bodies.cut.chosen_frames import ChosenFrames
from toolkit.bodies.flexible import SpatialFlexible
from toolkit.bodies.model_body import ModelBody


class SpatialChosenFrames(ChosenFrames, SpatialFlexible):
    """A flexible body in space whose number of floating frames was chosen by runs of the scene."""

    kind = ""
    uncut_kind: ClassVar[type[ModelBody]] = SpatialFlexible
