"""A flexible body in space that is cut at nodes."""

from __future__ import annotations

from typing import ClassVar

from toolkit.bodies.body import QUATERNION
from toolkit.bodies.cut.cut_body import CutBody
from toolkit.bodies.cut.framed_part import FramedPart
from toolkit.bodies.model_body import ModelBody
from toolkit.bodies.spatial.cut.framed_part import SpatialFramedPart
from toolkit.bodies.spatial.flexible import SpatialFlexible


class SpatialCutBody(CutBody, SpatialFlexible):
    """A flexible body in space that is cut into parts, which move and turn in space."""

    kind = ""
    uncut_kind: ClassVar[type[ModelBody]] = SpatialFlexible
    part_kind: ClassVar[type[FramedPart]] = SpatialFramedPart

    @property
    def moves(self) -> int:
        """Number of coordinates of the frame's origin in each part."""
        return 3

    @property
    def turns(self) -> int:
        """Number of coordinates of the frame's orientation in each part, those of a quaternion."""
        return QUATERNION
