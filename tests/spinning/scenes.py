"""Scenes that a motor spins, in the plane and in space, with closed forms in their tests."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from preprocessing.elements.section import Section
from tests.models.beam_models import save_beam
from tests.spatial.scenes import at, save_frame
from toolkit.components.bodies.flexible import Flexible, SpatialFlexible
from toolkit.components.bodies.rigid import Rigid, SpatialRigid
from toolkit.components.curves.polynomial import Polynomial
from toolkit.components.joints.driver import AngleDriver, SpatialAngleDriver
from toolkit.components.joints.prismatic import Prismatic
from toolkit.components.joints.revolute import Revolute, SpatialRevolute
from toolkit.components.joints.rigid_joint import RigidJoint, SpatialRigidJoint
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.gravity import SpatialGravity
from toolkit.components.loads.springs import SpatialRotationalSpringDamper, SpatialSpringDamper, SpringDamper
from toolkit.description.design import BodyPoint, Point
from toolkit.description.run_options import RunOptions
from toolkit.foundation.kinematics.orientation import matrix_of, quaternion_of
from toolkit.responses.vibration import DampingRatio, Frequency
from toolkit.scene.scene import Scene

Z = (0.0, 0.0, 1.0)
SPINNING = RunOptions(equilibrium="spinning")
VIBRATION: dict[str, Any] = {"f": Frequency(), "zeta": DampingRatio()}


def motor(speed: float) -> Polynomial:
    return Polynomial(coefficients=(0.0, speed))


def table(speed: float = 3.0, stiffness: float = 50.0, mass: float = 2.0, damping: float = 1.0, **changes: Any) -> Scene:
    """A block on a radial spring of relaxed length 1, on a table; the spring is tied to the table 1 off its axis."""
    parts: dict[str, Any] = {
        "units": "m-kg-s",
        "points": {"O": Point(x=0.5, y=0.2), "P": Point(x=1.5, y=0.2), "Q": Point(x=2.5, y=0.2)},
        "bodies": {"table": Rigid(mass=1.0, inertia=1.0, center="O"), "block": Rigid(mass=mass, inertia=0.1, center="Q")},
        "joints": {
            "hinge": Revolute(bodies=("table", "ground"), point="O"),
            "motor": AngleDriver(bodies=("table", "ground"), point="O", curve=motor(speed)),
            "rail": Slider(bodies=("block", "table"), point="Q", axis=(1.0, 0.0), lock_rotation=True),
        },
        "loads": {"spring": SpringDamper(bodies=("block", "table"), points=("Q", "P"), stiffness=stiffness, damping=damping)},
        "responses": VIBRATION,
        "solver": SPINNING,
    }
    return Scene(**(parts | changes))


def table_in_space(speed: float, stiffness: float, mass: float, damping: float) -> Scene:
    """The same about an oblique axis through a point anywhere."""
    A = matrix_of(quaternion_of(np.array([0.4, -0.3, 0.7])))
    origin = np.array([0.3, -0.2, 0.1])
    places = {name: origin + A @ np.array([x, 0.0, 0.0]) for name, x in (("O", 0.0), ("P", 1.0), ("Q", 2.0))}
    radial, axis = (tuple(float(each) for each in column) for column in (A[:, 0], A[:, 2]))
    return Scene(
        units="m-kg-s",
        dimension=3,
        points=at(**places),
        bodies={
            "table": SpatialRigid(mass=1.0, inertia=(1.0, 1.0, 1.0), center="O"),
            "block": SpatialRigid(mass=mass, inertia=(0.1, 0.2, 0.15), center="Q"),
        },
        joints={
            "hinge": SpatialRevolute(bodies=("table", "ground"), point="O", axis=axis),
            "motor": SpatialAngleDriver(bodies=("ground", "table"), point="O", axis=axis, curve=motor(speed)),
            "rail": Prismatic(bodies=("block", "table"), point="Q", axis=radial),
        },
        loads={"spring": SpatialSpringDamper(bodies=("block", "table"), points=("Q", "P"), stiffness=stiffness, damping=damping)},
        responses=VIBRATION,
        solver=SPINNING,
    )


def governor(speed: float, length: float = 0.7, gravity: float = 9.81, across: float = 0.02, along: float = 0.01) -> Scene:
    """A ball of 1 kg on an arm that hangs from the axis by a hinge; given at 1 rad from the vertical."""
    place = length * np.array([np.sin(1.0), 0.0, -np.cos(1.0)])
    turn = matrix_of(quaternion_of(np.array([0.0, -1.0, 0.0])))  # turns -z to the arm
    inertia = turn @ np.diag([across, across, along]) @ turn.T
    numbers = (inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[1, 2], inertia[0, 2], inertia[0, 1])
    return Scene(
        units="m-kg-s",
        dimension=3,
        points=at(O=(0.0, 0.0, 0.0), B=tuple(place)),
        bodies={
            "spindle": SpatialRigid(mass=1.0, inertia=(1.0, 1.0, 1.0), center="O"),
            "ball": SpatialRigid(mass=1.0, inertia=tuple(float(each) for each in numbers), center="B"),
        },
        joints={
            "bearing": SpatialRevolute(bodies=("spindle", "ground"), point="O", axis=Z),
            "motor": SpatialAngleDriver(bodies=("spindle", "ground"), point="O", axis=Z, curve=motor(speed)),
            "hinge": SpatialRevolute(bodies=("ball", "spindle"), point="O", axis=(0.0, 1.0, 0.0)),
        },
        loads={"weight": SpatialGravity(acceleration=(0.0, 0.0, -gravity))},
        responses=VIBRATION,
        solver=SPINNING,
    )


def top(speed: float, polar: float = 0.5, across: float = 0.3, stiffness: float = 40.0) -> Scene:
    """A disc on a shaft that bends: it tilts by a cross of two axes, both with springs, which spins with the motor."""
    x, y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    light = 1e-9
    return Scene(
        units="m-kg-s",
        dimension=3,
        points=at(O=(0.0, 0.0, 0.0)),
        bodies={
            "shaft": SpatialRigid(mass=1.0, inertia=(1.0, 1.0, 1.0), center="O"),
            "cross": SpatialRigid(mass=light, inertia=(light, light, light), center="O"),
            "disc": SpatialRigid(mass=2.0, inertia=(across, across, polar), center="O"),
        },
        joints={
            "bearing": SpatialRevolute(bodies=("shaft", "ground"), point="O", axis=Z),
            "motor": SpatialAngleDriver(bodies=("shaft", "ground"), point="O", axis=Z, curve=motor(speed)),
            "first": SpatialRevolute(bodies=("cross", "shaft"), point="O", axis=x),
            "second": SpatialRevolute(bodies=("disc", "cross"), point="O", axis=y),
        },
        loads={
            "about_x": SpatialRotationalSpringDamper(bodies=("cross", "shaft"), point="O", axis=x, stiffness=stiffness),
            "about_y": SpatialRotationalSpringDamper(bodies=("disc", "cross"), point="O", axis=y, stiffness=stiffness),
        },
        responses={"first": Frequency(), "second": Frequency(number=2)},
        solver=SPINNING,
    )


MODULUS, DENSITY, DIAMETER = 6.75e10, 2700.0, 8e-3
UNIT = 10.0
"""sqrt(E I / rho A) / L^2 of the round bar of 1 m, in rad/s."""
BEAM = """units = "m-kg-s"
clamp = ["root"]
nodes = {{ root = [0, 0, 0], tip = [{length}, 0, 0] }}
beams = [{{ from = "root", to = "tip", section = "round", elements = 1 }}]
sections = {{ round = {{ kind = "circle", diameter = 8e-3, material = "alloy" }} }}
materials = {{ alloy = {{ youngs_modulus = 6.75e10, poisson_ratio = 0.3, density = 2700.0 }} }}
interface_points = {{ root = {{ node = "root" }}, tip = {{ node = "tip" }} }}
"""


def blade(folder: Path, parts: int, speed: float) -> Scene:
    """A round bar of 1 m on an axis across it, of a number of bodies in a row."""
    save_frame(folder, "beam", BEAM.format(length=1 / parts))
    names = [f"part{k}" for k in range(parts)]
    bodies = {name: SpatialFlexible(model="beam.h5", position=(k / parts, 0.0, 0.0)) for k, name in enumerate(names)}
    joints = {
        "axis": SpatialRevolute(bodies=("part0", "ground"), point="part0_root", axis=Z),
        "motor": SpatialAngleDriver(bodies=("part0", "ground"), point="part0_root", axis=Z, curve=motor(speed)),
    }
    for k in range(1, parts):
        joints[f"joint{k}"] = SpatialRigidJoint(bodies=(names[k], names[k - 1]), point=(f"part{k}_root", f"part{k - 1}_tip"))
    return Scene(
        units="m-kg-s", dimension=3, directory=folder, points=_ends(names), bodies=bodies, joints=joints, solver=SPINNING
    )


def planar_blade(folder: Path, parts: int, speed: float, damping: float = 0.0) -> Scene:
    """The same in the plane: a rectangular section of the same area and stiffness across."""
    area, second = np.pi * DIAMETER**2 / 4, np.pi * DIAMETER**4 / 64
    thickness = np.sqrt(12 * second / area)
    section = Section(
        youngs_modulus=MODULUS, density=DENSITY, thickness=thickness, width=area / thickness, damping_stiffness=damping
    )
    nodes = np.array([[0.0, 0.0], [1 / parts, 0.0]])
    save_beam(folder / "plane.h5", nodes, section, {"root": 0.0, "tip": 1 / parts})
    names = [f"part{k}" for k in range(parts)]
    bodies = {name: Flexible(model="plane.h5", frame="moving", position=(k / parts, 0.0)) for k, name in enumerate(names)}
    joints = {
        "axis": Revolute(bodies=("part0", "ground"), point="part0_root"),
        "motor": AngleDriver(bodies=("part0", "ground"), point="part0_root", curve=motor(speed)),
    }
    for k in range(1, parts):
        joints[f"joint{k}"] = RigidJoint(bodies=(names[k], names[k - 1]), point=(f"part{k}_root", f"part{k - 1}_tip"))
    return Scene(units="m-kg-s", directory=folder, points=_ends(names), bodies=bodies, joints=joints, solver=SPINNING)


def _ends(names: list[str]) -> dict[str, BodyPoint]:
    return {f"{name}_{end}": BodyPoint(body=name, interface=end) for name in names for end in ("root", "tip")}
