"""Velocity and acceleration of a point, angular velocity of a body."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Literal

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.responses.kinematics.marker_formula import MarkerFormula, MarkerVector, place_of
from toolkit.responses.kinematics.marker_motion import Motion
from toolkit.responses.kinematics.rates import OfRates
from toolkit.responses.one_point import OnePoint


class PointVector(OfRates, OnePoint, MarkerVector):
    """Base of vectors of one point of a body in global axes, of which a kind names the part of the point's motion."""

    part: ClassVar[Literal["rate", "acceleration"]]

    def formula(self, *motions: Motion) -> tuple[np.ndarray, Sequence[Motion]]:
        """Translational components of the chosen part of the motion, and their derivatives; rotations or axes follow them."""
        values = getattr(motions[0], self.part)
        d = dimension_of(values)
        return values[:d], [Motion(**{self.part: np.eye(d, len(values))})]


class Velocity(PointVector):
    """Velocity of a point of a body in global axes: one component, or its magnitude."""

    kind = "velocity"
    quantity = "velocity"
    part = "rate"


class Acceleration(PointVector):
    """Acceleration of a point of a body in global axes: one component, or its magnitude; gravity is not part of it. That of the scheme
    `paper` lags behind by a part of a step, so that it is of first order.
    """

    kind = "acceleration"
    quantity = "acceleration"
    part = "acceleration"


class AngularVelocity(OfRates, OnePoint, MarkerFormula):
    """Angular velocity of a body at a point: in the plane its rate of rotation, in space a component in global axes or its magnitude.

    In space it is omega = 1/2 sum_i e_i x e_i' with the body's axes e_i. Where a body deforms, its points turn differently.

    Attributes
    ----------
    component
        In space: one component, or the magnitude.
    """

    kind = "angular-velocity"
    quantity = "angular_velocity"

    component: Literal["x", "y", "z", "magnitude"] | None = None

    def check(self, scene: Any) -> None:
        """Refuse a component in the plane, and its absence in space.

        Raises
        ------
        InputError
            It is missing there, or given in the plane.
        """
        super().check(scene)
        if scene.space.rotations_add != (self.component is None):
            raise InputError(
                'an angular velocity in space needs a `component`: "x", "y", "z" or "magnitude"; one in the plane has none.'
            )

    @property
    def chosen(self) -> int | None:
        """Number of the component in space, None for the magnitude; the only value in the plane."""
        return 0 if self.component is None else place_of(self.component)

    def formula(self, *motions: Motion) -> tuple[np.ndarray, Sequence[Motion]]:
        """Angular velocity from the body's axes and their rates, and its derivatives by both."""
        y, rate = motions[0].y, motions[0].rate
        if dimension_of(y) == 2:
            return rate[2:], [Motion(rate=np.eye(3)[2:])]
        omega = sum((np.cross(y[k : k + 3], rate[k : k + 3]) for k in (3, 6, 9)), np.zeros(3)) / 2
        by_y, by_rate = (np.zeros((3, 12), y.dtype) for _ in range(2))
        for k in (3, 6, 9):
            by_y[:, k : k + 3], by_rate[:, k : k + 3] = -skew(rate[k : k + 3]) / 2, skew(y[k : k + 3]) / 2
        return omega, [Motion(y=by_y, rate=by_rate)]


def dimension_of(pose: np.ndarray) -> int:
    """Dimension of space, 2 or 3, from the length of a pose."""
    return 2 if len(pose) == 3 else 3


def skew(vector: np.ndarray) -> np.ndarray:
    """Matrix (3, 3) of the cross product with a vector from the left."""
    x, y, z = vector
    zero = 0 * x
    return np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]])
