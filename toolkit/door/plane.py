"""What a scene in the plane is made of: points, bodies, joints, loads, curves over time, responses."""

from __future__ import annotations

from toolkit.bodies.planar.flexible import Flexible
from toolkit.bodies.planar.rigid import Rigid, Rod
from toolkit.curves.kinds.constant import Constant
from toolkit.curves.kinds.cycloid import Cycloid
from toolkit.curves.kinds.harmonic import Harmonic
from toolkit.curves.kinds.polynomial import Polynomial
from toolkit.curves.kinds.product import Product
from toolkit.curves.kinds.ramp import Ramp
from toolkit.curves.kinds.sequence import Sequence
from toolkit.curves.kinds.sine import Sine
from toolkit.curves.kinds.smooth_step import SmoothStep
from toolkit.curves.kinds.sum import Sum
from toolkit.curves.kinds.table import Table
from toolkit.description.point import BodyPoint, Point
from toolkit.joints.both.distance import Distance
from toolkit.joints.both.driver import AngleDriver, PositionDriver
from toolkit.joints.both.rigid_joint import RigidJoint
from toolkit.joints.planar.revolute import Revolute
from toolkit.joints.planar.slider import Slider
from toolkit.loads.planar.gravity import Gravity
from toolkit.loads.planar.point_force import PointForce
from toolkit.loads.planar.spring_damper import RotationalSpringDamper, SpringDamper
from toolkit.loads.planar.torque import Torque
from toolkit.responses.energy import KineticEnergy, StrainEnergy
from toolkit.responses.forces.joint_force import JointForce
from toolkit.responses.instant import TimeIntegral
from toolkit.responses.motion import Displacement, Rotation
from toolkit.responses.shape_error import ShapeMax, ShapeMSE, ShapeRMS
from toolkit.responses.stress.stress import KSStress, MaxStress

__all__ = [
    "AngleDriver",
    "BodyPoint",
    "Constant",
    "Cycloid",
    "Displacement",
    "Distance",
    "Flexible",
    "Gravity",
    "Harmonic",
    "JointForce",
    "KSStress",
    "KineticEnergy",
    "MaxStress",
    "Point",
    "PointForce",
    "Polynomial",
    "PositionDriver",
    "Product",
    "Ramp",
    "Revolute",
    "Rigid",
    "RigidJoint",
    "Rod",
    "Rotation",
    "RotationalSpringDamper",
    "Sequence",
    "ShapeMSE",
    "ShapeMax",
    "ShapeRMS",
    "Sine",
    "Slider",
    "SmoothStep",
    "SpringDamper",
    "StrainEnergy",
    "Sum",
    "Table",
    "TimeIntegral",
    "Torque",
]
