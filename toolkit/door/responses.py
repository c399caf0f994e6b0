"""Responses: the numbers that a design is judged by."""

from __future__ import annotations

from toolkit.responses.energy import KineticEnergy, StrainEnergy
from toolkit.responses.forces.joint_force import JointForce
from toolkit.responses.instant import TimeIntegral
from toolkit.responses.motion import Displacement, Rotation
from toolkit.responses.shape_error import ShapeMax, ShapeMSE, ShapeRMS
from toolkit.responses.stress.stress import KSStress, MaxStress

__all__ = [
    "Displacement",
    "JointForce",
    "KSStress",
    "KineticEnergy",
    "MaxStress",
    "Rotation",
    "ShapeMSE",
    "ShapeMax",
    "ShapeRMS",
    "StrainEnergy",
    "TimeIntegral",
]
