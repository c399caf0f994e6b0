"""Links of random scenes in space: bodies between two places, and what ties, pushes and watches them."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.random_scenes.draft import Draft
from tests.random_scenes.models import PERIODS, SPATIAL, local_places, model_file
from tests.random_scenes.planar_links import Link
from toolkit.components.bodies.flexible import SpatialFlexible
from toolkit.components.bodies.rigid import SpatialRigid, SpatialRod
from toolkit.components.joints.cylindrical import Cylindrical
from toolkit.components.joints.distance import SpatialDistance
from toolkit.components.joints.prismatic import Prismatic
from toolkit.components.joints.revolute import SpatialRevolute
from toolkit.components.joints.rigid_joint import SpatialRigidJoint
from toolkit.components.joints.spherical import Spherical
from toolkit.components.joints.universal import Universal
from toolkit.components.loads.gravity import SpatialGravity
from toolkit.components.loads.point_force import SpatialPointForce
from toolkit.components.loads.springs import SpatialRotationalSpringDamper, SpatialSpringDamper
from toolkit.components.loads.torque import SpatialTorque
from toolkit.foundation.kinematics.orientation import matrix_of, quaternion_of
from toolkit.responses.energy import KineticEnergy, StrainEnergy
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Displacement, Rotation
from toolkit.responses.over_time import TimeIntegral
from toolkit.responses.stress import KSStress, MaxStress

ALONG = (Cylindrical, Prismatic)
"""Joints along which a body may slide away."""


def weight(d: Draft, probability: float = 0.8) -> None:
    """Gravity in some direction."""
    if d.draw.chance(probability):
        d.loads["weight"] = SpatialGravity(acceleration=(0.0, 0.0, -9.81) if d.draw.chance(0.6) else d.draw.vector(9.81, 3))
        d.vary("loads.weight.acceleration.z")


def inertia(d: Draft, mass: float) -> tuple[float, ...]:
    """A body's moments of inertia: those of a box, in axes of its own or with products."""
    a, b, c = (d.draw.about(0.05, 0.4) ** 2 for _ in range(3))
    tensor = np.diag([b + c, a + c, a + b]) * mass / 12
    turn = matrix_of(quaternion_of(np.array(d.draw.vector(1.5, 3)))) if d.draw.chance(0.6) else np.eye(3)
    full = turn @ tensor @ turn.T
    return tuple(float(f"{full[k]:.4g}") for k in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)))


def link(
    d: Draft,
    name: str,
    start: str,
    direction: Any,
    kinds: tuple[str, ...] = ("rod", "rigid", "rigid", "flexible"),
    length: float | None = None,
) -> Link:
    """A new body from a point in about a direction."""
    kind = d.draw.one(kinds)
    if kind == "flexible":
        return flexible(d, name, start)
    way = np.array(direction) / np.linalg.norm(direction) * (length or d.draw.about(0.3, 0.9))
    end = d.point(d.places[start] + way)
    if kind == "rod":
        area, density = d.draw.about(1e-4, 1e-3), d.draw.one((1200.0, 2700.0, 7800.0))
        d.bodies[name] = SpatialRod(between=(start, end), area=area, density=density)
        d.vary(f"bodies.{name}.density")
    else:
        centre, mass = d.point((d.places[start] + d.places[end]) / 2 + d.draw.vector(0.08, 3)), d.draw.about(0.1, 3.0)
        origin = {"origin": start} if d.draw.chance(0.3) else {}
        d.bodies[name] = SpatialRigid(mass=mass, inertia=inertia(d, mass), center=centre, **origin)
        d.vary(f"bodies.{name}.mass", f"points.{centre}.y")
    return Link(name, start, end)


def flexible(
    d: Draft, name: str, start: str, frame: str = "moving", models: tuple[str, ...] = tuple(SPATIAL), **given: Any
) -> Link:
    """A flexible body with its start at a point."""
    model, orientation = d.draw.one(models), d.draw.vector(1.2, 3)
    file = model_file(d.directory, model)
    places, turn = local_places(d.directory / file), matrix_of(quaternion_of(np.array(orientation)))
    first = "start" if "start" in places else "hub"
    last = "end" if "end" in places else "tip"
    position = d.places[start] - turn @ places[first]
    d.bodies[name] = SpatialFlexible(
        model=file, frame=frame, position=tuple(map(float, position)), orientation=orientation, **given
    )
    d.faster(PERIODS[model])
    quantities = ("density", "youngs_modulus") if model == "block" else ("density_plastic", "youngs_modulus_plastic")
    d.vary(*(f"bodies.{name}.{quantity}" for quantity in quantities))
    ends = [d.interface(name, place, position + turn @ places[place]) for place in (first, last)]
    return Link(name, ends[0], ends[1])


