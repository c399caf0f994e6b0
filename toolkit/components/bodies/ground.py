"""The ground: no coordinates, every point fixed."""

from __future__ import annotations

from typing import Literal

import numpy as np

from toolkit.components.bodies.body import (
    Body,
    ConstantNumbers,
    MarkerNumbers,
    Placed,
    PlanarBody,
    SpatialBody,
    SpatialMarkerNumbers,
    no_constants,
    pose_of,
)


class InertialFrame(Body):
    """Base of the ground in the plane and in space, which has no coordinates."""

    @property
    def has_frame(self) -> bool:
        """Whether the ground has frame coordinates: never."""
        return False

    def coordinate_names(self, _scene: Placed) -> list[str]:
        """No names, since the ground has no coordinates."""
        return []

    def initial_state(self, _scene: Placed) -> tuple[np.ndarray, np.ndarray]:
        """Empty coordinates and velocities, since the ground has no coordinates."""
        return np.zeros(0), np.zeros(0)

    def coordinate_lengths(self, _scene: Placed) -> np.ndarray:
        """No lengths, since the ground has no coordinates."""
        return np.zeros(0)

    def radius_of_gyration(self, _scene: Placed) -> float:
        """Zero, since the ground has neither mass nor size."""
        return 0.0

    def whole_mass(self, _scene: Placed) -> float:
        """Zero, since the ground has no mass."""
        return 0.0

    def constant(self, _scene: Placed, _gravity: np.ndarray) -> ConstantNumbers:
        """No constant terms, since the ground has no coordinates."""
        return no_constants(0)


class Ground(InertialFrame, PlanarBody):
    """The inertial frame; it is always there, under the name `ground`."""

    kind = "ground"

    def marker(self, scene: Placed, point: str, _name: str) -> MarkerNumbers:
        """Marker at a point that is fixed to the ground."""
        return MarkerNumbers(np.append(scene.position(point), 0.0), np.zeros(0, int), np.zeros((0, 3)))


class SpatialGround(InertialFrame, SpatialBody):
    """The inertial frame; it is always there, under the name `ground`."""

    kind = "ground"

    frame: Literal["grounded"] = "grounded"

    def marker(self, scene: Placed, point: str, _name: str, axes: np.ndarray | None = None) -> SpatialMarkerNumbers:
        """Marker at a point that is fixed to the ground."""
        pose = pose_of(scene.position(point), np.eye(3) if axes is None else axes)
        return SpatialMarkerNumbers(pose, np.zeros(0, int), np.zeros((0, 6)))
