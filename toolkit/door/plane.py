"""What a scene in the plane is made of: points, bodies, joints, loads, curves over time, responses."""

from __future__ import annotations

from toolkit.bodies.flexible import Flexible
from toolkit.bodies.rigid import Rigid, Rod
from toolkit.description.point import BodyPoint, Point
from toolkit.door import curves, responses
from toolkit.door.curves import *  # noqa: F403
from toolkit.door.responses import *  # noqa: F403  (one list for the plane and for space)
from toolkit.joints.both.cam import Cam, SwingCam
from toolkit.joints.both.distance import Distance
from toolkit.joints.both.driver import AngleDriver, PositionDriver
from toolkit.joints.both.gear import Gear
from toolkit.joints.both.rack import Rack, RollingDisc
from toolkit.joints.both.rigid_joint import RigidJoint
from toolkit.joints.planar.revolute import Revolute
from toolkit.joints.planar.slider import Slider
from toolkit.loads.bushing import Bushing
from toolkit.loads.controllers import AngleController, DistanceController, PositionController
from toolkit.loads.friction import PlanarSlidingFriction as SlidingFriction
from toolkit.loads.friction import PlanarTurningFriction as TurningFriction
from toolkit.loads.gravity import Gravity
from toolkit.loads.point_force import PointForce
from toolkit.loads.springs import RotationalSpringDamper, SpringDamper
from toolkit.loads.torque import Torque

__all__ = [
    *curves.__all__,
    *responses.__all__,
    "AngleController",
    "AngleDriver",
    "BodyPoint",
    "Bushing",
    "Cam",
    "Distance",
    "DistanceController",
    "Flexible",
    "Gear",
    "Gravity",
    "Point",
    "PointForce",
    "PositionController",
    "PositionDriver",
    "Rack",
    "Revolute",
    "Rigid",
    "RigidJoint",
    "Rod",
    "RollingDisc",
    "RotationalSpringDamper",
    "Slider",
    "SlidingFriction",
    "SpringDamper",
    "SwingCam",
    "Torque",
    "TurningFriction",
]
