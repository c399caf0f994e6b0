"""The ground: no coordinates, every point fixed."""

from __future__ import annotations

import numpy as np

from toolkit.bodies.body import Body, ConstantNumbers, MarkerNumbers, Placed


class Ground(Body):
    """The inertial frame; it is always there, under the name `ground`."""

    kind = "ground"

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

    def marker(self, scene: Placed, point: str, _name: str) -> MarkerNumbers:
        """A fixed point."""
        return MarkerNumbers(np.append(scene.position(point), 0.0), np.zeros(0, int), np.zeros((0, 3)))

    def constant(self, _scene: Placed, _gravity: np.ndarray) -> ConstantNumbers:
        """Nothing."""
        empty = np.zeros(0, int)
        return ConstantNumbers(empty, empty, np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(0))
