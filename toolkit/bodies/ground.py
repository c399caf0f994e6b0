"""The ground: no coordinates, every point fixed."""

from __future__ import annotations

import numpy as np

from toolkit.bodies.body import Body, ConstantNumbers, Placed, no_constants


class InertialFrame(Body):
    """Base of the ground in the plane and in space, which has no coordinates."""

    @property
    def has_frame(self) -> bool:
        """No frame coordinates."""
        return False

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

    def whole_mass(self, _scene: Placed) -> float:
        """None."""
        return 0.0

    def constant(self, _scene: Placed, _gravity: np.ndarray) -> ConstantNumbers:
        """Nothing."""
        return no_constants(0)
