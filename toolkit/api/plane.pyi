# Written by schemas/write_schemas.py.
# ruff: noqa
# fmt: off

from toolkit.responses.point_motion import Acceleration as Acceleration
from toolkit.components.loads.controllers import AngleController as AngleController
from toolkit.components.joints.driver import AngleDriver as AngleDriver
from toolkit.responses.point_motion import AngularVelocity as AngularVelocity
from toolkit.description.design import BodyPoint as BodyPoint
from toolkit.components.loads.bushing import Bushing as Bushing
from toolkit.components.joints.cam import Cam as Cam
from toolkit.responses.balance import CentreOfMass as CentreOfMass
from toolkit.components.curves.polynomial import Constant as Constant
from toolkit.components.curves.rise import Cycloid as Cycloid
from toolkit.responses.vibration import DampingRatio as DampingRatio
from toolkit.responses.point_motion import Deflection as Deflection
from toolkit.responses.motion import Displacement as Displacement
from toolkit.components.joints.distance import Distance as Distance
from toolkit.components.loads.controllers import DistanceController as DistanceController
from toolkit.components.bodies.flexible import Flexible as Flexible
from toolkit.responses.vibration import Frequency as Frequency
from toolkit.components.joints.gear import Gear as Gear
from toolkit.components.loads.gravity import Gravity as Gravity
from toolkit.components.curves.oscillation import Harmonic as Harmonic
from toolkit.responses.joint_force import JointForce as JointForce
from toolkit.responses.stress import KSStress as KSStress
from toolkit.responses.energy import KineticEnergy as KineticEnergy
from toolkit.responses.least_frequency import LeastFrequency as LeastFrequency
from toolkit.responses.least_frequency import LoadMargin as LoadMargin
from toolkit.responses.balance import Mass as Mass
from toolkit.responses.stress import MaxStress as MaxStress
from toolkit.description.design import Point as Point
from toolkit.responses.point_motion import PointDistance as PointDistance
from toolkit.components.loads.point_force import PointForce as PointForce
from toolkit.components.curves.polynomial import Polynomial as Polynomial
from toolkit.components.loads.controllers import PositionController as PositionController
from toolkit.components.joints.driver import PositionDriver as PositionDriver
from toolkit.responses.balance import Power as Power
from toolkit.components.curves.combined import Product as Product
from toolkit.components.joints.rack import Rack as Rack
from toolkit.components.curves.rise import Ramp as Ramp
from toolkit.responses.relative_angle import RelativeAngle as RelativeAngle
from toolkit.components.joints.revolute import Revolute as Revolute
from toolkit.components.bodies.rigid import Rigid as Rigid
from toolkit.components.joints.rigid_joint import RigidJoint as RigidJoint
from toolkit.components.bodies.rigid import Rod as Rod
from toolkit.components.joints.rack import RollingDisc as RollingDisc
from toolkit.responses.motion import Rotation as Rotation
from toolkit.components.loads.springs import RotationalSpringDamper as RotationalSpringDamper
from toolkit.components.curves.combined import Sequence as Sequence
from toolkit.responses.shape_error import ShapeMSE as ShapeMSE
from toolkit.responses.shape_error import ShapeMax as ShapeMax
from toolkit.responses.shape_error import ShapeRMS as ShapeRMS
from toolkit.components.curves.oscillation import Sine as Sine
from toolkit.components.joints.slider import Slider as Slider
from toolkit.components.loads.friction import PlanarSlidingFriction as SlidingFriction
from toolkit.components.curves.rise import SmoothStep as SmoothStep
from toolkit.components.loads.springs import SpringDamper as SpringDamper
from toolkit.responses.energy import StrainEnergy as StrainEnergy
from toolkit.responses.local_stress import StressAlongLine as StressAlongLine
from toolkit.responses.local_stress import StressAtPoint as StressAtPoint
from toolkit.components.curves.combined import Sum as Sum
from toolkit.components.joints.cam import SwingCam as SwingCam
from toolkit.components.curves.table import Table as Table
from toolkit.responses.over_time import TimeIntegral as TimeIntegral
from toolkit.responses.extremes import TimeKS as TimeKS
from toolkit.responses.extremes import TimeMax as TimeMax
from toolkit.responses.over_time import TimeMean as TimeMean
from toolkit.responses.over_time import TimeMeanSquare as TimeMeanSquare
from toolkit.responses.extremes import TimeMin as TimeMin
from toolkit.components.loads.torque import Torque as Torque
from toolkit.components.loads.friction import PlanarTurningFriction as TurningFriction
from toolkit.responses.point_motion import Velocity as Velocity
from toolkit.responses.balance import Work as Work

__all__ = [
    "Acceleration",
    "AngleController",
    "AngleDriver",
    "AngularVelocity",
    "BodyPoint",
    "Bushing",
    "Cam",
    "CentreOfMass",
    "Constant",
    "Cycloid",
    "DampingRatio",
    "Deflection",
    "Displacement",
    "Distance",
    "DistanceController",
    "Flexible",
    "Frequency",
    "Gear",
    "Gravity",
    "Harmonic",
    "JointForce",
    "KSStress",
    "KineticEnergy",
    "LeastFrequency",
    "LoadMargin",
    "Mass",
    "MaxStress",
    "Point",
    "PointDistance",
    "PointForce",
    "Polynomial",
    "PositionController",
    "PositionDriver",
    "Power",
    "Product",
    "Rack",
    "Ramp",
    "RelativeAngle",
    "Revolute",
    "Rigid",
    "RigidJoint",
    "Rod",
    "RollingDisc",
    "Rotation",
    "RotationalSpringDamper",
    "Sequence",
    "ShapeMSE",
    "ShapeMax",
    "ShapeRMS",
    "Sine",
    "Slider",
    "SlidingFriction",
    "SmoothStep",
    "SpringDamper",
    "StrainEnergy",
    "StressAlongLine",
    "StressAtPoint",
    "Sum",
    "SwingCam",
    "Table",
    "TimeIntegral",
    "TimeKS",
    "TimeMax",
    "TimeMean",
    "TimeMeanSquare",
    "TimeMin",
    "Torque",
    "TurningFriction",
    "Velocity",
    "Work",
]

def parts_of_scenes(dimension: int) -> dict[str, type]: ...
