"""A flexible body in the plane that is cut at nodes."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.bodies.cut.framed_part import FramedPart
from toolkit.bodies.model_body import ModelBody
from toolkit.bodies.planar.cut.framed_part import PlanarFramedPart
from toolkit.bodies.planar.flexible import Flexible
from toolkit.kinematics.planar import rotation


class PlanarCutBody(CutBody, Flexible):
    """Its parts move and turn in the plane."""

    kind = ""
    uncut_kind: ClassVar[type[ModelBody]] = Flexible
    part_kind: ClassVar[type[FramedPart]] = PlanarFramedPart

    @property
    def placement(self) -> np.ndarray:
        """Rotation matrix of the reduced model's axes at the start, (2, 2)."""
        return rotation(self.angle)
