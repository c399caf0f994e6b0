"""Scenes that contain, together, every kind of body, joint, load and time curve; and the numbers in them without effect."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from toolkit.components.bodies.flexible import Flexible
from toolkit.components.bodies.rigid import Rigid, Rod
from toolkit.components.curves.combined import Product, Sequence, Sum
from toolkit.components.curves.oscillation import Harmonic, Sine
from toolkit.components.curves.polynomial import Constant, Polynomial
from toolkit.components.curves.rise import Cycloid, Ramp, SmoothStep
from toolkit.components.curves.table import Table
from toolkit.components.joints.cam import Cam, SwingCam
from toolkit.components.joints.distance import Distance
from toolkit.components.joints.driver import AngleDriver, PositionDriver
from toolkit.components.joints.gear import Gear
from toolkit.components.joints.rack import Rack, RollingDisc
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.rigid_joint import RigidJoint
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.bushing import Bushing
from toolkit.components.loads.controllers import AngleController, DistanceController, PositionController
from toolkit.components.loads.friction import PlanarSlidingFriction, PlanarTurningFriction
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.point_force import PointForce
from toolkit.components.loads.springs import RotationalSpringDamper, SpringDamper
from toolkit.components.loads.torque import Torque
from toolkit.description.design import BodyPoint, Point
from toolkit.description.run_options import RunOptions
from toolkit.responses.balance import Power, Work
from toolkit.responses.energy import KineticEnergy, StrainEnergy
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Displacement, Rotation
from toolkit.responses.over_time import TimeIntegral
from toolkit.responses.stress import KSStress, MaxStress
from toolkit.scene.scene import Scene

SOLVER = RunOptions(end_time=0.06, step=0.02, tolerance=1e-13, assemble=True, rho_inf=0.7, load_steps=1)
"""Few steps; Newton down to round-off, because a derivative is as exact as the state; lengths and start values move the bodies."""

RISE = Cycloid(height=0.02, start=-0.02, duration=0.09)
SLOPE = float(RISE.evaluate(np.array([0.03]))[0, 1])
LEAD = Sum(
    terms=(
        Constant(value=0.05),
        SmoothStep(height=0.5, start=-0.2, duration=1.1),
        Sine(amplitude=0.1, frequency=0.6, phase=0.4),
        Table(times=(-0.1, 0.05, 0.11, 0.9), values=(-0.08, -0.1, -0.12, 0.1)),
        Product(
            curve=Harmonic(offset=0.02, amplitude=0.05, frequency=0.7, phase=0.9),
            factors=(Ramp(initial=0.3, final=1.2, start=-0.03, end=0.2, smoothness="cubic"),),
        ),
        Sequence(curves=(RISE, Polynomial(coefficients=(0.3, SLOPE - 0.02 * 0.7, 0.7), start=-0.01)), times=(0.03,)),
    )
)
"""Every kind of curve; its value at the start is small, so that the bodies move little to follow it. No step hits a corner."""
FOLLOW = Table(times=(-0.07, 0.05, 0.38), values=(0.2, -0.6, 0.9), interpolation="linear")

POINTS = {
    "O": (0.1, 0.2),
    "A": (1.0, 0.3),
    "B": (2.0, 1.1),
    "C": (1.6, -0.4),
    "D": (2.9, 0.4),
    "E": (3.3, -0.6),
    "F": (0.4, -0.9),
}


def points(names: str) -> dict[str, Any]:
    """Points by their letters."""
    return {name: Point(x=POINTS[name][0], y=POINTS[name][1]) for name in names}


def rods(_folder: Path) -> Scene:
    """Two driven rods, a guided block, and a car with a tray."""
    return Scene(
        units="m-kg-s",
        points=points("OABCDE"),
        bodies={
            "crank": Rod(between=("O", "A"), area=0.8, density=1.2),
            "link": Rod(between=("A", "B"), area=0.6, density=0.9, angular_velocity=0.4),
            "block": Rigid(mass=1.4, inertia=0.6, center="C", angular_velocity=0.2),
            "car": Rigid(mass=0.7, inertia=0.3, center="D"),
            "tray": Rigid(mass=0.5, inertia=0.2, center="E"),
        },
        joints={
            "hinge": Revolute(bodies=("crank", "ground"), point="O"),
            "lead": AngleDriver(bodies=("crank", "ground"), point="O", curve=LEAD),
            "pin": Revolute(bodies=("crank", "link"), point="A"),
            "bar": Distance(bodies=("link", "block"), points=("B", "C"), length=1.55),
            "guide": Slider(bodies=("block", "ground"), point="C", axis=(0.8, -0.5)),
            "glue": RigidJoint(bodies=("car", "tray"), point="D"),
            "rail": PositionDriver(
                bodies=("car", "ground"), point="D", axis=(0.3, 0.9), curve=Sine(amplitude=0.7, frequency=0.3, phase=0.1)
            ),
            "slot": Slider(bodies=("tray", "block"), point="E", axis=(-0.3, 0.9), lock_rotation=True),
        },
        loads={
            "weight": Gravity(acceleration=(0.4, -1.3)),
            "motor": Torque(body="link", reaction="block", point="B", torque=1.7, curve=FOLLOW),
            "spring": SpringDamper(bodies=("block", "crank"), points=("C", "A"), stiffness=2.1, damping=0.6, length=0.4),
        },
        responses={
            "turn": Rotation(body="link", point="B"),
            "way": Displacement(body="car", point="E", component="x"),
            "hinge": JointForce(joint="hinge", component="x"),
            "drive": JointForce(joint="lead", component="torque"),
            "rail": JointForce(joint="rail", component="magnitude"),
            "slot": JointForce(joint="slot", component="torque", time=0.04),
            "energy": TimeIntegral(of=KineticEnergy()),
        },
        solver=SOLVER,
    )


def swing(_folder: Path) -> Scene:
    """A hanging rod and a block on springs next to a driven arm with a cart: it can rest too."""
    curve = Sum(
        terms=(Constant(value=0.02), Sine(amplitude=0.1, frequency=0.6, phase=-0.1), SmoothStep(height=0.1, duration=0.7))
    )
    return Scene(
        units="m-kg-s",
        points=points("OABCDEF"),
        bodies={
            "rod": Rod(between=("O", "A"), area=0.8, density=1.2),
            "block": Rigid(mass=1.4, inertia=0.6, center="C", velocity=(0.3, -0.1, 0.2)),
            "arm": Rod(between=("O", "F"), area=0.7, density=1.1),
            "cart": Rigid(mass=0.5, inertia=0.2, center="E"),
            "tray": Rigid(mass=0.3, inertia=0.1, center="D"),
        },
        joints={
            "hinge": Revolute(bodies=("rod", "ground"), point="O"),
            "bar": Distance(bodies=("rod", "block"), points=("A", "C")),
            "pin": Revolute(bodies=("arm", "ground"), point="O"),
            "lead": AngleDriver(bodies=("arm", "ground"), point="O", curve=curve),
            "slot": Slider(bodies=("cart", "arm"), point="E", axis=(0.8, -0.5), lock_rotation=True),
            "rail": PositionDriver(bodies=("cart", "arm"), point="E", axis=(0.3, 0.9), curve=LEAD),
            "glue": RigidJoint(bodies=("cart", "tray"), point="D"),
        },
        loads={
            "weight": Gravity(acceleration=(0.4, -1.3)),
            "spring": SpringDamper(bodies=("block", "tray"), points=("C", "B"), stiffness=41.0, damping=0.6, length=1.5),
            "relaxed": SpringDamper(bodies=("block", "ground"), points=("C", "F"), stiffness=31.0, damping=0.4),
            "coil": RotationalSpringDamper(bodies=("block", "rod"), point="A", stiffness=21.0, damping=0.6, rest_angle=0.03),
            "pull": PointForce(body="rod", point="A", force=(0.8, -1.1), curve=Constant(value=0.4)),
            "thrust": PointForce(body="block", point="B", force=(0.5, 0.4), frame="body", curve=FOLLOW),
            "motor": Torque(
                body="rod", reaction="arm", point="O", torque=0.7, curve=Sine(amplitude=0.6, frequency=0.8, phase=0.2)
            ),
        },
        responses={
            "turn": Rotation(body="rod", point="A"),
            "way": Displacement(body="block", point="B", component="y"),
            "bar": JointForce(joint="bar", component="magnitude"),
            "rail": JointForce(joint="rail", component="x"),
            "slot": JointForce(joint="slot", component="torque"),
            "lead": JointForce(joint="lead", component="torque"),
        },
        solver=SOLVER,
    )


def beams(folder: Path) -> Scene:
    """A grounded and a floating beam (`cases.write_models`), hinged at a point of each, gripped between nodes."""
    grips = {"S": ("skin", "end"), "T": ("strip", "middle"), "U": ("strip", "end"), "V": ("skin", "middle")}
    return Scene(
        units="m-kg-s",
        directory=folder,
        points=points("A") | {name: BodyPoint(body=body, interface=place) for name, (body, place) in grips.items()},
        bodies={
            "skin": Flexible(model="beam.h5", frame="grounded", position=(0.3, -0.2), angle=0.7, thickness=0.6),
            "strip": Flexible(
                model="beam.h5",
                frame="moving",
                position=(-0.46, 1.61),
                angle=-0.6,
                youngs_modulus=15.0,
                angular_velocity=0.2,
            ),
        },
        joints={"hinge": Revolute(bodies=("strip", "skin"), point=("T", "S"))},
        loads={
            "weight": Gravity(acceleration=(0.02, -0.03)),
            "spring": SpringDamper(bodies=("strip", "ground"), points=("U", "A"), stiffness=0.3, damping=0.2, length=1.6),
            "coil": RotationalSpringDamper(
                bodies=("strip", "skin"), point=("U", "V"), stiffness=0.2, damping=0.1, rest_angle=0.1
            ),
            "push": PointForce(body="skin", point="V", force=(0.01, 0.02), frame="body", curve=SmoothStep(duration=0.4)),
        },
        responses={
            "turn": Rotation(body="strip", point="U"),
            "way": Displacement(body="skin", point="V", component="x"),
            "hinge": JointForce(joint="hinge", component="y"),
            "stress": KSStress(body="strip", aggregation=20.0, reference_stress=1.0),
            "peak": MaxStress(body="skin"),
            "strain": StrainEnergy(),
            "energy": TimeIntegral(of=KineticEnergy()),
        },
        solver=SOLVER,
    )


def flight(folder: Path) -> Scene:
    """A rod and a beam that fly, tied by springs alone."""
    return Scene(
        units="m-kg-s",
        directory=folder,
        points=points("OA") | {"T": BodyPoint(body="strip", interface="middle"), "U": BodyPoint(body="strip", interface="end")},
        bodies={
            "rod": Rod(between=("O", "A"), area=0.8, density=1.2, velocity=(0.1, 0.2, -0.3)),
            "strip": Flexible(
                model="beam.h5",
                position=(-0.4, 1.6),
                angle=-0.6,
                velocity=(0.1, -0.3, 0.2),
                deflection={"T": (0.02, -0.03), "U": (0.04, 0.01)},
                elastic_velocity={"U": (0.2, -0.3)},
            ),
        },
        loads={
            "spring": SpringDamper(bodies=("strip", "rod"), points=("T", "O"), stiffness=0.3, damping=0.2, length=1.2),
            "coil": RotationalSpringDamper(bodies=("strip", "rod"), point=("T", "A"), stiffness=0.2, damping=0.1, rest_angle=0.1),
        },
        responses={
            "turn": Rotation(body="strip", point="T"),
            "way": Displacement(body="rod", point="A", component="x"),
            "stress": KSStress(body="strip", aggregation=20.0, reference_stress=1.0),
            "energy": TimeIntegral(of=KineticEnergy()),
        },
        solver=SOLVER,
    )


WAVE = Sine(amplitude=0.2, frequency=1 / np.pi, phase=0.3)
"""Two waves a turn."""
PLACES = {
    "A": (0.2, 0.1), "B": (0.9, 0.4), "C": (1.3, 0.1), "D": (2.0, 0.35), "A1": (0.25, 0.16), "B1": (0.85, 0.45), "C1": (1.35, 0.03),
    "D1": (2.1, 0.37), "S": (1.2, -0.4), "P": (0.5, 1.5), "Q": (0.7, 1.1), "F": (-0.5, 0.9), "L": (-0.5, -0.4), "L1": (-0.7, -0.6),
    "G": (2.5, 1.0), "H": (2.3, 0.8),
}  # fmt: skip


def wheels(_folder: Path) -> Scene:
    """A train of four wheels with a rack, two cams and a bushing, and a disc that rolls."""
    axles = {name: ("ABCD"[k], f"{'ABCD'[k]}1") for k, name in enumerate(("first", "second", "third", "fourth"))}
    guides = {"rack": ("S", (1.0, 0.1)), "follower": ("F", (0.3, 1.0))}
    return Scene(
        units="m-kg-s",
        points={name: Point(x=x, y=y) for name, (x, y) in PLACES.items()},
        bodies={
            **{name: Rigid(mass=0.5 + 0.1 * len(name), inertia=0.2, center=center) for name, (_, center) in axles.items()},
            "rack": Rigid(mass=0.4, inertia=0.1, center="S"),
            "follower": Rigid(mass=0.3, inertia=0.1, center="F"),
            "lever": Rigid(mass=0.6, inertia=0.05, center="L1"),
            "disc": Rigid(mass=0.7, inertia=0.04, center="P", angular_velocity=0.2),
            "weight": Rigid(mass=0.2, inertia=0.03, center="G", velocity=(0.1, -0.2, 0.3)),
        },
        joints={
            **{f"axle of {name}": Revolute(bodies=(name, "ground"), point=point) for name, (point, _) in axles.items()},
            **{
                f"guide of {name}": Slider(bodies=(name, "ground"), point=point, axis=axis, lock_rotation=True)
                for name, (point, axis) in guides.items()
            },
            "pivot": Revolute(bodies=("lever", "ground"), point="L"),
            "ratio": Gear(bodies=("first", "second"), points=("A", "B"), ratio=1.7),
            "radii": Gear(bodies=("second", "third"), points=("B", "C"), radii=(0.2, 0.3)),
            "teeth": Gear(bodies=("third", "fourth"), points=("C", "D"), teeth=(20, -57)),
            "mesh": Rack(bodies=("third", "rack"), points=("C", "S"), axis=(0.9, 0.2), radius=0.21),
            "lift": Cam(bodies=("follower", "first"), points=("F", "A"), axis=(0.4, 0.9), curve=WAVE),
            "swing": SwingCam(bodies=("lever", "first"), points=("L", "A"), curve=WAVE),
            "roll": RollingDisc(bodies=("disc", "ground"), points=("P", "Q"), axis=(1.0, 0.2), radius=0.45),
        },
        loads={
            "weight": Gravity(acceleration=(0.4, -1.3)),
            "bushing": Bushing(
                bodies=("weight", "fourth"),
                point="H",
                stiffness=(2.1, 1.3),
                damping=(0.4, 0.3),
                rotational_stiffness=0.7,
                rotational_damping=0.2,
            ),
        },
        responses={
            "turn": Rotation(body="fourth", point="D"),
            "way": Displacement(body="weight", point="G", component="x"),
            "disc": Displacement(body="disc", point="P", component="x"),
            "lever": JointForce(joint="pivot", component="y"),
            "follower": JointForce(joint="guide of follower", component="torque"),
            "rack": JointForce(joint="guide of rack", component="torque"),
            "roll": JointForce(joint="roll", component="magnitude"),
            **{name: JointForce(joint=f"axle of {name}", component="x") for name in axles},
            "energy": TimeIntegral(of=KineticEnergy()),
        },
        solver=SOLVER,
    )


def controlled(_folder: Path) -> Scene:
    """A crank, a block on a guide and a boom on a cylinder, each led by a controller; friction in the hinge and on the guide."""
    wave = Sine(amplitude=0.3, frequency=0.8, phase=0.7)
    return Scene(
        units="m-kg-s",
        points=points("OABCDE"),
        bodies={
            "crank": Rod(between=("O", "A"), area=0.8, density=1.2, angular_velocity=0.4),
            "block": Rigid(mass=1.4, inertia=0.6, center="C"),
            "boom": Rod(between=("D", "E"), area=0.6, density=0.9),
        },
        joints={
            "hinge": Revolute(bodies=("crank", "ground"), point="O"),
            "guide": Slider(bodies=("block", "ground"), point="C", axis=(0.8, -0.5), lock_rotation=True),
            "pin": Revolute(bodies=("boom", "ground"), point="D"),
        },
        loads={
            "weight": Gravity(acceleration=(0.4, -1.3)),
            "motor": AngleController(
                bodies=("crank", "ground"), point="O", proportional_gain=9.0, derivative_gain=1.1, integral_gain=7.0, curve=wave
            ),
            "drive": PositionController(
                bodies=("block", "ground"),
                point="C",
                axis=(0.8, -0.5),
                proportional_gain=8.0,
                derivative_gain=0.9,
                integral_gain=5.0,
                curve=Constant(value=0.4),
            ),
            "cylinder": DistanceController(
                bodies=("boom", "ground"),
                points=("E", "B"),
                proportional_gain=7.0,
                derivative_gain=0.8,
                integral_gain=6.0,
                curve=SmoothStep(height=2.2, start=-0.4, duration=0.5),
            ),
            "rub": PlanarTurningFriction(bodies=("crank", "ground"), point="O", level=0.6, width=0.4, curve=wave),
            "slip": PlanarSlidingFriction(bodies=("block", "ground"), point="C", axis=(0.7, -0.6), level=0.5, width=0.3),
        },
        responses={
            "turn": Rotation(body="crank", point="A"),
            "way": Displacement(body="block", point="C", component="x"),
            "rise": Displacement(body="boom", point="E", component="y"),
            "hinge": JointForce(joint="hinge", component="magnitude"),
            "guide": JointForce(joint="guide", component="magnitude"),
            "pin": JointForce(joint="pin", component="magnitude"),
            "power": Power(load="motor"),
            "work": Work(load="drive"),
        },
        solver=SOLVER,
    )


SCENES = {"wheels": wheels, "flight": flight, "rods": rods, "swing": swing, "beams": beams, "controlled": controlled}