def tie(d: Draft, before: Link, now: Link, kind: Any = None, name: str = "") -> Link:
    """Ties a link to the end of the one before, by a joint of this kind or by any; returns the link."""
    open_kinds = (Spherical, Spherical, SpatialRevolute, SpatialRevolute, SpatialRevolute, Universal, *ALONG, SpatialDistance)
    kind = kind or d.draw.one(open_kinds if before.body == "ground" else (*open_kinds, SpatialRigidJoint))
    name = name or f"J{len(d.joints)}"
    bodies, point = (now.body, before.body), before.end if now.start == before.end else (now.start, before.end)
    if kind is SpatialDistance:
        place = d.point(d.places[before.end] + d.draw.vector(0.5, 3))
        d.joints[name] = SpatialDistance(bodies=bodies, points=(now.start, place))
    elif kind is Universal:
        first, other = np.array(d.draw.vector(1.0, 3)), np.array(d.draw.vector(1.0, 3))
        d.joints[name] = Universal(bodies=bodies, point=point, axes_of_cross=(_triple(first), _triple(np.cross(first, other))))
    elif kind in (Spherical, SpatialRigidJoint):
        d.joints[name] = kind(bodies=bodies, point=point)
    else:
        d.joints[name] = kind(bodies=bodies, point=point, axis=d.draw.vector(1.0, 3))
    if kind in ALONG:
        _hold(d, name, now, before)
    if kind is SpatialRevolute and d.draw.chance(0.3):
        stiffness = d.draw.about(2.0, 60.0)
        d.loads[f"coil_{name}"] = SpatialRotationalSpringDamper(
            bodies=bodies, point=point, axis=d.joints[name].axis, stiffness=stiffness, damping=0.02 * stiffness
        )
        d.vary(f"loads.coil_{name}.stiffness")
    torques = ("torque-x", "torque-y", "torque-z") if kind in (SpatialRevolute, Prismatic, SpatialRigidJoint) else ()
    d.ask(**{f"force_{name}": JointForce(joint=name, component=d.draw.one(("x", "y", "z", "magnitude", "magnitude", *torques)))})
    return now


def _triple(vector: np.ndarray) -> tuple[float, ...]:
    return tuple(map(float, vector))


def _hold(d: Draft, name: str, now: Link, before: Link) -> None:
    """A spring along a guide, so that nothing slides away."""
    stiffness = d.draw.about(20.0, 400.0)
    given = {"stiffness": stiffness, "damping": d.draw.about(0.01, 1.0) * float(np.sqrt(stiffness))}
    place = d.point(d.places[before.end] + d.draw.vector(0.6, 3))
    d.loads[f"hold_{name}"] = SpatialSpringDamper(bodies=(now.body, before.body), points=(now.start, place), **given)
    d.vary(f"loads.hold_{name}.stiffness")


def whirl(d: Draft, centre: np.ndarray, omega: np.ndarray) -> None:
    """All bodies turn about a place with one angular velocity, as joints allow."""
    for name, body in d.bodies.items():
        if isinstance(body, SpatialFlexible):
            place = np.array(body.position)
        elif body.origin is not None:
            place = d.places[body.origin]
        elif isinstance(body, SpatialRod):
            place = (d.places[body.between[0]] + d.places[body.between[1]]) / 2
        else:
            place = d.places[body.center]
        given = {"velocity": _triple(np.cross(omega, place - centre)), "angular_velocity": _triple(omega)}
        d.bodies[name] = body.model_copy(update=given)


def pushes(d: Draft, probability: float) -> None:
    """Forces, torques and springs on some of the bodies."""
    for name, body in list(d.bodies.items()):
        if not d.draw.chance(probability):
            continue
        point, (mass, turning) = end_of(d, name, body), sluggishness(d, body)
        kind = d.draw.one(("torque", "force", "spring") if turning else ("force", "spring"))
        frame: Any = d.draw.one(("space", "body"))
        given: dict[str, Any] = {"body": name, "point": point, "frame": frame}
        if kind == "torque":
            curve = d.draw.load_curve(d.period)
            d.loads[f"push_{name}"] = SpatialTorque(
                torque=d.draw.vector(d.draw.about(1.0, 15.0) * turning, 3), curve=curve, **given
            )
            d.vary(f"loads.push_{name}.torque.x")
        elif kind == "force":
            curve = d.draw.load_curve(d.period)
            d.loads[f"push_{name}"] = SpatialPointForce(
                force=d.draw.vector(d.draw.about(0.5, 6.0) * mass, 3), curve=curve, **given
            )
            d.vary(f"loads.push_{name}.force.z")
        else:
            anchor, stiffness = d.point(d.places[point] + d.draw.vector(0.8, 3)), d.draw.about(2.0, 100.0)
            d.loads[f"push_{name}"] = SpatialSpringDamper(
                bodies=(name, "ground"), points=(point, anchor), stiffness=stiffness, damping=0.01 * stiffness
            )
            d.vary(f"loads.push_{name}.stiffness")


def sluggishness(d: Draft, body: Any) -> tuple[float, float]:
    """Mass, and the least moment of inertia; zero of a body that is so slender that a torque would spin it beyond all measure."""
    if isinstance(body, SpatialRigid):
        return body.mass, min(body.inertia[:3]) / 2
    if isinstance(body, SpatialRod):
        return body.area * body.density * float(np.linalg.norm(d.places[body.between[1]] - d.places[body.between[0]])), 0.0
    return 0.7, 0.0


def end_of(d: Draft, name: str, body: Any) -> str:
    """A point of the body, away from its centre where it has one."""
    if isinstance(body, SpatialRod):
        return str(body.between[1])
    if isinstance(body, SpatialRigid):
        return d.point(d.places[body.center] + d.draw.vector(0.15, 3))
    return [point for point, at in d.points.items() if getattr(at, "body", None) == name][-1]


def answers(d: Draft) -> None:
    """Everything that can be asked of the scene."""
    d.ask(energy=KineticEnergy(), work=TimeIntegral(of=KineticEnergy()))
    for name, body in d.bodies.items():
        point = end_of(d, name, body)
        component: Any = d.draw.one(("x", "y", "z", "magnitude"))
        d.ask(**{f"way_{name}": Displacement(body=name, point=point, component=component)})
        if body.turns:
            axis = body.axis or d.draw.vector(1.0, 3)
            d.ask(**{f"turn_{name}": Rotation(body=name, point=point, axis=axis)})
        if isinstance(body, SpatialFlexible):
            stress: Any = {f"stress_{name}": MaxStress(body=name)}
            smooth: Any = {f"smooth_{name}": KSStress(body=name, aggregation=2000.0, reference_stress=1e5)}
            d.ask(strain=StrainEnergy(), **stress, **smooth)
