"""Forces and torques at one instant, as vectors at the points that they act at."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.bodies.flexible import SpatialFlexible
from toolkit.curves.curve import Curve
from toolkit.loads.point_force import SpatialPointForce
from toolkit.loads.pressure import Pressure
from toolkit.loads.torque import SpatialTorque
from toolkit.markers.component import Component
from toolkit.render.space.configuration import SpatialConfiguration

_CLOSED = 1e-12
"""Square of a pressure's resultant that is round-off, relative to that of its moments over the model size."""


class Arrow(NamedTuple):
    """Vector at a point, in the scene's units of force or torque."""

    kind: str  # "force" or "torque"
    point: np.ndarray  # (3,)
    vector: np.ndarray  # (3,)


def arrows(moment: SpatialConfiguration) -> list[Arrow]:
    """Arrows of all loads that are forces or torques, the reaction of a torque and the resultant of a pressure included."""
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
        elif isinstance(load, Pressure):
            found += _resultant(moment, load)
    return found


def _resultant(moment: SpatialConfiguration, load: Pressure) -> list[Arrow]:
    """Resultant force of a pressure; on a cut body the sum over its parts, at their weighted mean point."""
    found = [
        arrow
        for piece in moment.scene.pieces([load.body])
        for arrow in _on_piece(moment, load.model_copy(update={"body": piece}))
    ]
    if len(found) < 2:
        return found
    weights = [float(np.linalg.norm(each.vector)) for each in found]
    point = np.average([each.point for each in found], axis=0, weights=weights) if any(weights) else found[0].point
    return [Arrow("force", point, np.sum([each.vector for each in found], axis=0))]


def _on_piece(moment: SpatialConfiguration, load: Pressure) -> list[Arrow]:
    """Force f of a pressure on a flat surface, at c_b = f_a L[a, b] [1; q_f] / (f . f); empty if closed."""
    body = moment.spatial_body(load.body)
    assert isinstance(body, SpatialFlexible)
    numbers = load.numbers_on(moment.scene, body)
    f, shares = np.real(numbers.force), np.real(numbers.moment).reshape(-1, 3, 3)
    if f @ f <= _CLOSED * np.abs(shares[0]).max() ** 2 / moment.scene.size**2:
        return []
    centre = np.einsum("a,jab,j->b", f, shares, np.append(1.0, moment.elastic(load.body))) / (f @ f)
    local = centre if body.frame == "moving" else body.placement.T @ centre
    return [
        Arrow("force", moment.place(load.body, local[None])[0], _factor(load.curve, moment.time) * moment.rotation(load.body) @ f)
    ]


def _turned(moment: SpatialConfiguration, load: Component, vector: tuple, frame: str) -> np.ndarray:
    """Vector of a load at the time of the moment, in global axes."""
    axes = moment.turned(*load.grips[0], np.eye(3)) if frame == "body" else np.eye(3)
    return _factor(load.time_curve, moment.time) * axes @ np.real(np.array(vector))


def _factor(curve: Curve | None, time: float) -> float:
    return 1.0 if curve is None else float(np.real(curve.evaluate(np.array([time]))[0, 0]))
