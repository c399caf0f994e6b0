"""What can be asked of a scene, in the plane and in space alike."""

from __future__ import annotations

from toolkit.responses.balance.mass import CentreOfMass, Mass
from toolkit.responses.balance.power import Power
from toolkit.responses.balance.work import Work
from toolkit.responses.energy import KineticEnergy, StrainEnergy
from toolkit.responses.forces.joint_force import JointForce
from toolkit.responses.kinematics.deflection import Deflection
from toolkit.responses.kinematics.point_distance import PointDistance
from toolkit.responses.kinematics.point_motion import Acceleration, AngularVelocity, Velocity
from toolkit.responses.kinematics.relative_angle import RelativeAngle
from toolkit.responses.load_margin import LoadMargin
from toolkit.responses.motion import Displacement, Rotation
from toolkit.responses.over_time.extremes import TimeKS, TimeMax, TimeMin
from toolkit.responses.over_time.means import TimeIntegral, TimeMean, TimeMeanSquare
from toolkit.responses.shape_error import ShapeMax, ShapeMSE, ShapeRMS
from toolkit.responses.stress.local_stress import StressAlongLine, StressAtPoint
from toolkit.responses.stress.stress import KSStress, MaxStress
from toolkit.responses.vibrations.least_frequency import LeastFrequency
from toolkit.responses.vibrations.vibration import DampingRatio, Frequency

__all__ = [
    "Acceleration",
    "AngularVelocity",
    "CentreOfMass",
    "DampingRatio",
    "Deflection",
    "Displacement",
    "Frequency",
    "JointForce",
    "KSStress",
    "KineticEnergy",
    "LeastFrequency",
    "LoadMargin",
    "Mass",
    "MaxStress",
    "PointDistance",
    "Power",
    "RelativeAngle",
    "Rotation",
    "ShapeMSE",
    "ShapeMax",
    "ShapeRMS",
    "StrainEnergy",
    "StressAlongLine",
    "StressAtPoint",
    "TimeIntegral",
    "TimeKS",
    "TimeMax",
    "TimeMean",
    "TimeMeanSquare",
    "TimeMin",
    "Velocity",
    "Work",
]
