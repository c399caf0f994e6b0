"""A flexible body in space that is cut at nodes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from toolkit.bodies.body import QUATERNION, Placed
from toolkit.bodies.cut.cut_body import CutBody
from toolkit.bodies.cut.framed_part import FramedPart
from toolkit.bodies.flexible import SpatialFlexible
from toolkit.bodies.model_body import ModelBody
from toolkit.reduced_model.cut.craig_bampton import PartShapes
from toolkit.reduced_model.cut.part import Part
from toolkit.reduced_model.cut.spatial_part import SpatialPart, pressed, spatial_part
from toolkit.reduced_model.parts import PieceLoads, SurfaceLoad


class SpatialFramedPart(FramedPart, SpatialFlexible):
    """Part of a cut body in space, whose floating frame has three coordinates and a quaternion."""

    kind = ""
    per_node: ClassVar[int] = 6
    frame_coordinates: ClassVar[int] = 7

    @staticmethod
    def assembled(elements: Any, first: int, last: int, stress_elements: np.ndarray, shapes: PartShapes | None = None) -> Part:
        """Spatial part that is assembled from elements at one design, see `spatial_part`."""
        return spatial_part(elements, first, last, stress_elements, shapes)

    def surface_load(self, scene: Placed, surface: str) -> SurfaceLoad:
        """Load of a unit pressure on the pieces of a surface that belong to this part."""
        design = scene.bodies[self.whole].design_point(scene, "elements", "piece_loads")
        part, loads = self.part(scene), PieceLoads(*(design.value(f"piece_loads.{surface}.{key}") for key in ("force", "moment")))
        assert isinstance(part, SpatialPart)
        return pressed(part, loads)

    def elastic_names(self, nodes: list[int]) -> Iterator[str]:
        """Names of the elastic coordinates of a part that is not reduced.

        Its ends turn across the chord and twist against each other, and the last one moves along it.
        """
        across = [f"rotation {which} across the chord" for which in ("one", "two")]
        every = ["x", "y", "z", *(f"rotation about {axis}" for axis in "xyz")]
        yield from (f"{name} of node {nodes[0]}" for name in across)
        yield from (f"{name} of node {k}" for k in nodes[1:-1] for name in every)
        yield from (f"{name} of node {nodes[-1]}" for name in ("displacement along the chord", *across, "twist"))


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
