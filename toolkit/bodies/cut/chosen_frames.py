"""A flexible body whose number of floating frames was chosen by runs of the scene."""

from __future__ import annotations

from typing import ClassVar

from toolkit.bodies.cut.cuttable_body import CuttableBody
from toolkit.bodies.cut.frame_choice import FrameChoice
from toolkit.bodies.model_body import ModelBody


class ChosenFrames(CuttableBody):
    """A flexible body as a scene writes it, with a number of floating frames in the place of `frames = "auto"`."""

    kind = ""
    uncut_kind: ClassVar[type[ModelBody]]
    """Class of the body that the scene has written."""

    choice: FrameChoice

    def uncut(self) -> ModelBody:
        """Body as the scene has written it, with the number of frames that was chosen.

        With one frame it is without `modes_per_frame`, as it has no parts to reduce.
        """
        chosen = {**dict(self), **self.model_values()}
        del chosen["choice"]
        if not self.parted:
            chosen["modes_per_frame"] = None
        return self.uncut_kind.model_construct(**chosen)
