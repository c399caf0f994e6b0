"""What joints, loads, time curves and responses of one's own are made from: bases, numbers with what they measure, and checks."""

from __future__ import annotations

from toolkit.conformance.check import check_curve, check_joint, check_load, check_response, check_scene
from toolkit.curves.catalogue import Curve
from toolkit.description.description import NotNegative, Number, Positive, Quantity
from toolkit.foundation.kernel import inner, kernel
from toolkit.joints.joint import PlanarJoint, SpatialJoint
from toolkit.joints.rows import Row
from toolkit.loads.kernels.along import act_along, add_parameter, add_state, rate_along, scale_force
from toolkit.loads.kernels.measured import distance, plane_angle, plane_offset, space_angle, space_offset
from toolkit.loads.load import AlongAxisLoad, BetweenBodies, BetweenPoints, PlanarLoad, SpatialLoad
from toolkit.markers.component import AboutAxis
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
