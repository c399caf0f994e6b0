"""Bases of joints in the plane along an axis."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import field_validator

from toolkit.description.description import Pair
from toolkit.description.quantity import Quantity
from toolkit.joints.planar.joint import PlanarJoint, PointJoint
from toolkit.joints.poses import PlanePoses, plane_poses
from toolkit.kinematics.planar import unit_vector


class Directed(PlanarJoint):
    """Base of joints along an axis fixed in body b; the axis is given in the undeformed configuration.

    Attributes
    ----------
    axis
        Direction of the axis in the undeformed configuration, of any length.
    """

    axis: Annotated[Pair, Quantity("none")] = (1.0, 0.0)

    @field_validator("axis")
    @classmethod
    def _not_zero(cls, axis: Pair) -> Pair:
        if axis == (0.0, 0.0):
            raise ValueError("an axis needs a direction, for example [1, 0]")
        return axis

    @property
    def poses(self) -> PlanePoses:
        """The first axis along that of the joint, the second one its normal."""
        x, y = unit_vector(np.array(self.axis))
        return plane_poses(np.array([[x, -y], [y, x]]))


class AlongAxis(Directed, PointJoint):
    """Base of joints along an axis at one point."""
