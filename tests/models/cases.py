"""One list of all joints and loads, each as a small scene without symmetries; a new component is one new line."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from preprocessing.elements.section import Section
from tests.models.beam_models import save_beam
from toolkit.components.bodies.flexible import Flexible
from toolkit.components.bodies.rigid import Rigid, Rod
from toolkit.components.curves.combined import Sum
from toolkit.components.curves.oscillation import Harmonic, Sine
from toolkit.components.curves.polynomial import Constant
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.curves.table import Table
from toolkit.components.joints.cam import Cam, SwingCam
from toolkit.components.joints.distance import Distance
from toolkit.components.joints.driver import AngleDriver, PositionDriver
from toolkit.components.joints.gear import Gear
from toolkit.components.joints.joint import Joint
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
from toolkit.components.markers.component import Component, Place, on_both
from toolkit.description.design import BodyPoint, Point
from toolkit.scene.scene import Scene

SINE = Sine(amplitude=0.7, frequency=0.3, phase=0.4)
TABLE = Table(times=(0.0, 0.5, 1.0), values=(0.2, -0.6, 0.9))
SUM = Sum(terms=(SmoothStep(height=1.3, start=-0.2, duration=1.1), Constant(value=0.3), SINE, TABLE))
LINEAR = Table(times=(0.0, 0.5, 1.0), values=(0.2, -0.6, 0.9), interpolation="linear")
PROFILE = Sum(terms=(Harmonic(amplitude=0.4, offset=0.1, frequency=3 / (2 * np.pi), phase=0.3), Constant(value=0.2)))
"""Over one turn."""
LIFT = Table(times=(0.5, 1.7, 2.6, 4.0, 5.5), values=(0.3, 0.8, 0.6, -0.1, 0.3))

GAINS = {"proportional_gain": 2.1, "derivative_gain": 0.6}

KINDS: list[tuple[str, type[Component], dict[str, Any]]] = [
    ("revolute", Revolute, {}),
    ("rigid", RigidJoint, {}),
    ("slider", Slider, {"axis": (0.8, -0.5)}),
    ("slider, rotation locked", Slider, {"axis": (-0.3, 0.9), "lock_rotation": True}),
    ("distance between points", Distance, {}),
    ("distance of given length", Distance, {"length": 1.3}),
    ("angle driver", AngleDriver, {"curve": SUM}),
    ("position driver", PositionDriver, {"axis": (0.8, -0.5), "curve": SINE}),
    ("gear", Gear, {"ratio": 1.7}),
    ("gear in a ring", Gear, {"teeth": (20, -47)}),
    ("rack", Rack, {"axis": (0.8, -0.5)}),
    ("rack of given radius", Rack, {"axis": (0.8, -0.5), "radius": 0.3}),
    ("cam", Cam, {"axis": (0.8, -0.5), "curve": PROFILE}),
    ("cam of a table", Cam, {"curve": LIFT}),
    ("swing cam", SwingCam, {"curve": PROFILE}),
    ("rolling disc", RollingDisc, {"axis": (-0.3, 0.9)}),
    ("torque", Torque, {"torque": 1.7, "curve": TABLE}),
    ("point force", PointForce, {"force": (0.8, -1.1), "curve": SUM}),
    ("following force", PointForce, {"force": (0.8, -1.1), "frame": "body", "curve": LINEAR}),
    ("spring-damper relaxed at the start", SpringDamper, {"stiffness": 2.1, "damping": 0.6}),
    ("spring-damper of given length", SpringDamper, {"stiffness": 2.1, "damping": 0.6, "length": 0.4}),
    ("rotational spring-damper", RotationalSpringDamper, {"stiffness": 2.1, "damping": 0.6, "rest_angle": 0.3}),
    (
        "bushing",
        Bushing,
        {"stiffness": (2.1, 0.7), "damping": (0.6, 0.2), "rotational_stiffness": 1.3, "rotational_damping": 0.4},
    ),
    ("angle controller", AngleController, {**GAINS, "curve": SUM}),
    ("position controller", PositionController, {**GAINS, "axis": (0.8, -0.5), "curve": SINE}),
    ("distance controller", DistanceController, {**GAINS, "curve": TABLE}),
    ("angle controller with an integral", AngleController, {**GAINS, "integral_gain": 1.7, "curve": SUM}),
    (
        "position controller with an integral",
        PositionController,
        {**GAINS, "integral_gain": 1.7, "axis": (0.8, -0.5), "curve": SINE},
    ),
    ("distance controller with an integral", DistanceController, {**GAINS, "integral_gain": 1.7, "curve": TABLE}),
    ("turning friction", PlanarTurningFriction, {"level": 1.3, "width": 0.7, "curve": SINE}),
    ("sliding friction", PlanarSlidingFriction, {"axis": (0.8, -0.5), "level": 1.3, "width": 0.7, "curve": SUM}),
]
"""Name, kind, numbers; bodies and points come from every grip."""

GRIPS = {
    "rod on ground": (("rod", "ground"), ("A", "O"), "A"),
    "rod on rigid": (("rod", "block"), ("B", "C"), "B"),
    "rigid on grounded flexible": (("block", "skin"), ("C", "S"), "S"),
    "moving flexible on rod": (("strip", "rod"), ("T", "B"), "T"),
    "ground on moving flexible": (("ground", "strip"), ("O", "T"), "U"),
    "grounded on moving flexible": (("skin", "strip"), ("S", "T"), ("S", "T")),
}
"""Bodies a and b, a point on each, and the point where they meet: one that both share, or one of each flexible body."""


@dataclass(frozen=True)
class Case:
    """A scene of one component and the bodies that it grips."""

    name: str
    kind: type[Component] | None
    numbers: dict[str, Any]
    bodies: tuple[str, str]
    points: tuple[str, str]
    common: Place

    def scene(self, directory: Path) -> Scene:
        """The scene, with its reduced models in `directory` (see `write_models`)."""
        joints: dict[str, Any] = {}
        loads: dict[str, Any] = {"gravity": Gravity(acceleration=(0.4, -1.3))}
        if self.kind is not None:
            group = joints if issubclass(self.kind, Joint) else loads
            group["component"] = self.kind(**self._places(), **self.numbers)
        bodies = {name: body for name, body in all_bodies().items() if name in self.bodies}
        return Scene(units="m-kg-s", points=points(bodies), bodies=bodies, joints=joints, loads=loads, directory=directory)

    def _places(self) -> dict[str, Any]:
        fields = self.kind.model_fields if self.kind else {}
        given: dict[str, Any] = {}
        if "bodies" in fields:
            given["bodies"] = self.bodies
        if "points" in fields:
            given["points"] = self.points
        first, second = self.bodies if self.bodies[0] != "ground" else self.bodies[::-1]
        if "point" in fields:
            given["point"] = on_both(self.common)[0] if fields["point"].annotation is str else self.common
        if "body" in fields:
            given["body"] = first
        if "reaction" in fields:
            given["reaction"] = second
        return given


def all_bodies() -> dict[str, Any]:
    """Every kind of body."""
    return {
        "rod": Rod(between=("A", "B"), area=0.8, density=1.2),
        "block": Rigid(mass=1.4, inertia=0.6, center="C"),
        "skin": Flexible(model="beam.h5", frame="grounded", position=(0.3, -0.2), angle=0.7, thickness=0.33),
        "strip": Flexible(model="beam.h5", frame="moving", position=(-0.4, 0.5), angle=-0.6, youngs_modulus=1.5),
    }


def points(bodies: dict[str, Any]) -> dict[str, Any]:
    """Points of the scene; interface points only of the bodies that it has."""
    free = {"O": (0.1, 0.2), "A": (1.0, 0.3), "B": (2.0, 1.1), "C": (1.6, -0.4)}
    given: dict[str, Any] = {name: Point(x=x, y=y) for name, (x, y) in free.items()}
    interfaces = {"S": ("skin", "middle"), "T": ("strip", "middle"), "U": ("strip", "end")}
    return given | {name: BodyPoint(body=b, interface=i) for name, (b, i) in interfaces.items() if b in bodies}


def write_models(directory: Path) -> None:
    """The flexible body of all cases: a damped, bent beam with numbers of order one, gripped inside an element and at its end."""
    nodes = np.array([[0.0, 0.0], [0.6, 0.1], [1.0, 0.5], [1.1, 1.2]])
    length = float(np.linalg.norm(np.diff(nodes, axis=0), axis=1).sum())
    section = Section(youngs_modulus=1.2, density=0.9, thickness=0.3, width=0.8, damping_mass=0.2, damping_stiffness=0.3)
    save_beam(directory / "beam.h5", nodes, section, {"middle": 0.9, "end": length})


def _cases() -> list[Case]:
    alone = [("rod", "skin"), ("block", "strip")]
    cases = [Case(f"{a} and {b} alone", None, {}, (a, b), ("A", "C"), "A") for a, b in alone]
    for name, kind, numbers in KINDS:
        for grip, (bodies, places, common) in GRIPS.items():
            cases.append(Case(f"{name}: {grip}", kind, numbers, bodies, places, common))
    return cases


CASES = _cases()
