"""A planar scene rebuilt in space: the same bodies in the plane z = 0, with the coordinates of space.

No constraint is redundant: every body gets the rows that hold it in the plane (z, rotation about x and y) from the first joint that ties it
to a body that is held already, a hinge about z or a rigid joint. A joint that closes a loop has the two directions of the plane
alone, as two points on planes. The motion of the plane is that of the planar scene, so are the forces of the joints.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.components.bodies.body import Body, Placed, StartVelocity
from toolkit.components.bodies.flexible import Flexible, SpatialFlexible
from toolkit.components.bodies.rigid import Rigid, Rod, SpatialRigid, SpatialRigidBody
from toolkit.components.joints.distance import Distance, SpatialDistance
from toolkit.components.joints.driver import AngleDriver, SpatialAngleDriver
from toolkit.components.joints.joint import Joint
from toolkit.components.joints.point_on_plane import PointOnPlane
from toolkit.components.joints.prismatic import Prismatic
from toolkit.components.joints.revolute import Revolute, SpatialRevolute
from toolkit.components.joints.rigid_joint import RigidJoint, SpatialRigidJoint
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.gravity import Gravity, SpatialGravity
from toolkit.components.loads.point_force import PointForce, SpatialPointForce
from toolkit.components.loads.springs import SpatialSpringDamper, SpringDamper
from toolkit.components.loads.torque import SpatialTorque, Torque
from toolkit.description.description import Positive
from toolkit.description.design import Point
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution

Z = (0.0, 0.0, 1.0)
CLOSING = ("x", "y")
"""What the two joints that close a loop are called, after the planar joint's own name."""


class FlatRod(SpatialRigidBody):
    """The rod of the plane: m L^2 / 12 along it and nothing across it in the plane; out of the plane as much as along it."""

    between: tuple[str, str]
    area: Positive
    density: Positive

    def named_points(self) -> tuple[str, ...]:
        return self.between

    def mass_properties(self, scene: Placed) -> tuple[Any, np.ndarray, np.ndarray]:
        start, end = (scene.position(point) for point in self.between)
        along, square = np.outer(end - start, end - start), (end - start) @ (end - start)
        mass = self.density * self.area * np.sqrt(square)
        return mass, (start + end) / 2, mass / 12 * (along + square * np.diag(Z))


def in_space(scene: Scene, models: dict[str, str] | None = None, **changes: Any) -> Scene:
    """The planar scene in space.

    Parameters
    ----------
    models : planar reduced model -> spatial one
    changes : other parts of the new scene, for example `directory`
    """
    points = {
        name: Point(x=point.x, y=point.y, z=0.0) if isinstance(point, Point) else point for name, point in scene.points.items()
    }
    bodies = {name: body_in_space(body, models or {}) for name, body in scene.bodies.items()}
    loads = {name: load_in_space(load) for name, load in scene.loads.items()}
    kept = {"units": scene.units, "directory": scene.directory, "solver": scene.solver}
    return Scene(
        **{
            **kept,
            "dimension": 3,
            "points": points,
            "bodies": bodies,
            "joints": joints_in_space(scene),
            "loads": loads,
            **changes,
        }
    )


def body_in_space(body: Body, models: dict[str, str]) -> Body:
    if isinstance(body, Flexible):
        return SpatialFlexible(
            model=models[body.model], frame=body.frame, position=(*body.position, 0.0), orientation=(0.0, 0.0, body.angle),
            **motion_in_space(body), **body.model_values(),
        )  # fmt: skip
    assert isinstance(body, (Rigid, Rod))
    motion = motion_in_space(body)
    if isinstance(body, Rod):
        return FlatRod(between=body.between, area=body.area, density=body.density, **motion)
    return SpatialRigid(mass=body.mass, inertia=(body.inertia,) * 3, center=body.center, **motion)


def motion_in_space(body: StartVelocity) -> dict[str, Any]:
    """What is written of the start in the plane, and no more."""
    v_x, v_y, omega = map(float, body.frame_velocity())
    written = {"velocity": (v_x, v_y, 0.0)} if body.velocity is not None else {}
    return written | ({"angular_velocity": (0.0, 0.0, omega)} if body.written_velocities() else {})


