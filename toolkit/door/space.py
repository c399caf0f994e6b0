"""What a scene in space is made of: points, bodies, joints, loads, curves over time, responses."""

from __future__ import annotations

from toolkit.bodies.spatial.flexible import SpatialFlexible as Flexible
from toolkit.bodies.spatial.rigid import SpatialRigid as Rigid
from toolkit.bodies.spatial.rigid import SpatialRod as Rod
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
from toolkit.joints.both.distance import SpatialDistance as Distance
from toolkit.joints.both.driver import SpatialAngleDriver as AngleDriver
from toolkit.joints.both.driver import SpatialPositionDriver as PositionDriver
from toolkit.joints.both.rigid_joint import SpatialRigidJoint as RigidJoint
from toolkit.joints.spatial.cylindrical import Cylindrical
from toolkit.joints.spatial.point_on_plane import PointOnPlane
from toolkit.joints.spatial.prismatic import Prismatic
from toolkit.joints.spatial.revolute import SpatialRevolute as Revolute
from toolkit.joints.spatial.spherical import Spherical
from toolkit.joints.spatial.universal import Universal
from toolkit.loads.spatial.gravity import SpatialGravity as Gravity
from toolkit.loads.spatial.point_force import SpatialPointForce as PointForce
from toolkit.loads.spatial.pressure import Pressure
from toolkit.loads.spatial.rotational_spring_damper import SpatialRotationalSpringDamper as RotationalSpringDamper
from toolkit.loads.spatial.spring_damper import SpatialSpringDamper as SpringDamper
from toolkit.loads.spatial.torque import SpatialTorque as Torque
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
    "Cylindrical",
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
    "PointOnPlane",
    "Polynomial",
    "PositionDriver",
    "Pressure",
    "Prismatic",
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
    "SmoothStep",
    "Spherical",
    "SpringDamper",
    "StrainEnergy",
    "Sum",
    "Table",
    "TimeIntegral",
    "Torque",
    "Universal",
]
