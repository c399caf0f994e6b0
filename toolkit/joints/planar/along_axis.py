"""Bases of joints in the plane along an axis."""

from __future__ import annotations

import numpy as np

from toolkit.joints.planar.joint import PlanarJoint, PointJoint
from toolkit.joints.poses import PlanePoses, plane_poses
from toolkit.kinematics.planar import unit_vector
from toolkit.markers import along_axis


class Directed(along_axis.AlongAxis, PlanarJoint):
    """Base of joints along an axis fixed in body b; the axis is given in the undeformed configuration.

    Attributes
    ----------
    axis
        Direction of the axis in the undeformed configuration, of any length.
    """

    @property
    def poses(self) -> PlanePoses:
        """Poses of the two markers, with the first axis along that of the joint and the second one its normal."""
        x, y = unit_vector(np.array(self.axis))
        return plane_poses(np.array([[x, -y], [y, x]]))


class AlongAxis(Directed, PointJoint):
    """Base of joints along an axis at one point."""
