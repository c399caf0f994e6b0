"""The motion of a body's frame in the numbers that a scene writes: velocity of its origin and angular velocity."""

from __future__ import annotations

import numpy as np

from toolkit.bodies.body import Body
from toolkit.bodies.spatial.body import SpatialBody
from toolkit.kinematics.spatial import angular_velocity, matrix_of

QUATERNION = 4
"""Coordinates of an orientation in space."""


def frame_motion(body: Body, q: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
    """Key of the body's table -> numbers, as far as its frame moves; from the body's coordinates q and velocities v at the start.

    "velocity" (d,) of the frame's origin, "angular_velocity" in rad/time, (1,) in the plane, in space (3,) in the axes of space.
    """
    if not body.has_frame:
        return {}
    if not isinstance(body, SpatialBody):
        return {"velocity": v[:2], "angular_velocity": v[2:3]}
    found, turns = {}, v[body.moves : body.frame_size]
    if body.moves:
        found["velocity"] = v[: body.moves]
    if body.turns == QUATERNION:
        orientation = q[body.moves : body.frame_size]
        found["angular_velocity"] = matrix_of(orientation) @ angular_velocity(orientation, turns)
    elif body.turns:
        found["angular_velocity"] = turns[0] * body.unit_axis
    return found
