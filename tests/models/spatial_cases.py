"""One list of all joints and loads in space, each as a small scene without symmetries; a new component is one new line."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from preprocessing import build
from tests.models.cases import GAINS, LIFT, LINEAR, PROFILE, SINE, SUM, TABLE
from tests.models.kept_files import write_once
from tests.models.solid_bodies import box, write_body
from toolkit.components.bodies.flexible import SpatialFlexible
from toolkit.components.bodies.rigid import SpatialRigid, SpatialRod
from toolkit.components.joints.cam import SpatialCam, SpatialSwingCam
from toolkit.components.joints.cylindrical import Cylindrical
from toolkit.components.joints.distance import SpatialDistance
from toolkit.components.joints.driver import SpatialAngleDriver, SpatialPositionDriver
from toolkit.components.joints.gear import SpatialGear
from toolkit.components.joints.joint import Joint
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
from toolkit.components.markers.component import Component, Place, on_both
from toolkit.description.design import BodyPoint, Point
from toolkit.reduced_model.file import save
from toolkit.scene.scene import Scene

AXIS = (0.8, -0.5, 0.6)
KINDS: list[tuple[str, type[Component], dict[str, Any]]] = [
    ("spherical", Spherical, {}),
    ("rigid", SpatialRigidJoint, {}),
    ("revolute", SpatialRevolute, {"axis": AXIS}),
    ("prismatic", Prismatic, {"axis": AXIS}),
    ("cylindrical", Cylindrical, {"axis": AXIS}),
    ("universal", Universal, {"axes_of_cross": ((1.0, 0.2, 0.0), (-0.2, 1.0, 0.7))}),
    ("point on plane", PointOnPlane, {"axis": AXIS}),
    ("distance between points", SpatialDistance, {}),
    ("distance of given length", SpatialDistance, {"length": 1.3}),
    ("angle driver", SpatialAngleDriver, {"axis": AXIS, "curve": SUM}),
    ("position driver", SpatialPositionDriver, {"axis": AXIS, "curve": SINE}),
    ("cam", SpatialCam, {"axis": AXIS, "along": (0.3, 0.4, -0.7), "curve": PROFILE}),
    ("cam of a table", SpatialCam, {"axis": AXIS, "along": AXIS, "curve": LIFT}),
    ("swing cam", SpatialSwingCam, {"axis": AXIS, "curve": PROFILE}),
    ("screw", Screw, {"axis": AXIS, "pitch": -1.9}),
    ("gear", SpatialGear, {"axis": AXIS, "teeth": (14, 35)}),
    ("gear in a ring", SpatialGear, {"axis": AXIS, "teeth": (3, -8)}),
    ("rack", SpatialRack, {"axis": AXIS, "along": (0.5, 0.8, 0.0)}),
    ("rack of given radius", SpatialRack, {"axis": AXIS, "along": (0.5, 0.8, 0.0), "radius": 0.3}),
    ("torque", SpatialTorque, {"torque": (1.7, -0.6, 0.9), "curve": TABLE}),
    ("following torque", SpatialTorque, {"torque": (1.7, -0.6, 0.9), "frame": "body", "curve": SUM}),
    ("point force", SpatialPointForce, {"force": (0.8, -1.1, 0.5), "curve": SUM}),
    ("following force", SpatialPointForce, {"force": (0.8, -1.1, 0.5), "frame": "body", "curve": LINEAR}),
    (
        "rotational spring-damper",
        SpatialRotationalSpringDamper,
        {"axis": AXIS, "stiffness": 2.1, "damping": 0.6, "rest_angle": 0.3},
    ),
    (
        "rotational spring-damper that counts turns",
        SpatialRotationalSpringDamper,
        {"axis": AXIS, "stiffness": 2.1, "damping": 0.6, "rest_angle": 0.3, "counts_turns": True},
    ),
    ("spring-damper relaxed at the start", SpatialSpringDamper, {"stiffness": 2.1, "damping": 0.6}),
    ("spring-damper of given length", SpatialSpringDamper, {"stiffness": 2.1, "damping": 0.6, "length": 0.4}),
    (
        "bushing",
        SpatialBushing,
        {
            "stiffness": (2.1, 0.7, 1.2),
            "damping": (0.6, 0.2, 0.9),
            "rotational_stiffness": (1.3, 0.3, 1.9),
            "rotational_damping": (0.4, 0.8, 0.5),
        },
    ),
    ("angle controller", SpatialAngleController, {**GAINS, "axis": AXIS, "curve": SUM}),
    ("position controller", SpatialPositionController, {**GAINS, "axis": AXIS, "curve": SINE}),
    ("distance controller", SpatialDistanceController, {**GAINS, "curve": TABLE}),
    ("angle controller with an integral", SpatialAngleController, {**GAINS, "integral_gain": 1.7, "axis": AXIS, "curve": SUM}),
    (
        "position controller with an integral",
        SpatialPositionController,
        {**GAINS, "integral_gain": 1.7, "axis": AXIS, "curve": SINE},
    ),
    ("distance controller with an integral", SpatialDistanceController, {**GAINS, "integral_gain": 1.7, "curve": TABLE}),
    ("turning friction", SpatialTurningFriction, {"axis": AXIS, "level": 1.3, "width": 0.7, "curve": SINE}),
    ("sliding friction", SpatialSlidingFriction, {"axis": AXIS, "level": 1.3, "width": 0.7, "curve": SUM}),
]
"""Name, kind, numbers; bodies and points come from a grip."""

GRIPS = {
    "rod on ground": (("rod", "ground"), ("A", "O"), "A"),
    "block on wheel": (("block", "wheel"), ("C", "B"), "B"),
    "rubber on rod": (("block of rubber", "rod"), ("V", "B"), "V"),
    "flexible bodies": (("strip", "flag"), ("T", "S"), ("T", "S")),
    "sled on grounded flexible": (("sled", "mast"), ("C", "R"), "R"),
    "ground on turning flexible": (("ground", "arm"), ("O", "Q"), "Q"),
    "anchor on moving flexible": (("anchor", "strip"), ("B", "U"), "U"),
}
"""Bodies a and b, a point on each, and the point where they meet: all frames there are, of rigid and of flexible bodies."""


@dataclass(frozen=True)
class SpatialCase:
    """A scene of one component and the bodies that it grips."""

    name: str
    kind: type[Component] | type[Pressure] | None
    numbers: dict[str, Any]
    bodies: tuple[str, str]
    points: tuple[str, str]
    common: Place

    def scene(self, directory: Path) -> Scene:
        """The scene, with its reduced models in `directory` (see `write_models`)."""
        joints: dict[str, Any] = {}
        loads: dict[str, Any] = {"gravity": SpatialGravity(acceleration=(0.4, -1.3, 0.8))}
        if self.kind is not None:
            group = joints if issubclass(self.kind, Joint) else loads
            group["component"] = self.kind(**self.places(), **self.numbers)
        bodies = {name: body for name, body in all_bodies().items() if name in self.bodies}
        parts: dict[str, Any] = {"points": points(bodies), "bodies": bodies, "joints": joints, "loads": loads}
        return Scene(units="m-kg-s", dimension=3, directory=directory, **parts)

    def places(self) -> dict[str, Any]:
        """Bodies and points as the component's keys have them."""
        fields = self.kind.model_fields if self.kind else {}
        first, second = self.bodies if self.bodies[0] != "ground" else self.bodies[::-1]
        one = bool(self.kind) and "point" in fields and fields["point"].annotation is str
        known = {
            "bodies": self.bodies,
            "points": self.points,
            "point": on_both(self.common)[0] if one else self.common,
            "body": first,
            "reaction": second,
        }
        return {name: value for name, value in known.items() if name in fields}