def joints_in_space(scene: Scene) -> dict[str, Joint]:
    """In the order of the planar ones, as far as it is the order in which bodies get held."""
    held = {"ground", *(name for name, body in scene.bodies.items() if isinstance(body, Flexible) and body.frame == "grounded")}
    flexible = {name for name, body in scene.bodies.items() if isinstance(body, Flexible)}
    waiting, found = dict(scene.joints), {}
    while waiting:
        name = next((name for name, joint in waiting.items() if held & {*joint.bodies} or isinstance(joint, Distance)))
        joint = waiting.pop(name)
        # a flexible body can be held in the plane at as many points as it likes
        closes = held.issuperset(joint.bodies) and not flexible & {*joint.bodies}
        found |= joint_in_space(name, joint, closes)
        held |= set() if isinstance(joint, (Distance, Slider)) else {*joint.bodies}
    return found


def joint_in_space(name: str, joint: Joint, closes: bool) -> dict[str, Joint]:
    both = {"bodies": joint.bodies}
    if isinstance(joint, Revolute) and closes:
        return {
            f"{name}_{axis}": PointOnPlane(**both, point=joint.point, axis=direction)
            for axis, direction in zip(CLOSING, ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), strict=True)
        }
    if isinstance(joint, Revolute):
        return {name: SpatialRevolute(**both, point=joint.point, axis=Z)}
    if isinstance(joint, RigidJoint) and not closes:
        return {name: SpatialRigidJoint(**both, point=joint.point)}
    if isinstance(joint, Slider) and joint.lock_rotation:
        return {name: Prismatic(**both, point=joint.point, axis=(*joint.axis, 0.0))}
    if isinstance(joint, Slider):
        return {name: PointOnPlane(**both, point=joint.point, axis=(-joint.axis[1], joint.axis[0], 0.0))}
    if isinstance(joint, Distance):
        return {name: SpatialDistance(**both, points=joint.points, length=joint.length)}
    assert isinstance(joint, AngleDriver)
    return {name: SpatialAngleDriver(**both, point=joint.point, axis=Z, curve=joint.curve)}


def load_in_space(load: Any) -> Any:
    if isinstance(load, Gravity):
        return SpatialGravity(acceleration=(*load.acceleration, 0.0))
    if isinstance(load, Torque):
        return SpatialTorque(
            body=load.body, point=load.point, torque=(0.0, 0.0, load.torque), curve=load.curve, reaction=load.reaction
        )
    if isinstance(load, SpringDamper):
        return SpatialSpringDamper(**dict(load))
    assert isinstance(load, PointForce)
    return SpatialPointForce(**{**dict(load), "force": (*load.force, 0.0)})


def angle(run: Solution, body: str) -> np.ndarray:
    """Rotation of a body about z at all times, (n_t,); of any number of turns."""
    at = run.coordinates(body).start
    if run.system.scene.dimension == 2:
        return run.q[:, at + 2]
    return np.unwrap(2 * np.arctan2(run.q[:, at + 6], run.q[:, at + 3]), period=2 * np.pi)


def angle_rates(run: Solution, body: str, what: str = "dq") -> np.ndarray:
    """Its design derivatives (n_t, n_x); with `what` "v" its rate (n_t,)."""
    at, change = run.coordinates(body).start, getattr(run, what)
    if run.system.scene.dimension == 2:
        return change[:, at + 2]
    cosine, sine = (run.q[:, at + k].reshape(-1, *[1] * (change.ndim - 2)) for k in (3, 6))
    return 2 * (cosine * change[:, at + 6] - sine * change[:, at + 3])


def place(run: Solution, body: str) -> np.ndarray:
    """x and y of the frame, (n_t, 2)."""
    at = run.coordinates(body).start
    return run.q[:, at : at + 2]


def force(run: Solution, joint: str) -> np.ndarray:
    """Multipliers of a hinge along x and y, (n_t, 2)."""
    scene, row, n_q = run.system.scene, run.system.numbering.row, run.system.n_q
    if joint in scene.joints:
        return run.multipliers[:, row[joint] - n_q : row[joint] - n_q + 2]
    own = np.stack([run.multipliers[:, row[f"{joint}_{axis}"] - n_q] for axis in CLOSING])
    second = scene.joints[f"{joint}_{CLOSING[0]}"].bodies[1]
    turned = 0 * own[0] if second == "ground" else angle(run, second)
    return np.stack(
        [np.cos(turned) * own[0] - np.sin(turned) * own[1], np.sin(turned) * own[0] + np.cos(turned) * own[1]], axis=1
    )
