"""Forces and torques at one instant, as vectors at the points that they act at."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.component import Component
from toolkit.loads.spatial.point_force import SpatialPointForce
from toolkit.loads.spatial.torque import SpatialTorque
from toolkit.render.spatial.configuration import SpatialConfiguration


class Arrow(NamedTuple):
    """A vector at a point, in the scene's units of force or torque."""

    kind: str  # "force" or "torque"
    point: np.ndarray  # (3,)
    vector: np.ndarray  # (3,)


def arrows(moment: SpatialConfiguration) -> list[Arrow]:
    """Of all loads that are forces or torques; of a torque between two bodies its reaction too."""
    found = []
    for load in moment.scene.loads.values():
        if isinstance(load, SpatialPointForce):
            found.append(Arrow("force", moment.ends(load)[0], _turned(moment, load, load.force, load.frame)))
        elif isinstance(load, SpatialTorque):
            torque = _turned(moment, load, load.torque, load.frame)
            one, other = moment.ends(load)
            found.append(Arrow("torque", one, torque))
            if load.reaction != "ground":
                found.append(Arrow("torque", other, -torque))
    return found


def _turned(moment: SpatialConfiguration, load: Component, vector: tuple, frame: str) -> np.ndarray:
    """A load's vector at the time of the moment, in the axes of space."""
    curve = load.time_curve
    scale = 1.0 if curve is None else float(np.real(curve.evaluate(np.array([moment.time]))[0, 0]))
    axes = moment.turned(*load.grips[0], np.eye(3)) if frame == "body" else np.eye(3)
    return scale * axes @ np.real(np.array(vector))
