"""Base of joints in the plane along an axis."""

from __future__ import annotations

import numpy as np

from toolkit.joints.planar.joint import PointJoint
from toolkit.joints.poses import PlanePoses, plane_poses
from toolkit.kinematics.planar import unit_vector
from toolkit.markers import along_axis


class AlongAxis(along_axis.AlongAxis, PointJoint):
    """Base of joints about an axis fixed in body b; the axis is given in the undeformed configuration.

    Attributes
    ----------
    axis
        Direction of the axis in the undeformed configuration, of any length.
    """

    @property
    def poses(self) -> PlanePoses:
        """The first axis along that of the joint, the second one its normal."""
        x, y = unit_vector(np.array(self.axis))
        return plane_poses(np.array([[x, -y], [y, x]]))
