"""What joints, loads and responses of one's own are made from, and the checks of their derivatives."""

from __future__ import annotations

from toolkit.conformance.check import check_joint, check_load, check_scene
from toolkit.foundation.kernel import inner, kernel
from toolkit.joints.planar.joint import PlanarJoint
from toolkit.joints.spatial.joint import SpatialJoint
from toolkit.loads.planar.load import PlanarLoad
from toolkit.loads.spatial.load import SpatialLoad
from toolkit.responses.instant import Instant
from toolkit.responses.response import Partials, Response

__all__ = [
    "Instant",
    "Partials",
    "PlanarJoint",
    "PlanarLoad",
    "Response",
    "SpatialJoint",
    "SpatialLoad",
    "check_joint",
    "check_load",
    "check_scene",
    "inner",
    "kernel",
]
