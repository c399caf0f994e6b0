"""The ground in space: no coordinates, every point fixed."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from toolkit.bodies.body import Placed
from toolkit.bodies.ground import InertialFrame
from toolkit.bodies.spatial.body import SpatialBody, SpatialMarkerNumbers, pose_of


class SpatialGround(InertialFrame, SpatialBody):
    """The inertial frame; it is always there, under the name `ground`."""

    kind = "ground"

    frame: Literal["grounded"] = "grounded"

    def marker(self, scene: Placed, point: str, _name: str, axes: np.ndarray | None = None) -> Any:
        """Marker at a point that is fixed to the ground."""
        pose = pose_of(scene.position(point), np.eye(3) if axes is None else axes)
        return SpatialMarkerNumbers(pose, np.zeros(0, int), np.zeros((0, 6)))
