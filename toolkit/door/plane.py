"""What a scene in the plane is made of: points, bodies, joints, loads, curves over time, responses."""

from __future__ import annotations

from toolkit.bodies.planar.flexible import Flexible
from toolkit.bodies.planar.rigid import Rigid, Rod
from toolkit.description.point import BodyPoint, Point
from toolkit.description.profile import Constant, Sine, SmoothStep, Sum, Table
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
    "Displacement",
    "Distance",
    "Flexible",
    "Gravity",
    "JointForce",
    "KSStress",
    "KineticEnergy",
    "MaxStress",
    "Point",
    "PointForce",
    "PositionDriver",
    "Revolute",
    "Rigid",
    "RigidJoint",
    "Rod",
    "Rotation",
    "RotationalSpringDamper",
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
