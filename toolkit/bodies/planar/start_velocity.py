"""The velocity that a planar body with a frame may be given for the start."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import model_validator

from toolkit.bodies.planar.body import PlanarBody
from toolkit.description.description import Number
from toolkit.description.quantity import Quantity


class StartVelocity(PlanarBody):
    """Base of planar bodies whose frame moves. What is written holds at the start; what is not, the joints and least motion decide.

    Attributes
    ----------
    velocity
        v_x, v_y of the frame's origin and omega at the start, in length/time and rad/time; the origin of a rigid body is its centre of
        mass. Left out, the body starts as the joints ask, and rests if they ask for nothing.
    angular_velocity
        omega at the start alone, in rad/time, in the place of `velocity`: the joints find what belongs to it.
    """

    velocity: Annotated[tuple[Number, Number, Number] | None, Quantity("length/time", "length/time", "angle/time")] = None
    angular_velocity: Annotated[Number | None, Quantity("angle/time")] = None

    @model_validator(mode="after")
    def _one_omega(self) -> StartVelocity:
        if self.velocity is not None and self.angular_velocity is not None:
            raise ValueError("the third number of `velocity` is the angular velocity already: write one of the two")
        return self

    def written_velocities(self) -> dict[int, str]:
        """Coordinates with a written velocity -> keys of the velocity, omega first, which tells most."""
        if not self.has_frame:
            return {}
        if self.velocity is not None:
            return {2: "velocity.2", 0: "velocity.0", 1: "velocity.1"}
        return {} if self.angular_velocity is None else {2: "angular_velocity"}

    def frame_velocity(self) -> np.ndarray:
        """v_x, v_y, omega (3,), zero where nothing is written."""
        if self.velocity is not None:
            return np.array(self.velocity)
        return np.array([0.0, 0.0, 0.0 if self.angular_velocity is None else self.angular_velocity])
