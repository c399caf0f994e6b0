"""The ground in the plane."""

from __future__ import annotations

import numpy as np

from toolkit.bodies.body import Placed
from toolkit.bodies.ground import InertialFrame
from toolkit.bodies.planar.body import MarkerNumbers, PlanarBody


class Ground(InertialFrame, PlanarBody):
    """The inertial frame; it is always there, under the name `ground`."""

    kind = "ground"

    def marker(self, scene: Placed, point: str, _name: str) -> MarkerNumbers:
        """Marker at a point that is fixed to the ground."""
        return MarkerNumbers(np.append(scene.position(point), 0.0), np.zeros(0, int), np.zeros((0, 3)))
