"""The ground in space: no coordinates, every point fixed."""

from __future__ import annotations

from typing import Literal

import numpy as np

from toolkit.bodies.body import ConstantNumbers, Placed
from toolkit.bodies.spatial.body import SpatialBody, SpatialMarkerNumbers, no_constants, pose_of


class SpatialGround(SpatialBody):
    """The inertial frame; it is always there, under the name `ground`."""

    kind = "ground"

    frame: Literal["grounded"] = "grounded"

    def coordinate_names(self, _scene: Placed) -> list[str]:
        """None."""
        return []

    def initial_state(self, _scene: Placed) -> tuple[np.ndarray, np.ndarray]:
        """Empty."""
        return np.zeros(0), np.zeros(0)

    def coordinate_lengths(self, _scene: Placed) -> np.ndarray:
        """Empty."""
        return np.zeros(0)

    def radius_of_gyration(self, _scene: Placed) -> float:
        """No mass, no size."""
        return 0.0

    def marker(self, scene: Placed, point: str, _name: str, axes: np.ndarray | None = None) -> SpatialMarkerNumbers:
        """A fixed point."""
        pose = pose_of(scene.position(point), np.eye(3) if axes is None else axes)
        return SpatialMarkerNumbers(pose, np.zeros(0, int), np.zeros((0, 6)))

    def constant(self, _scene: Placed, _gravity: np.ndarray) -> ConstantNumbers:
        """Nothing."""
        return no_constants(0)
