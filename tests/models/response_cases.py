"""One list of all responses, on a small scene in the plane and one in space; a new response is one new line in each."""

from __future__ import annotations

from pathlib import Path

from tests.models import cases, spatial_cases
from tests.models.every_number import LEAD, SOLVER
from toolkit.components.bodies.flexible import Flexible, SpatialFlexible
from toolkit.components.bodies.rigid import Rod, SpatialRod
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.driver import AngleDriver, SpatialAngleDriver
from toolkit.components.joints.revolute import Revolute, SpatialRevolute
from toolkit.components.loads.gravity import Gravity, SpatialGravity
from toolkit.components.loads.springs import (
    RotationalSpringDamper,
    SpatialRotationalSpringDamper,
    SpatialSpringDamper,
    SpringDamper,
)
from toolkit.components.loads.torque import SpatialTorque, Torque
from toolkit.description.design import BodyPoint, Point
from toolkit.responses.balance import CentreOfMass, Mass, Power, Work
from toolkit.responses.energy import KineticEnergy, StrainEnergy
from toolkit.responses.extremes import TimeKS, TimeMax, TimeMin
from toolkit.responses.joint_force import JointForce
from toolkit.responses.local_stress import StressAlongLine, StressAtPoint
from toolkit.responses.motion import Displacement, Rotation
from toolkit.responses.over_time import TimeIntegral, TimeMean, TimeMeanSquare
from toolkit.responses.point_motion import Acceleration, AngularVelocity, Deflection, PointDistance, Velocity
from toolkit.responses.relative_angle import RelativeAngle
from toolkit.responses.response import Response
from toolkit.responses.stress import KSStress, MaxStress
from toolkit.responses.vibration import DampingRatio, Frequency
from toolkit.scene.scene import Scene

AXIS = (0.3, -0.5, 1.0)


def plane(folder: Path) -> Scene:
    """A driven crank with a beam hinged to it, which a torque and a damped spring act on."""
    return Scene(
        units="m-kg-s",
        directory=folder,
        points={
            "O": Point(x=0.1, y=0.2),
            "A": Point(x=1.0, y=0.3),
            "S": BodyPoint(body="strip", interface="middle"),
            "T": BodyPoint(body="strip", interface="end"),
        },
        bodies={
            "crank": Rod(between=("O", "A"), area=0.8, density=1.2),
            "strip": Flexible(model="beam.h5", position=(0.162, 0.503), angle=-0.6, angular_velocity=0.2),
        },
        joints={
            "hinge": Revolute(bodies=("crank", "ground"), point="O"),
            "lead": AngleDriver(bodies=("crank", "ground"), point="O", curve=LEAD),
            "pin": Revolute(bodies=("strip", "crank"), point=("S", "A")),
        },
        loads={
            "weight": Gravity(acceleration=(0.04, -0.13)),
            "motor": Torque(body="strip", reaction="crank", point=("T", "A"), torque=0.7, curve=SmoothStep(duration=0.4)),
            "spring": SpringDamper(bodies=("strip", "ground"), points=("T", "O"), stiffness=2.1, damping=0.6, length=0.7),
            "coil": RotationalSpringDamper(
                bodies=("strip", "crank"), point=("S", "A"), stiffness=5.0, damping=0.3, rest_angle=0.1
            ),
        },
        solver=SOLVER,
    )


def space(folder: Path) -> Scene:
    """The same in space, with a frame of beams."""
    return Scene(
        units="m-kg-s",
        dimension=3,
        directory=folder,
        points={
            "O": Point(x=0.1, y=0.2, z=-0.1),
            "A": Point(x=1.0, y=0.3, z=0.2),
            "S": BodyPoint(body="strip", interface="middle"),
            "T": BodyPoint(body="strip", interface="end"),
        },
        bodies={
            "crank": SpatialRod(between=("O", "A"), area=0.8, density=1.2),
            "strip": SpatialFlexible(
                model="frame.h5",
                position=(0.542, -0.234, -0.0135),
                orientation=(0.3, -0.5, 0.7),
                angular_velocity=(0.1, -0.2, 0.3),
            ),
        },
        joints={
            "hinge": SpatialRevolute(bodies=("crank", "ground"), point="O", axis=AXIS),
            "lead": SpatialAngleDriver(bodies=("crank", "ground"), point="O", axis=AXIS, curve=LEAD),
            "pin": SpatialRevolute(bodies=("strip", "crank"), point=("S", "A"), axis=AXIS),
        },
        loads={
            "weight": SpatialGravity(acceleration=(0.04, -0.13, 0.07)),
            "motor": SpatialTorque(
                body="strip", reaction="crank", point=("T", "A"), torque=(0.7, 0.1, -0.3), curve=SmoothStep(duration=0.4)
            ),
            "spring": SpatialSpringDamper(bodies=("strip", "ground"), points=("T", "O"), stiffness=2.1, damping=0.6, length=0.7),
            "coil": SpatialRotationalSpringDamper(
                bodies=("strip", "crank"), point=("S", "A"), axis=AXIS, stiffness=5.0, damping=0.3, rest_angle=0.1
            ),
        },
        solver=SOLVER,
    )


