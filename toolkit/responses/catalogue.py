"""All built-in responses; importing this file makes them known to scene files."""

from toolkit.responses.energy import KineticEnergy, StrainEnergy
from toolkit.responses.instant import TimeIntegral
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Displacement, Rotation
from toolkit.responses.response import Response
from toolkit.responses.shape_error import ShapeMax, ShapeMSE, ShapeRMS
from toolkit.responses.stress import KSStress, MaxStress

__all__ = [
    "Displacement",
    "JointForce",
    "KSStress",
    "KineticEnergy",
    "MaxStress",
    "Response",
    "Rotation",
    "ShapeMSE",
    "ShapeMax",
    "ShapeRMS",
    "StrainEnergy",
    "TimeIntegral",
]
