"""What a scene in space is made of: points, bodies, joints, loads, curves over time, responses."""

from __future__ import annotations

from toolkit.bodies.flexible import SpatialFlexible as Flexible
from toolkit.bodies.rigid import SpatialRigid as Rigid
from toolkit.bodies.rigid import SpatialRod as Rod
from toolkit.description.point import BodyPoint, Point
from toolkit.door import curves, responses
from toolkit.door.curves import *  # noqa: F403
from toolkit.door.responses import *  # noqa: F403  (one list for the plane and for space)
from toolkit.joints.both.cam import SpatialCam as Cam
from toolkit.joints.both.cam import SpatialSwingCam as SwingCam
from toolkit.joints.both.distance import SpatialDistance as Distance
from toolkit.joints.both.driver import SpatialAngleDriver as AngleDriver
from toolkit.joints.both.driver import SpatialPositionDriver as PositionDriver
from toolkit.joints.both.gear import SpatialGear as Gear
from toolkit.joints.both.rack import SpatialRack as Rack
from toolkit.joints.both.rigid_joint import SpatialRigidJoint as RigidJoint
from toolkit.joints.spatial.cylindrical import Cylindrical
from toolkit.joints.spatial.point_on_plane import PointOnPlane
from toolkit.joints.spatial.prismatic import Prismatic
from toolkit.joints.spatial.revolute import SpatialRevolute as Revolute
from toolkit.joints.spatial.screw import Screw
from toolkit.joints.spatial.spherical import Spherical
from toolkit.joints.spatial.universal import Universal
from toolkit.loads.bushing import SpatialBushing as Bushing
from toolkit.loads.controllers import SpatialAngleController as AngleController
from toolkit.loads.controllers import SpatialDistanceController as DistanceController
from toolkit.loads.controllers import SpatialPositionController as PositionController
from toolkit.loads.friction import SpatialSlidingFriction as SlidingFriction
from toolkit.loads.friction import SpatialTurningFriction as TurningFriction
from toolkit.loads.gravity import SpatialGravity as Gravity
from toolkit.loads.point_force import SpatialPointForce as PointForce
from toolkit.loads.pressure import Pressure
from toolkit.loads.springs import SpatialRotationalSpringDamper as RotationalSpringDamper
from toolkit.loads.springs import SpatialSpringDamper as SpringDamper
from toolkit.loads.torque import SpatialTorque as Torque

__all__ = [
    *curves.__all__,
    *responses.__all__,
    "AngleController",
    "AngleDriver",
    "BodyPoint",
    "Bushing",
    "Cam",
    "Cylindrical",
    "Distance",
    "DistanceController",
    "Flexible",
    "Gear",
    "Gravity",
    "Point",
    "PointForce",
    "PointOnPlane",
    "PositionController",
    "PositionDriver",
    "Pressure",
    "Prismatic",
    "Rack",
    "Revolute",
    "Rigid",
    "RigidJoint",
    "Rod",
    "RotationalSpringDamper",
    "Screw",
    "Spherical",
    "SlidingFriction",
    "SpringDamper",
    "SwingCam",
    "Torque",
    "TurningFriction",
    "Universal",
]
