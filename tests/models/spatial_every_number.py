"""Scenes in space that contain, together, every kind of body, frame, joint, load and time curve there."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.models.every_number import FOLLOW, LEAD, SOLVER, WAVE
from toolkit.components.bodies.flexible import SpatialFlexible
from toolkit.components.bodies.rigid import SpatialRigid, SpatialRod
from toolkit.components.curves.oscillation import Sine
from toolkit.components.curves.polynomial import Constant
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.cam import SpatialCam, SpatialSwingCam
from toolkit.components.joints.cylindrical import Cylindrical
from toolkit.components.joints.distance import SpatialDistance
from toolkit.components.joints.driver import SpatialAngleDriver, SpatialPositionDriver
from toolkit.components.joints.gear import SpatialGear
from toolkit.components.joints.point_on_plane import PointOnPlane
from toolkit.components.joints.prismatic import Prismatic
from toolkit.components.joints.rack import SpatialRack
from toolkit.components.joints.revolute import SpatialRevolute
from toolkit.components.joints.rigid_joint import SpatialRigidJoint
from toolkit.components.joints.screw import Screw
from toolkit.components.joints.spherical import Spherical
from toolkit.components.joints.universal import Universal
from toolkit.components.loads.bushing import SpatialBushing
from toolkit.components.loads.controllers import SpatialAngleController, SpatialDistanceController, SpatialPositionController
from toolkit.components.loads.friction import SpatialSlidingFriction, SpatialTurningFriction
from toolkit.components.loads.gravity import SpatialGravity
from toolkit.components.loads.point_force import SpatialPointForce
from toolkit.components.loads.pressure import Pressure
from toolkit.components.loads.springs import SpatialRotationalSpringDamper, SpatialSpringDamper
from toolkit.components.loads.torque import SpatialTorque
from toolkit.description.design import BodyPoint, Point
from toolkit.responses.energy import KineticEnergy, StrainEnergy
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Displacement, Rotation
from toolkit.responses.over_time import TimeIntegral
from toolkit.responses.stress import KSStress
from toolkit.scene.scene import Scene

POINTS = {
    "O": (0.1, 0.2, -0.1),
    "A": (1.0, 0.3, 0.2),
    "B": (2.0, 1.1, -0.3),
    "C": (1.6, -0.4, 0.4),
    "D": (2.9, 0.4, 0.6),
    "E": (3.3, -0.6, -0.2),
    "F": (0.4, -0.9, 0.7),
}
TENSOR = (0.6, 0.9, 0.7, 0.1, -0.2, 0.15)
SPIN, SPEED = (0.1, -0.2, 0.3), (-0.2, 0.1, 0.4)


def points(names: str) -> dict[str, Any]:
    """Points by their letters."""
    return {name: Point(**dict(zip("xyz", POINTS[name], strict=True))) for name in names}


def linkage(_folder: Path) -> Scene:
    """A driven crank with a link that a distance ties to a block on a guide, and a driven car that carries a universal joint."""
    energy = KineticEnergy()
    return Scene(
        units="m-kg-s",
        dimension=3,
        points=points("OABCDE"),
        bodies={
            "crank": SpatialRod(between=("O", "A"), area=0.8, density=1.2),
            "link": SpatialRod(between=("A", "B"), area=0.6, density=0.9, angular_velocity=SPIN),
            "block": SpatialRigid(mass=1.4, inertia=TENSOR, center="C"),
            "car": SpatialRigid(mass=0.7, inertia=(0.3, 0.4, 0.5), center="D", frame="translating"),
            "tray": SpatialRigid(mass=0.5, inertia=TENSOR, center="E", origin="D"),
            "dart": SpatialRod(between=("B", "E"), area=0.7, density=1.1, velocity=SPEED),
        },
        joints={
            "hinge": SpatialRevolute(bodies=("crank", "ground"), point="O", axis=(0.3, -0.5, 1.0)),
            "lead": SpatialAngleDriver(bodies=("crank", "ground"), point="O", axis=(0.3, -0.5, 1.0), curve=LEAD),
            "ball": Spherical(bodies=("crank", "link"), point="A"),
            "bar": SpatialDistance(bodies=("link", "block"), points=("B", "C"), length=1.7),
            "guide": Cylindrical(bodies=("block", "ground"), point="C", axis=(0.8, -0.5, 0.4)),
            "plane": PointOnPlane(bodies=("car", "ground"), point="D", axis=(0.4, 0.2, -0.9)),
            "rail": SpatialPositionDriver(
                bodies=("car", "ground"), point="D", axis=(0.3, 0.9, 0.2), curve=Sine(amplitude=0.7, frequency=0.3, phase=0.1)
            ),
            "cross": Universal(bodies=("tray", "car"), point="D", axes_of_cross=((1.0, 0.2, 0.0), (-0.2, 1.0, 0.7))),
        },
        loads={
            "weight": SpatialGravity(acceleration=(0.4, -1.3, 0.7)),
            "motor": SpatialTorque(body="link", reaction="block", point="B", torque=(1.7, -0.6, 0.5), curve=FOLLOW),
            "spring": SpatialSpringDamper(bodies=("tray", "crank"), points=("E", "A"), stiffness=2.1, damping=0.6, length=0.4),
            "string": SpatialSpringDamper(bodies=("tray", "dart"), points=("E", "B"), stiffness=1.1, damping=0.6, length=0.4),
        },
        responses={
            "energy": energy,
            "whole": TimeIntegral(of=energy),
            "way": Displacement(body="link", point="B", component="z"),
            "turn": Rotation(body="tray", point="E", axis=(0.3, 0.1, 0.8), time=0.04),
            "force": JointForce(joint="ball", component="magnitude"),
            "torque": JointForce(joint="guide", component="torque-x", time=0.04),
            "drive": JointForce(joint="lead", component="torque-z"),
            "rail": JointForce(joint="rail", component="y"),
        },
        solver=SOLVER,
    )


def frames(folder: Path) -> Scene:
    """Frames of every kind, rigid and flexible (`spatial_cases.write_models`), between springs; they can rest too."""
    turned, energy = (0.3, -0.5, 0.7), KineticEnergy()
    grips = {"S": ("mast", "end"), "T": ("strip", "middle"), "U": ("strip", "end"), "V": ("rubber", "tip")}
    return Scene(
        units="m-kg-s",
        dimension=3,
        directory=folder,
        points=points("OABCF") | {name: BodyPoint(body=body, interface=place) for name, (body, place) in grips.items()},
        bodies={
            "wheel": SpatialRigid(
                mass=0.9,
                inertia=TENSOR,
                center="C",
                frame="turning",
                axis=(0.2, 1.0, 0.4),
                origin="A",
                angular_velocity=(0.04, 0.2, 0.08),
            ),
            "sled": SpatialRigid(mass=1.1, inertia=(0.3, 0.4, 0.5), center="B", frame="translating", velocity=SPEED),
            "plate": SpatialRigid(mass=0.8, inertia=TENSOR, center="F"),
            "mast": SpatialFlexible(
                model="frame.h5", frame="grounded", position=(0.5, 0.4, -0.3), orientation=turned, thickness_bar=0.2
            ),
            "strip": SpatialFlexible(
                model="frame.h5",
                frame="moving",
                position=(-0.4, 0.5, 0.2),
                orientation=turned,
                velocity=SPEED,
                angular_velocity=SPIN,
            ),
            "rubber": SpatialFlexible(
                model="solid.h5",
                frame="grounded",
                position=(0.2, -0.1, 0.3),
                orientation=turned,
                deflection={"V": (0.01, -0.03, 0.02)},
                elastic_velocity={"V": (0.1, 0.2, -0.3)},
            ),
        },
        joints={
            "slot": Prismatic(bodies=("plate", "sled"), point="B", axis=(0.8, -0.5, 0.3)),
            "glue": SpatialRigidJoint(bodies=("strip", "mast"), point=("T", "S")),
        },
        loads={
            "weight": SpatialGravity(acceleration=(0.02, -0.03, 0.04)),
            "sled": SpatialSpringDamper(bodies=("sled", "ground"), points=("B", "O"), stiffness=21.0, damping=0.6, length=1.5),
            "side": SpatialSpringDamper(bodies=("sled", "ground"), points=("B", "F"), stiffness=31.0, damping=0.4),
            "last": SpatialSpringDamper(bodies=("sled", "ground"), points=("B", "C"), stiffness=31.0, damping=0.4, length=1.2),
            "plate": SpatialSpringDamper(bodies=("plate", "ground"), points=("F", "A"), stiffness=11.0, damping=0.4),
            "wheel": SpatialSpringDamper(bodies=("wheel", "ground"), points=("C", "O"), stiffness=41.0, damping=0.3, length=1.4),
            "coil": SpatialRotationalSpringDamper(
                bodies=("wheel", "ground"), point="A", axis=(0.2, 1.0, 0.4), stiffness=3.0, damping=0.2, rest_angle=0.1
            ),
            "turn": SpatialTorque(
                body="wheel",
                point="C",
                torque=(0.2, 0.7, -0.4),
                frame="body",
                curve=Sine(amplitude=0.6, frequency=0.8, phase=0.2),
            ),
            "pull": SpatialPointForce(body="strip", point="U", force=(0.08, -0.11, 0.05), curve=Constant(value=0.4)),
            "push": SpatialPointForce(body="plate", point="F", force=(0.5, 0.4, 0.3), frame="body", curve=FOLLOW),
            "wind": Pressure(body="rubber", surface="top", pressure=0.02, curve=SmoothStep(duration=0.4)),
        },
        responses={
            "energy": energy,
            "whole": TimeIntegral(of=energy),
            "strain": StrainEnergy(),
            "way": Displacement(body="strip", point="U", component="magnitude"),
            "turn": Rotation(body="wheel", point="C", axis=(0.2, 1.0, 0.4)),
            "force": JointForce(joint="glue", component="torque-y"),
            "stress": KSStress(body="strip", aggregation=20.0, reference_stress=1.0),
            "mises": KSStress(body="rubber", aggregation=20.0, reference_stress=1.0),
        },
        solver=SOLVER,
    )


PLACES = {
    "A": (0.2, 0.1, 0.0), "B": (0.9, 0.4, 0.3), "A1": (0.25, 0.16, 0.1), "B1": (0.85, 0.45, 0.2), "S": (1.2, -0.4, 0.1),
    "N": (-0.3, 1.2, 0.2), "F": (-0.5, 0.9, 0.4), "L": (-0.5, -0.4, 0.2), "L1": (-0.7, -0.6, 0.3), "G": (1.5, 1.0, 0.4),
    "H": (1.3, 0.8, 0.5),
}  # fmt: skip
AXLE, ALONG = (0.2, -0.3, 1.0), (3.0, 2.0, 0.0)
"""Perpendicular to each other."""


def wheels(_folder: Path) -> Scene:
    """Two wheels with a rack, two cams and a bushing, and a nut on a screw."""
    energy = KineticEnergy()
    return Scene(
        units="m-kg-s",
        dimension=3,
        points={name: Point(x=x, y=y, z=z) for name, (x, y, z) in PLACES.items()},
        bodies={
            "first": SpatialRigid(mass=0.9, inertia=TENSOR, center="A1"),
            "second": SpatialRigid(mass=1.2, inertia=TENSOR, center="B1"),
            "rack": SpatialRigid(mass=0.4, inertia=TENSOR, center="S"),
            "follower": SpatialRigid(mass=0.3, inertia=TENSOR, center="F"),
            "lever": SpatialRigid(mass=0.6, inertia=TENSOR, center="L1"),
            "nut": SpatialRigid(mass=0.7, inertia=TENSOR, center="N"),
            "weight": SpatialRigid(mass=0.2, inertia=TENSOR, center="G", velocity=SPEED, angular_velocity=SPIN),
        },
        joints={
            "A": SpatialRevolute(bodies=("first", "ground"), point="A", axis=AXLE),
            "B": SpatialRevolute(bodies=("second", "ground"), point="B", axis=AXLE),
            "L": SpatialRevolute(bodies=("lever", "ground"), point="L", axis=AXLE),
            "S": Prismatic(bodies=("rack", "ground"), point="S", axis=ALONG),
            "F": Prismatic(bodies=("follower", "ground"), point="F", axis=(0.2, 1.0, 0.1)),
            "gear": SpatialGear(bodies=("first", "second"), points=("A", "B"), axis=AXLE, teeth=(20, 33)),
            "mesh": SpatialRack(bodies=("second", "rack"), points=("B", "S"), axis=AXLE, along=ALONG, radius=0.31),
            "lift": SpatialCam(bodies=("follower", "first"), points=("F", "A"), axis=AXLE, along=(0.1, 0.9, 0.3), curve=WAVE),
            "swing": SpatialSwingCam(bodies=("lever", "first"), points=("L", "A"), axis=AXLE, curve=WAVE),
            "screw": Screw(bodies=("nut", "ground"), point="N", axis=(0.4, 0.1, 0.9), pitch=1.7),
        },
        loads={
            "weight": SpatialGravity(acceleration=(0.4, -1.3, 0.7)),
            "bushing": SpatialBushing(
                bodies=("weight", "second"),
                point="H",
                stiffness=(2.1, 1.3, 0.8),
                damping=(0.4, 0.3, 0.5),
                rotational_stiffness=(0.7, 0.9, 0.4),
                rotational_damping=(0.2, 0.1, 0.3),
            ),
        },
        responses={
            "energy": energy,
            "whole": TimeIntegral(of=energy),
            "way": Displacement(body="weight", point="G", component="magnitude"),
            "nut": Displacement(body="nut", point="N", component="z"),
            **{name: JointForce(joint=name, component="torque-x") for name in ("A", "B", "L", "S", "F", "screw")},
            "push": JointForce(joint="A", component="y"),
        },
        solver=SOLVER,
    )


def controlled(_folder: Path) -> Scene:
    """A crank, a block on a guide and a boom on a cylinder, each led by a controller; friction in the hinge and on the guide."""
    wave, axis = Sine(amplitude=0.3, frequency=0.8, phase=0.7), (0.2, 1.0, 0.4)
    return Scene(
        units="m-kg-s",
        dimension=3,
        points=points("OABCDE"),
        bodies={
            "crank": SpatialRod(between=("O", "A"), area=0.8, density=1.2),
            "block": SpatialRigid(mass=1.4, inertia=TENSOR, center="C"),
            "boom": SpatialRod(between=("D", "E"), area=0.6, density=0.9),
        },
        joints={
            "hinge": SpatialRevolute(bodies=("crank", "ground"), point="O", axis=axis),
            "guide": Prismatic(bodies=("block", "ground"), point="C", axis=axis),
            "pin": SpatialRevolute(bodies=("boom", "ground"), point="D", axis=(0.1, 0.2, 1.0)),
        },
        loads={
            "weight": SpatialGravity(acceleration=(0.4, -1.3, 0.6)),
            "motor": SpatialAngleController(
                bodies=("crank", "ground"),
                point="O",
                axis=axis,
                proportional_gain=9.0,
                derivative_gain=1.1,
                integral_gain=7.0,
                curve=wave,
            ),
            "drive": SpatialPositionController(
                bodies=("block", "ground"),
                point="C",
                axis=(0.1, 0.9, 0.5),
                proportional_gain=8.0,
                derivative_gain=0.9,
                integral_gain=5.0,
                curve=Constant(value=0.4),
            ),
            "cylinder": SpatialDistanceController(
                bodies=("boom", "ground"),
                points=("E", "B"),
                proportional_gain=7.0,
                derivative_gain=0.8,
                integral_gain=6.0,
                curve=SmoothStep(height=2.1, start=-0.4, duration=0.5),
            ),
            "rub": SpatialTurningFriction(bodies=("crank", "ground"), point="O", axis=axis, level=0.6, width=0.4, curve=wave),
            "slip": SpatialSlidingFriction(bodies=("block", "ground"), point="C", axis=(0.3, 0.9, 0.2), level=0.5, width=0.3),
        },
        responses={
            "turn": Rotation(body="crank", point="A", axis=axis),
            "way": Displacement(body="block", point="C", component="x"),
            "rise": Displacement(body="boom", point="E", component="y"),
            "hinge": JointForce(joint="hinge", component="magnitude"),
            "guide": JointForce(joint="guide", component="magnitude"),
            "pin": JointForce(joint="pin", component="magnitude"),
        },
        solver=SOLVER,
    )


SCENES = {"wheels": wheels, "linkage": linkage, "frames": frames, "controlled": controlled}
