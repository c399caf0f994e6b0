"""What a scene in the plane is made of: points, bodies, joints and loads."""

from __future__ import annotations

from toolkit.bodies.planar.flexible import Flexible
from toolkit.bodies.planar.rigid import Rigid, Rod
from toolkit.description.point import BodyPoint, Point
from toolkit.joints.planar.distance import Distance
from toolkit.joints.planar.driver import AngleDriver, PositionDriver
from toolkit.joints.planar.revolute import Revolute
from toolkit.joints.planar.rigid_joint import RigidJoint
from toolkit.joints.planar.slider import Slider
from toolkit.loads.planar.gravity import Gravity
from toolkit.loads.planar.point_force import PointForce
from toolkit.loads.planar.spring_damper import RotationalSpringDamper, SpringDamper
from toolkit.loads.planar.torque import Torque

__all__ = [
    "AngleDriver",
    "BodyPoint",
    "Distance",
    "Flexible",
    "Gravity",
    "Point",
    "PointForce",
    "PositionDriver",
    "Revolute",
    "Rigid",
    "RigidJoint",
    "Rod",
    "RotationalSpringDamper",
    "Slider",
    "SpringDamper",
    "Torque",
]