def all_bodies() -> dict[str, Any]:
    """Every kind of body with every kind of frame; parameters have their nominal values, where all derivatives are known."""
    tensor, turned = (0.6, 0.9, 0.7, 0.1, -0.2, 0.15), (0.3, -0.5, 0.7)
    return {
        "rod": SpatialRod(between=("A", "B"), area=0.8, density=1.2, angular_velocity=(0.1, -0.2, 0.3)),
        "block": SpatialRigid(mass=1.4, inertia=tensor, center="C", origin="B", velocity=(0.1, 0.2, -0.4)),
        "sled": SpatialRigid(mass=1.1, inertia=tensor, center="C", frame="translating"),
        "wheel": SpatialRigid(mass=0.9, inertia=tensor, center="C", frame="turning", axis=(0.2, 1.0, 0.4), origin="A"),
        "anchor": SpatialRigid(mass=0.9, inertia=(1.0, 1.0, 1.0), center="A", frame="grounded"),
        "strip": SpatialFlexible(
            model="frame.h5", frame="moving", position=(-0.4, 0.5, 0.2), orientation=turned, angular_velocity=(0.3, 0.1, 0.2)
        ),
        "flag": SpatialFlexible(model="frame.h5", frame="translating", position=(0.3, -0.2, 0.1), orientation=turned),
        "arm": SpatialFlexible(
            model="frame.h5",
            frame="turning",
            axis=(0.0, 0.6, 1.0),
            position=(0.1, 0.2, 0.0),
            orientation=turned,
            density_stuff=0.9,
        ),
        "mast": SpatialFlexible(model="frame.h5", frame="grounded", position=(0.5, 0.4, -0.3), orientation=turned, width_bar=0.5),
        "block of rubber": SpatialFlexible(
            model="solid.h5", frame="moving", position=(0.2, -0.1, 0.3), orientation=turned, youngs_modulus=1.3
        ),
        "fixed rubber": SpatialFlexible(model="solid.h5", frame="grounded", position=(0.2, -0.1, 0.3), orientation=turned),
    }


