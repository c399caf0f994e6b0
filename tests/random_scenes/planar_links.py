"""Links of random scenes in the plane: bodies between two places, and what ties, pushes and watches them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tests.random_scenes.draft import Draft
from tests.random_scenes.draw import rounded
from tests.random_scenes.models import PERIODS, PLANAR, local_places, model_file
from toolkit.components.bodies.flexible import Flexible
from toolkit.components.bodies.rigid import Rigid, Rod
from toolkit.components.joints.distance import Distance
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.rigid_joint import RigidJoint
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.point_force import PointForce
from toolkit.components.loads.springs import SpringDamper
from toolkit.components.loads.torque import Torque
from toolkit.responses.energy import KineticEnergy, StrainEnergy
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Displacement, Rotation
from toolkit.responses.over_time import TimeIntegral
from toolkit.responses.stress import KSStress, MaxStress


class Link(NamedTuple):
    """A body, and the points where it begins and ends."""

    body: str
    start: str
    end: str


def link(
    d: Draft,
    name: str,
    start: str,
    angle: float,
    kinds: tuple[str, ...] = ("rod", "rod", "rigid", "flexible"),
    length: float | None = None,
    target: str | None = None,
) -> Link:
    """A new body that begins at a point and ends at another, or at a new one in the direction of an angle."""
    kind = d.draw.one(kinds)
    if kind == "flexible":
        return _flexible(d, name, start, angle)
    length = length or d.draw.about(0.3, 0.9)
    end = target or d.point(d.places[start] + length * np.array([np.cos(angle), np.sin(angle)]))
    if kind == "rod":
        area, density = d.draw.about(1e-4, 6e-4), d.draw.one((1200.0, 2700.0, 7800.0))
        d.bodies[name] = Rod(between=(start, end), area=area, density=density)
        d.vary(f"bodies.{name}.density", f"bodies.{name}.area")
    else:
        centre = d.point((d.places[start] + d.places[end]) / 2 + (d.draw.between(-0.1, 0.1), d.draw.between(-0.1, 0.1)))
        mass = d.draw.about(0.1, 3.0)
        d.bodies[name] = Rigid(mass=mass, inertia=float(f"{mass * d.draw.about(0.01, 0.1):.4g}"), center=centre)
        d.vary(f"bodies.{name}.mass", f"bodies.{name}.inertia", f"points.{centre}.x")
    return Link(name, start, end)


def _flexible(d: Draft, name: str, start: str, angle: float) -> Link:
    model = d.draw.one(tuple(PLANAR))
    file = model_file(d.directory, model)
    places = local_places(d.directory / file)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    position = d.places[start] - turn @ places["start"]
    given: dict[str, Any] = {}
    if PLANAR[model][1].kind == "full" and d.draw.chance(0.5):
        given["youngs_modulus"] = d.draw.about(5e8, 1e10)
    d.bodies[name] = Flexible(model=file, frame="moving", position=tuple(map(float, position)), angle=angle, **given)
    d.faster(PERIODS[model] * np.sqrt(2e9 / given.get("youngs_modulus", 2e9)))
    d.vary(*(f"bodies.{name}.{parameter}" for parameter in ("thickness", "youngs_modulus", "density")))
    ends = [d.interface(name, place, position + turn @ places[place]) for place in ("start", "end")]
    return Link(name, ends[0], ends[1])


def hinge(d: Draft, before: Link, now: Link, kind: Any = None, name: str = "") -> Link:
    """Ties a link to the end of the one before, by a joint of this kind or by any; returns the link."""
    kind = kind or d.draw.one((Revolute, Revolute, Revolute, Revolute, RigidJoint, Slider, Distance))
    name = name or f"J{len(d.joints)}"
    if before.body == "ground" and kind is RigidJoint and now.body != "ground":
        kind = Revolute
    bodies, point = (now.body, before.body), before.end if now.start == before.end else (now.start, before.end)
    if kind is Slider:
        d.joints[name] = Slider(bodies=bodies, point=point, axis=d.draw.vector(1.0, 2), lock_rotation=d.draw.chance(0.4))
        _hold(d, name, now, before)
    elif kind is Distance:
        place = d.point(d.places[before.end] + d.draw.vector(0.5, 2))
        d.joints[name] = (
            Distance(bodies=bodies, points=(now.start, place))
            if before.body == "ground"
            else Distance(bodies=(now.body, before.body), points=(now.end, before.start))
        )
    else:
        d.joints[name] = kind(bodies=bodies, point=point)
    d.ask(**{f"force_{name}": JointForce(joint=name, component=d.draw.one(("x", "y", "magnitude", "magnitude")))})
    return now


def _hold(d: Draft, name: str, now: Link, before: Link) -> None:
    """A spring along a slider, so that nothing slides away."""
    stiffness = d.draw.about(20.0, 400.0)
    given = {"stiffness": stiffness, "damping": d.draw.about(0.01, 1.0) * float(np.sqrt(stiffness))}
    place = d.point(d.places[before.end] + d.draw.vector(0.6, 2))
    d.loads[f"hold_{name}"] = SpringDamper(bodies=(now.body, before.body), points=(now.start, place), **given)
    d.vary(f"loads.hold_{name}.stiffness")


def whirl(d: Draft, centre: np.ndarray, omega: float) -> None:
    """All bodies turn about a place with one angular velocity, as joints allow."""
    for name, body in d.bodies.items():
        if isinstance(body, Flexible):
            place = np.array(body.position)
        elif isinstance(body, Rod):
            place = (d.places[body.between[0]] + d.places[body.between[1]]) / 2
        else:
            place = d.places[body.center]
        arm = place - centre
        velocity = (float(-omega * arm[1]), float(omega * arm[0]), omega)
        d.bodies[name] = body.model_copy(update={"velocity": velocity})


def pushes(d: Draft, probability: float) -> None:
    """Forces, torques and springs on some of the bodies."""
    for name, body in list(d.bodies.items()):
        if not d.draw.chance(probability):
            continue
        point, kind = end_of(d, name, body), d.draw.one(("torque", "force", "follower", "spring"))
        mass, inertia = sluggishness(d, body)
        if kind == "torque":
            size = d.draw.about(1.0, 15.0) * inertia
            load: Any = Torque(body=name, point=point, torque=rounded(size), curve=d.draw.load_curve(d.period))
            variable = "torque"
        elif kind == "spring":
            anchor = d.point(d.places[point] + d.draw.vector(0.8, 2))
            stiffness = d.draw.about(2.0, 100.0)
            load = SpringDamper(bodies=(name, "ground"), points=(point, anchor), stiffness=stiffness, damping=0.01 * stiffness)
            variable = "stiffness"
        else:
            frame: Any = "body" if kind == "follower" else "space"
            size = d.draw.about(0.5, 6.0) * mass
            load = PointForce(
                body=name, point=point, force=d.draw.vector(size, 2), frame=frame, curve=d.draw.load_curve(d.period)
            )
            variable = "force.x"
        d.loads[f"push_{name}"] = load
        d.vary(f"loads.push_{name}.{variable}")


def sluggishness(d: Draft, body: Any) -> tuple[float, float]:
    """Mass and moment of inertia, about."""
    if isinstance(body, Rigid):
        return body.mass, body.inertia
    if isinstance(body, Rod):
        length = float(np.linalg.norm(d.places[body.between[1]] - d.places[body.between[0]]))
        mass = body.area * body.density * length
        return mass, mass * length**2 / 12
    return 0.7, 0.06


def end_of(d: Draft, name: str, body: Any) -> str:
    """A point of the body, away from its centre where it has one."""
    if isinstance(body, Rod):
        return body.between[1]
    if isinstance(body, Rigid):
        return d.point(d.places[body.center] + d.draw.vector(0.15, 2))
    return [point for point, at in d.points.items() if getattr(at, "body", None) == name][-1]


def answers(d: Draft) -> None:
    """Everything that can be asked of the scene."""
    d.ask(energy=KineticEnergy(), work=TimeIntegral(of=KineticEnergy()))
    for name, body in d.bodies.items():
        point = end_of(d, name, body)
        component: Any = d.draw.one(("x", "y", "magnitude"))
        d.ask(**{f"way_{name}": Displacement(body=name, point=point, component=component)})
        d.ask(**{f"turn_{name}": Rotation(body=name, point=point)})
        if isinstance(body, Flexible):
            d.ask(strain=StrainEnergy())
            d.ask(
                **{
                    f"stress_{name}": MaxStress(body=name),
                    f"smooth_{name}": KSStress(body=name, aggregation=2000.0, reference_stress=1e5),
                }
            )
