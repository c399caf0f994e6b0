"""What joints, loads, time curves and responses of one's own are made from: bases, numbers with what they measure, and checks."""

from __future__ import annotations

from toolkit.api.check import check_curve, check_joint, check_load, check_response, check_scene
from toolkit.components.curves.catalogue import Curve
from toolkit.components.joints.joint import PlanarJoint, SpatialJoint
from toolkit.components.joints.rows import Row
from toolkit.components.loads.kernels.along import act_along, add_parameter, add_state, rate_along, scale_force
from toolkit.components.loads.kernels.measured import distance, plane_angle, plane_offset, space_angle, space_offset
from toolkit.components.loads.load import AlongAxisLoad, BetweenBodies, BetweenPoints, PlanarLoad, SpatialLoad
from toolkit.components.markers.component import AboutAxis
from toolkit.description.description import NotNegative, Number, Positive, Quantity
from toolkit.foundation.kernel import inner, kernel
from toolkit.responses.marker_formula import MarkerFormula, MarkerVector, Motion
from toolkit.responses.response import Instant, Partials, Response

__all__ = [
    "AboutAxis",
    "AlongAxisLoad",
    "BetweenBodies",
    "BetweenPoints",
    "Curve",
    "Instant",
    "MarkerFormula",
    "MarkerVector",
    "Motion",
    "NotNegative",
    "Number",
    "Partials",
    "PlanarJoint",
    "PlanarLoad",
    "Positive",
    "Quantity",
    "Response",
    "Row",
    "SpatialJoint",
    "SpatialLoad",
    "act_along",
    "add_parameter",
    "add_state",
    "check_curve",
    "check_joint",
    "check_load",
    "check_response",
    "check_scene",
    "distance",
    "inner",
    "kernel",
    "plane_angle",
    "plane_offset",
    "rate_along",
    "scale_force",
    "space_angle",
    "space_offset",
]
