"""One part of a cut body in the plane."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from toolkit.bodies.cut.framed_part import FramedPart
from toolkit.bodies.planar.flexible import Flexible
from toolkit.reduced_model.cut.part import Part
from toolkit.reduced_model.cut.planar_part import planar_part


class PlanarFramedPart(FramedPart, Flexible):
    """Its frame has two coordinates and an angle."""

    kind = ""
    per_node: ClassVar[int] = 3
    frame_coordinates: ClassVar[int] = 3

    @staticmethod
    def assembled(elements: Any, first: int, last: int, stress_elements: np.ndarray) -> Part:
        """As `planar_part`."""
        return planar_part(elements, first, last, stress_elements)

    def elastic_names(self) -> Iterator[str]:
        """The first node turns, and the last moves along the chord."""
        yield f"rotation of node {self.first}"
        yield from (f"{axis} of node {k}" for k in range(self.first + 1, self.last) for axis in ("x", "y", "rotation"))
        yield from (f"{axis} of node {self.last}" for axis in ("displacement along the chord", "rotation"))
