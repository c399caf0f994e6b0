"""Screw: a nut on a thread."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import field_validator

from toolkit.components.joints.joint import AxisJoint
from toolkit.components.joints.kernels.laws import turn_law
from toolkit.components.joints.rows import Row
from toolkit.components.markers.component import Skeleton
from toolkit.description.description import Number, Quantity


class Screw(AxisJoint):
    """A cylindrical joint whose body a moves along the axis by `pitch` for every turn that it makes about it, of any number of turns.

    s - pitch angle / (2 pi) = 0. A start or a step that is off by more than half a pitch would be in the next thread.

    Attributes
    ----------
    pitch
        Of the thread, in units of length; negative if it is left-handed.
    """

    kind = "screw"
    symbol = "sleeve"

    pitch: Annotated[Number, Quantity("length")]

    @field_validator("pitch")
    @classmethod
    def _climbs(cls, pitch: float) -> float:
        if pitch == 0:
            raise ValueError("a screw without pitch is a revolute joint; take that")
        return pitch

    def constraint(self, scene: Skeleton | None) -> tuple[Row, ...]:
        """Rows of two normal directions, two rotations, and the thread."""
        (a, b), poses, start = self.poses, self.poses, 0.0
        if scene is not None:
            start = (scene.position(self.grips[0][1]) - scene.position(self.grips[1][1])) @ self.axes[:, 2]
        offset = poses.on_axis(3, "thread", start).forms[0]
        thread = (offset, a.e(1) @ b.e(1), a.e(1) @ b.e(2), self.pitch / (2 * np.pi))
        return (*poses.on_line, *poses.aligned, Row("thread", "length", thread, turn_law))