TIP = {"body": "strip", "point": "T"}
BOTH = {"bodies": ("strip", "crank"), "points": ("T", "O")}

PLANE: dict[str, Response] = {
    "displacement": Displacement(**TIP, component="x"),
    "rotation": Rotation(**TIP),
    "force": JointForce(joint="pin", component="magnitude"),
    "velocity": Velocity(**TIP, component="y"),
    "speed": Velocity(**TIP, time=0.02),
    "acceleration": Acceleration(**TIP, component="x"),
    "size of acceleration": Acceleration(**TIP),
    "angular velocity": AngularVelocity(**TIP),
    "distance": PointDistance(**BOTH),
    "way": PointDistance(bodies=("ground", "strip"), points=("O", "T"), component="y"),
    "angle": RelativeAngle(bodies=("strip", "crank"), point=("T", "A")),
    "deflection": Deflection(**TIP),
    "deflection along": Deflection(**TIP, component="y"),
    "kinetic energy": KineticEnergy(),
    "kinetic energy of one": KineticEnergy(body="strip"),
    "strain energy": StrainEnergy(body="strip"),
    "mass": Mass(),
    "mass of one": Mass(bodies=("crank",)),
    "centre of mass": CentreOfMass(component="x"),
    "centre of one": CentreOfMass(bodies=("strip",), component="magnitude"),
    "power of a torque": Power(load="motor"),
    "power of a spring": Power(load="spring"),
    "power of gravity": Power(load="weight"),
    "power of a driver": Power(joint="lead"),
    "work": Work(load="spring"),
    "work of a driver": Work(joint="lead"),
    "stress": KSStress(body="strip", aggregation=2.0),
    "peak": MaxStress(body="strip"),
    "stress at a point": StressAtPoint(body="strip", place=(1.0, 0.5), fibre="inner"),
    "stress along a line": StressAlongLine(body="strip", places=((0.0, 0.0), (0.6, 0.1))),
    "mean stress along a line": StressAlongLine(body="strip", places=((0.6, 0.1), (1.0, 0.5)), fibre="outer", take="mean"),
    "smooth stress along a line": StressAlongLine(body="strip", places=((0.6, 0.1), (1.0, 0.5)), take="ks", aggregation=3.0),
    "frequency": Frequency(),
    "second frequency": Frequency(number=2),
    "damping": DampingRatio(),
    "integral": TimeIntegral(of=Displacement(**TIP, component="x")),
    "mean": TimeMean(of=RelativeAngle(bodies=("strip", "ground"), point=("T", "O"))),
    "mean square": TimeMeanSquare(of=Acceleration(**TIP, component="x")),
    "largest": TimeMax(of=Velocity(**TIP), measure="absolute"),
    "smallest": TimeMin(of=StrainEnergy()),
    "smooth": TimeKS(of=Power(joint="lead"), aggregation=3.0, reference=2.0, measure="absolute"),
}
SPACE: dict[str, Response] = {
    **PLANE,
    "rotation": Rotation(**TIP, axis=AXIS),
    "velocity": Velocity(**TIP, component="z"),
    "angular velocity": AngularVelocity(**TIP, component="y"),
    "size of angular velocity": AngularVelocity(**TIP, component="magnitude"),
    "angle": RelativeAngle(bodies=("strip", "crank"), point=("T", "A"), axis=AXIS),
    "stress at a point": StressAtPoint(body="strip", place=(0.7, 0.1, -0.2), fibre="inner"),
    "stress along a line": StressAlongLine(body="strip", places=((0.0, 0.0, 0.0), (0.7, 0.1, -0.2))),
    "mean stress along a line": StressAlongLine(
        body="strip", places=((0.7, 0.1, -0.2), (0.8, 0.9, 0.3)), fibre="outer", take="mean"
    ),
    "smooth stress along a line": StressAlongLine(
        body="strip", places=((0.7, 0.1, -0.2), (0.8, 0.9, 0.3)), take="ks", aggregation=3.0
    ),
    "mean": TimeMean(of=RelativeAngle(bodies=("strip", "ground"), point=("T", "O"), axis=AXIS)),
}
CASES = {"plane": (plane, PLANE), "space": (space, SPACE)}
"""Scene and the responses that are asked of it."""


def write_models(folder: Path) -> None:
    """The flexible bodies of both scenes."""
    cases.write_models(folder)
    spatial_cases.write_models(folder)