def points(bodies: dict[str, Any]) -> dict[str, Any]:
    """Points of the scene; interface points only of the bodies that it has."""
    free = {"O": (0.1, 0.2, -0.3), "A": (1.0, 0.3, 0.2), "B": (2.0, 1.1, -0.4), "C": (1.6, -0.4, 0.5)}
    given: dict[str, Any] = {name: Point(x=x, y=y, z=z) for name, (x, y, z) in free.items()}
    interfaces = {
        "S": ("flag", "end"), "T": ("strip", "middle"), "U": ("strip", "end"), "Q": ("arm", "end"), "R": ("mast", "end"),
        "V": ("block of rubber", "tip"), "W": ("fixed rubber", "tip"),
    }  # fmt: skip
    return given | {name: BodyPoint(body=b, interface=i) for name, (b, i) in interfaces.items() if b in bodies}


FRAME = """units = "m-kg-s"
clamp = ["A"]
nodes = { A = [0.0, 0.0, 0.0], B = [0.7, 0.1, -0.2], C = [0.8, 0.9, 0.3] }
beams = [{ from = "A", to = "B", section = "bar", elements = 1 }, { from = "B", to = "C", section = "pipe", elements = 1 }]
damping = { mass = 0.2, stiffness = 0.3 }
interface_points = { middle = { node = "B" }, end = { node = "C" } }

[sections]
bar = { kind = "rectangle", thickness = 0.2, width = 0.5, material = "stuff" }
pipe = { kind = "tube", diameter = 0.3, wall = 0.05, material = "stuff" }

[materials]
stuff = { youngs_modulus = 120.0, poisson_ratio = 0.3, density = 0.9 }
"""


def write_models(directory: Path) -> None:
    """The flexible bodies of all cases, with numbers of order one: a bent frame of two beams, and a brick of one element."""
    write_once(directory, write_models, _build_models)


def _build_models(directory: Path) -> None:
    (directory / "frame.toml").write_text(FRAME)
    save(build(directory / "frame.toml"), directory / "frame.h5")
    top = "[pressure_surfaces.top]\nbox = [0.0, -0.25, 0.2, 2.0, 0.25, 0.2]"
    brick = write_body(directory, box("hexahedron", (1, 1, 1), (2.0, 0.5, 0.4)), more=top)
    values = {"youngs_modulus": 1.3, "density": 0.8, "damping_stiffness": 0.2}
    save(build(brick, values=values), directory / "solid.h5")


def _cases() -> list[SpatialCase]:
    """Every component on two grips of its own: over the list all of them come up with each other."""
    alone = [("rod", "flag"), ("block", "strip"), ("wheel", "arm"), ("sled", "mast"), ("block of rubber", "fixed rubber")]
    cases = [SpatialCase(f"{a} and {b} alone", None, {}, (a, b), ("A", "C"), "A") for a, b in alone]
    names = list(GRIPS)
    for k, (name, kind, numbers) in enumerate(KINDS):
        for grip in dict.fromkeys((names[k % len(names)], names[(3 * k + 1) % len(names)])):
            bodies, places, common = GRIPS[grip]
            cases.append(SpatialCase(f"{name}: {grip}", kind, numbers, bodies, places, common))
    surfaces = [("block of rubber", "moving"), ("fixed rubber", "grounded")]
    numbers = {"surface": "top", "pressure": 0.7, "curve": SUM}
    return cases + [
        SpatialCase(f"pressure: {frame}", Pressure, numbers, (body, "rod"), ("A", "B"), "A") for body, frame in surfaces
    ]


CASES = _cases()
