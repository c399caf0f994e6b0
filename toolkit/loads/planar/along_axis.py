"""Base of loads in the plane along an axis."""

from __future__ import annotations

from typing import Any

from toolkit.foundation.kernel import plain
from toolkit.joints.kernels.laws import angle_of
from toolkit.loads.kernels.measured import TILT
from toolkit.loads.planar.load import PlanarLoad
from toolkit.markers.component import AlongAxis


class AlongAxisLoad(AlongAxis, PlanarLoad):
    """Base of loads along an axis fixed in body b; the angle of the axis is the last parameter."""

    def with_axis(self, found: list[Any]) -> list[Any]:
        """Parameters of the law, followed by the angle of the axis."""
        x, y = self.axis
        return [*found, *[0.0] * (TILT - 6 - len(found)), plain(angle_of)(y, x)]
