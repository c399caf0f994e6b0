"""A flexible body in the plane that is cut at nodes."""

from __future__ import annotations

from typing import ClassVar

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.bodies.cut.framed_part import FramedPart
from toolkit.bodies.model_body import ModelBody
from toolkit.bodies.planar.cut.framed_part import PlanarFramedPart
from toolkit.bodies.planar.flexible import Flexible


class PlanarCutBody(CutBody, Flexible):
    """A flexible body in the plane that is cut into parts, which move and turn in the plane."""

    kind = ""
    uncut_kind: ClassVar[type[ModelBody]] = Flexible
    part_kind: ClassVar[type[FramedPart]] = PlanarFramedPart
