"""Random scenes in the plane, by their kind."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.random_scenes.draft import Draft
from tests.random_scenes.models import PERIODS, PLANAR, local_places, model_file
from tests.random_scenes.planar_links import Link, answers, hinge, link, pushes, whirl
from toolkit.components.bodies.flexible import Flexible
from toolkit.components.bodies.rigid import Rigid
from toolkit.components.joints.distance import Distance
from toolkit.components.joints.driver import AngleDriver, PositionDriver
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.rigid_joint import RigidJoint
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.point_force import PointForce
from toolkit.components.loads.springs import RotationalSpringDamper, SpringDamper
from toolkit.components.loads.torque import Torque

SWING = 1.3
"""Period of a hanging link, s."""


def weight(d: Draft, probability: float = 0.8) -> None:
    """Gravity, mostly downwards."""
    if d.draw.chance(probability):
        down = (0.0, -9.81) if d.draw.chance(0.6) else d.draw.vector(9.81, 2)
        d.loads["weight"] = Gravity(acceleration=down)
        d.vary("loads.weight.acceleration.y")


def chain(d: Draft) -> None:
    """Links that hang from each other, from the ground, by all joints."""
    d.faster(SWING)
    weight(d, 0.9)
    place = d.point((0.0, 0.0))
    before = Link("ground", place, place)
    angle = d.draw.between(-2.5, 0.5)
    for k in range(d.draw.count(1, 4)):
        angle += d.draw.between(-1.2, 1.2)
        before = hinge(d, before, link(d, f"link{k}", before.end, angle))
        if d.draw.chance(0.25):
            stiffness = d.draw.about(2.0, 60.0)
            given = {
                "stiffness": stiffness,
                "damping": d.draw.about(0.003, 0.1) * stiffness,
                "rest_angle": d.draw.between(-0.5, 0.5),
            }
            bodies, point = d.joints[f"J{k}"].bodies, getattr(d.joints[f"J{k}"], "point", None)
            if point is not None:
                d.loads[f"coil{k}"] = RotationalSpringDamper(bodies=bodies, point=point, **given)
                d.vary(f"loads.coil{k}.stiffness")
    if all(isinstance(joint, (Revolute, RigidJoint)) for joint in d.joints.values()) and d.draw.chance(0.6):
        whirl(d, d.places[place], d.draw.between(-6.0, 6.0))
    pushes(d, 0.5)
    answers(d)


def loop(d: Draft) -> None:
    """Four or more bars in a loop, driven by a torque, a driver, or their weight."""
    d.faster(SWING)
    weight(d, 0.7)
    place, angle = d.point((0.0, 0.0)), d.draw.between(0.6, 2.5)
    before = ground = Link("ground", place, place)
    before = hinge(d, before, link(d, "crank", place, angle, ("rod", "rigid"), length=d.draw.between(0.2, 0.4)), Revolute)
    before = hinge(d, before, link(d, "coupler", before.end, d.draw.between(-0.4, 0.5)), Revolute)
    if d.draw.chance(0.2):
        before = hinge(d, before, link(d, "second", before.end, d.draw.between(-0.9, -0.2)), Revolute)
        d.loads["brace"] = SpringDamper(bodies=("second", "ground"), points=(before.end, place), stiffness=40.0, damping=1.0)
    foot = d.point(d.places[before.end] + (d.draw.between(-0.1, 0.4), d.draw.between(-0.8, -0.4)))
    if d.draw.chance(0.25):
        d.joints["bar"] = Distance(bodies=(before.body, "ground"), points=(before.end, foot))
        d.ask(bar=_force(d, "bar"))
    else:
        rocker = link(d, "rocker", foot, 0.0, ("rod",), target=before.end)
        hinge(d, Link("ground", foot, foot), rocker, Revolute, "foot")
        hinge(d, before, Link("rocker", before.end, before.end), Revolute, "last")
    _drive(d, "crank", ground.end)
    answers(d)


def crank_slider(d: Draft) -> None:
    """A crank that turns, a rod, and a block on a guide."""
    d.faster(d.draw.about(0.3, 2.0))
    weight(d, 0.5)
    place, angle = d.point((0.0, 0.0)), d.draw.between(0.3, 2.8)
    crank = link(d, "crank", place, angle, ("rod", "rigid"), length=d.draw.between(0.1, 0.3))
    before = hinge(d, Link("ground", place, place), crank, Revolute)
    before = hinge(d, before, link(d, "rod", before.end, d.draw.between(-0.4, 0.1)), Revolute)
    centre = d.point(d.places[before.end] + (d.draw.between(-0.05, 0.05), d.draw.between(-0.05, 0.05)))
    d.bodies["block"] = Rigid(mass=d.draw.about(0.2, 3.0), inertia=d.draw.about(0.001, 0.02), center=centre)
    d.vary("bodies.block.mass")
    d.joints["pin"] = Revolute(bodies=("block", before.body), point=before.end)
    axis = (1.0, d.draw.between(-0.3, 0.3))
    d.joints["guide"] = Slider(bodies=("block", "ground"), point=before.end, axis=axis, lock_rotation=True)
    if d.draw.chance(0.5):
        anchor = d.point(d.places[before.end] + (0.5, 0.1))
        stiffness = d.draw.about(20.0, 2000.0)
        d.loads["spring"] = SpringDamper(
            bodies=("block", "ground"), points=(before.end, anchor), stiffness=stiffness, damping=0.004 * stiffness
        )
        d.vary("loads.spring.stiffness", "loads.spring.damping")
    d.ask(guide=_force(d, "guide"), pin=_force(d, "pin"))
    _drive(d, "crank", place, turns=True)
    answers(d)


def structure(d: Draft) -> None:
    """Grounded flexible bodies with masses, tied to each other or to springs, under loads."""
    d.at_rest = True
    weight(d, 0.5)
    ends = []
    for k in range(d.draw.count(1, 2)):
        name, model = f"beam{k}", d.draw.one(("straight", "bent", "modes", "craig"))
        file = model_file(d.directory, model)
        position, angle = (0.0, -0.9 * k), d.draw.between(-0.5, 0.5)
        d.bodies[name] = Flexible(model=file, frame="grounded", position=position, angle=angle)
        d.faster(PERIODS[model])
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        ends.append(d.interface(name, "end", position + turn @ local_places(d.directory / file)["end"]))
        d.vary(*(f"bodies.{name}.{parameter}" for parameter in ("thickness", "youngs_modulus", "density")))
    if len(ends) == 2:
        if d.draw.chance(0.5):
            d.joints["bar"] = Distance(bodies=("beam0", "beam1"), points=(ends[0], ends[1]))
            d.ask(bar=_force(d, "bar"))
        else:
            stiffness = d.draw.about(10.0, 500.0)
            given = {"stiffness": stiffness, "damping": 0.003 * stiffness}
            d.loads["spring"] = SpringDamper(bodies=("beam0", "beam1"), points=(ends[0], ends[1]), **given)
            d.vary("loads.spring.stiffness")
    if d.draw.chance(0.5):
        d.bodies["mass"] = Rigid(
            mass=d.draw.about(0.05, 0.5), inertia=d.draw.about(1e-4, 1e-3), center=d.point(d.places[ends[0]] + 0.02)
        )
        kind = d.draw.one((RigidJoint, RigidJoint, Revolute))
        d.joints["glue"] = kind(bodies=("mass", "beam0"), point=ends[0])
        if kind is Revolute:
            coil = RotationalSpringDamper(
                bodies=("mass", "beam0"), point=ends[0], stiffness=d.draw.about(1.0, 10.0), damping=0.01
            )
            d.loads["coil"] = coil
        d.ask(glue=_force(d, "glue"))
        d.vary("bodies.mass.mass")
    kind = d.draw.one(("force", "follower", "torque"))
    curve = d.draw.load_curve(d.period)
    if kind == "torque":
        d.loads["load"] = Torque(body="beam0", point=ends[0], torque=d.draw.about(0.3, 3.0), curve=curve)
        d.vary("loads.load.torque")
    else:
        frame: Any = "space" if kind == "force" else "body"
        d.loads["load"] = PointForce(
            body="beam0", point=ends[0], force=d.draw.vector(d.draw.about(0.5, 4.0), 2), frame=frame, curve=curve
        )
        d.vary("loads.load.force.y")
    answers(d)


def free(d: Draft) -> None:
    """Bodies that nothing holds, thrown, pushed, and tied by springs."""
    d.faster(d.draw.about(0.5, 2.0))
    weight(d, 0.4)
    ends: list[Link] = []
    for k in range(d.draw.count(1, 3)):
        start = d.point((1.2 * k, d.draw.between(-0.2, 0.2)))
        ends.append(link(d, f"body{k}", start, d.draw.between(-3.0, 3.0)))
        velocity = (*d.draw.vector(1.0, 2), d.draw.between(-8.0, 8.0))
        d.bodies[f"body{k}"] = d.bodies[f"body{k}"].model_copy(update={"velocity": velocity})
        d.vary(f"bodies.body{k}.velocity.2", f"bodies.body{k}.velocity.0")
    for k in range(len(ends) - 1):
        stiffness = d.draw.about(5.0, 500.0)
        d.loads[f"spring{k}"] = SpringDamper(
            bodies=(ends[k].body, ends[k + 1].body),
            points=(ends[k].end, ends[k + 1].start),
            stiffness=stiffness,
            damping=d.draw.about(1e-3, 1e-1) * np.sqrt(stiffness),
        )
        d.faster(2 * np.pi / np.sqrt(2 * stiffness))
        d.vary(f"loads.spring{k}.stiffness")
    pushes(d, 0.6)
    answers(d)


def cart(d: Draft) -> None:
    """A cart on a rail, led or on a spring, with links that hang from it, or a mast that stands on it."""
    d.faster(SWING)
    weight(d, 0.9)
    centre = d.point((0.0, 0.0))
    d.bodies["cart"] = Rigid(mass=d.draw.about(0.5, 4.0), inertia=d.draw.about(0.01, 0.1), center=centre)
    axis = (1.0, d.draw.between(-0.4, 0.4))
    d.joints["rail"] = Slider(bodies=("cart", "ground"), point=centre, axis=axis, lock_rotation=True)
    d.ask(rail=_force(d, "rail"))
    if d.draw.chance(0.6):
        curve = d.draw.driver_curve(d.draw.about(0.05, 0.6), d.period)
        d.joints["lead"] = PositionDriver(bodies=("cart", "ground"), point=centre, axis=axis, curve=curve)
        d.ask(lead=_force(d, "lead"))
    else:
        anchor, stiffness = d.point((-0.8, 0.0)), d.draw.about(5.0, 300.0)
        d.loads["spring"] = SpringDamper(
            bodies=("cart", "ground"), points=(centre, anchor), stiffness=stiffness, damping=0.01 * stiffness
        )
        d.vary("loads.spring.stiffness")
    d.vary("bodies.cart.mass")
    before = Link("cart", centre, centre)
    standing = d.draw.chance(0.3)
    for k in range(1 if standing else d.draw.count(1, 2)):
        angle = d.draw.between(1.2, 2.0) if standing else d.draw.between(-2.8, -0.3)
        kinds = ("flexible",) if standing else ("rod", "rigid", "flexible")
        before = hinge(d, before, link(d, f"link{k}", before.end, angle, kinds), RigidJoint if standing else Revolute)
    pushes(d, 0.3)
    answers(d)


def _drive(d: Draft, body: str, point: str, turns: bool = False) -> None:
    """A torque, a driver, or nothing but what else there is."""
    kind = d.draw.one(("torque", "driver", "driver", "weight"))
    if kind == "torque" or "weight" not in d.loads:
        d.loads["motor"] = Torque(body=body, point=point, torque=d.draw.about(0.3, 4.0), curve=d.draw.load_curve(d.period))
        d.vary("loads.motor.torque")
    if kind == "driver":
        size = d.draw.between(1.0, 12.0) if turns else d.draw.between(0.2, 0.9)
        d.joints["lead"] = AngleDriver(bodies=(body, "ground"), point=point, curve=d.draw.driver_curve(size, d.period))
        d.ask(lead=_force(d, "lead"))


def _force(d: Draft, joint: str) -> Any:
    from toolkit.responses.joint_force import JointForce

    component: Any = "magnitude" if joint != "lead" or d.joints[joint].kind != "angle-driver" else "torque"
    return JointForce(joint=joint, component=component)


KINDS = {"chain": chain, "loop": loop, "crank-slider": crank_slider, "structure": structure, "free": free, "cart": cart}
PLANAR_MODELS = tuple(PLANAR)
