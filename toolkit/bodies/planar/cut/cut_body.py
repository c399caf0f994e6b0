"""A flexible body in the plane that is cut at nodes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.bodies.cut.framed_part import FramedPart
from toolkit.bodies.flexible import Flexible
from toolkit.bodies.model_body import ModelBody
from toolkit.reduced_model.cut.craig_bampton import PartShapes
from toolkit.reduced_model.cut.part import Part
from toolkit.reduced_model.cut.planar_part import planar_part


class PlanarFramedPart(FramedPart, Flexible):
    """Part of a cut body in the plane, whose floating frame has two coordinates and an angle."""

    kind = ""
    per_node: ClassVar[int] = 3
    frame_coordinates: ClassVar[int] = 3

    @staticmethod
    def assembled(elements: Any, first: int, last: int, stress_elements: np.ndarray, shapes: PartShapes | None = None) -> Part:
        """Planar part that is assembled from elements at one design, see `planar_part`."""
        return planar_part(elements, first, last, stress_elements, shapes)

    def elastic_names(self, nodes: list[int]) -> Iterator[str]:
        """Names of the elastic coordinates: the first node only turns, and the last one turns and moves along the chord."""
        yield f"rotation of node {nodes[0]}"
        yield from (f"{axis} of node {k}" for k in nodes[1:-1] for axis in ("x", "y", "rotation"))
        yield from (f"{axis} of node {nodes[-1]}" for axis in ("displacement along the chord", "rotation"))


class PlanarCutBody(CutBody, Flexible):
    """A flexible body in the plane that is cut into parts, which move and turn in the plane."""

    kind = ""
    uncut_kind: ClassVar[type[ModelBody]] = Flexible
    part_kind: ClassVar[type[FramedPart]] = PlanarFramedPart
