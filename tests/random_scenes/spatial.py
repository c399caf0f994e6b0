"""Random scenes in space, by their kind."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.random_scenes.draft import Draft
from tests.random_scenes.planar import SWING
from tests.random_scenes.planar_links import Link
from tests.random_scenes.spatial_links import answers, flexible, inertia, link, pushes, tie, weight, whirl
from toolkit.components.bodies.rigid import SpatialRigid
from toolkit.components.joints.distance import SpatialDistance
from toolkit.components.joints.driver import SpatialAngleDriver, SpatialPositionDriver
from toolkit.components.joints.point_on_plane import PointOnPlane
from toolkit.components.joints.prismatic import Prismatic
from toolkit.components.joints.revolute import SpatialRevolute
from toolkit.components.joints.rigid_joint import SpatialRigidJoint
from toolkit.components.joints.spherical import Spherical
from toolkit.components.joints.universal import Universal
from toolkit.components.loads.point_force import SpatialPointForce
from toolkit.components.loads.pressure import Pressure
from toolkit.components.loads.springs import SpatialRotationalSpringDamper, SpatialSpringDamper
from toolkit.components.loads.torque import SpatialTorque
from toolkit.responses.joint_force import JointForce


def chain(d: Draft) -> None:
    """Links that hang from each other, from the ground, by all joints."""
    d.faster(SWING)
    weight(d, 0.9)
    place = d.point((0.0, 0.0, 0.0))
    before, direction = Link("ground", place, place), np.array([0.5, 0.2, -1.0])
    for k in range(d.draw.count(1, 3)):
        direction = direction + d.draw.vector(0.9, 3)
        before = tie(d, before, link(d, f"link{k}", before.end, direction))
    if all(isinstance(joint, (Spherical, SpatialRigidJoint)) for joint in list(d.joints.values())[:1]) and d.draw.chance(0.7):
        whirl(d, d.places[place], np.array(d.draw.vector(5.0, 3)))
    pushes(d, 0.5)
    answers(d)


def door(d: Draft) -> None:
    """A body on two hinges, which repeat each other, with a link that hangs from it."""
    d.faster(SWING)
    d.redundant = True
    weight(d, 1.0)
    feet = [d.point((0.0, 0.0, 0.0)), d.point((0.0, 0.2, 0.9))]
    axis = tuple(map(float, d.places[feet[1]] - d.places[feet[0]]))
    centre, mass = d.point((d.draw.between(0.2, 0.6), d.draw.between(-0.2, 0.2), 0.4)), d.draw.about(0.5, 5.0)
    d.bodies["door"] = SpatialRigid(mass=mass, inertia=inertia(d, mass), center=centre)
    d.vary("bodies.door.mass")
    for k, foot in enumerate(feet):
        d.joints[f"hinge{k}"] = SpatialRevolute(bodies=("door", "ground"), point=foot, axis=axis)
        d.ask(**{f"hinge{k}": JointForce(joint=f"hinge{k}", component="magnitude")})
    if d.draw.chance(0.5):
        stiffness = d.draw.about(1.0, 30.0)
        d.loads["coil"] = SpatialRotationalSpringDamper(
            bodies=("door", "ground"), point=feet[0], axis=axis, stiffness=stiffness, damping=0.03 * stiffness
        )
        d.vary("loads.coil.stiffness")
    if d.draw.chance(0.6):
        corner = d.point(d.places[centre] + (0.2, 0.1, -0.3))
        tie(d, Link("door", centre, corner), link(d, "latch", corner, (0.3, 0.1, -1.0)), d.draw.one((Spherical, SpatialRevolute)))
    pushes(d, 0.6)
    answers(d)


def crank(d: Draft) -> None:
    """A crank that turns about an oblique axis pushes a block along a guide."""
    d.faster(d.draw.about(0.5, 2.0))
    weight(d, 0.6)
    foot = d.point((0.0, 0.0, 0.0))
    axis = (d.draw.between(-0.3, 0.3), d.draw.between(-0.3, 0.3), 1.0)
    direction = np.cross(axis, (d.draw.between(-1.0, 1.0), 1.0, 0.3))
    first = link(d, "crank", foot, direction, ("rod", "rigid"), d.draw.between(0.1, 0.25))
    d.joints["hinge"] = SpatialRevolute(bodies=("crank", "ground"), point=foot, axis=axis)
    rod = tie(d, first, link(d, "rod", first.end, (1.0, 0.2, d.draw.between(-0.2, 0.2)), length=0.8), Spherical, "ball")
    if d.draw.chance(0.6):
        curve = d.draw.driver_curve(d.draw.between(0.5, 6.0), d.period)
        d.joints["lead"] = SpatialAngleDriver(bodies=("crank", "ground"), point=foot, axis=axis, curve=curve)
        d.ask(lead=JointForce(joint="lead", component="torque-z"))
    else:
        torque = d.draw.vector(d.draw.about(0.5, 3.0), 3)
        d.loads["motor"] = SpatialTorque(body="crank", point=foot, torque=torque, curve=d.draw.load_curve(d.period))
        d.vary("loads.motor.torque.z")
    mass, centre = d.draw.about(0.2, 2.0), d.point(d.places[rod.end] + d.draw.vector(0.05, 3))
    d.bodies["block"] = SpatialRigid(mass=mass, inertia=inertia(d, mass), center=centre)
    d.vary("bodies.block.mass")
    d.joints["guide"] = Prismatic(bodies=("block", "ground"), point=rod.end, axis=(1.0, d.draw.between(-0.2, 0.2), 0.0))
    cross = ((0.0, 1.0, 0.3), (0.0, -0.3, 1.0))
    d.joints["cross"] = Universal(bodies=("rod", "block"), point=rod.end, axes_of_cross=cross)
    d.ask(guide=JointForce(joint="guide", component="magnitude"), cross=JointForce(joint="cross", component="magnitude"))
    answers(d)


def structure(d: Draft) -> None:
    """Flexible bodies whose frames are grounded, translate on springs, or turn on one, under loads and pressure."""
    frame = d.draw.one(("grounded", "grounded", "turning", "translating"))
    d.at_rest = frame == "grounded"
    weight(d, 0.6)
    start = d.point((0.0, 0.0, 0.0))
    pressed = d.draw.chance(0.4) and frame != "turning"
    models = ("block",) if pressed else ("mast", "pipe", "bar")
    axis = {"axis": d.draw.vector(1.0, 3)} if frame == "turning" else {}
    body = flexible(d, "body", start, frame, models, **axis)
    curve = d.draw.load_curve(d.period)
    if pressed:
        d.loads["wind"] = Pressure(body="body", surface="top", pressure=d.draw.about(50.0, 2000.0), curve=curve)
        d.vary("loads.wind.pressure")
    else:
        force: Any = d.draw.vector(d.draw.about(0.5, 4.0), 3)
        d.loads["load"] = SpatialPointForce(
            body="body", point=body.end, force=force, frame=d.draw.one(("space", "body")), curve=curve
        )
        d.vary("loads.load.force.y")
    if frame == "turning":
        stiffness = d.draw.about(1.0, 30.0)
        d.loads["coil"] = SpatialRotationalSpringDamper(
            bodies=("body", "ground"), point=body.start, stiffness=stiffness, damping=0.01 * stiffness, **axis
        )
        d.vary("loads.coil.stiffness")
    if frame == "translating":
        for k in range(3):
            anchor, stiffness = d.point(d.draw.vector(0.8, 3)), d.draw.about(30.0, 500.0)
            d.loads[f"spring{k}"] = SpatialSpringDamper(
                bodies=("body", "ground"), points=(body.start, anchor), stiffness=stiffness, damping=0.01 * stiffness
            )
        d.vary("loads.spring0.stiffness")
    if d.draw.chance(0.5):
        now = link(d, "tip", body.end, d.draw.vector(1.0, 3), ("rod", "rigid"), 0.2)
        kind = d.draw.one((SpatialRigidJoint, Spherical, SpatialRevolute))
        tie(d, body, now, kind)
        d.at_rest = d.at_rest and kind is SpatialRigidJoint
        if kind is not SpatialRigidJoint:
            d.faster(0.9)
    answers(d)


def free(d: Draft) -> None:
    """Bodies that nothing holds, thrown, pushed, and tied by springs or rods."""
    d.faster(d.draw.about(0.5, 2.0))
    weight(d, 0.3)
    ends: list[Link] = []
    for k in range(d.draw.count(1, 3)):
        start = d.point((1.0 * k, d.draw.between(-0.2, 0.2), d.draw.between(-0.2, 0.2)))
        ends.append(link(d, f"body{k}", start, d.draw.vector(1.0, 3)))
        speed = {"velocity": d.draw.vector(1.0, 3), "angular_velocity": d.draw.vector(d.draw.about(1.0, 9.0), 3)}
        if k and d.draw.chance(0.25):
            d.joints[f"rod{k}"] = SpatialDistance(bodies=(ends[k - 1].body, ends[k].body), points=(ends[k - 1].end, ends[k].end))
            d.ask(**{f"rod{k}": JointForce(joint=f"rod{k}", component="magnitude")})
            continue
        d.bodies[f"body{k}"] = d.bodies[f"body{k}"].model_copy(update=speed)
        d.vary(f"bodies.body{k}.angular_velocity.x", f"bodies.body{k}.velocity.y")
        if k:
            stiffness = d.draw.about(5.0, 500.0)
            damping = float(d.draw.about(1e-3, 1e-1) * np.sqrt(stiffness))
            given = {"bodies": (ends[k - 1].body, ends[k].body), "points": (ends[k - 1].end, ends[k].end)}
            d.loads[f"spring{k}"] = SpatialSpringDamper(stiffness=stiffness, damping=damping, **given)
            d.faster(2 * np.pi / np.sqrt(2 * stiffness))
            d.vary(f"loads.spring{k}.stiffness")
    pushes(d, 0.5)
    answers(d)


def car(d: Draft) -> None:
    """A car on a plane that is led along it, with a tray on a guide or a cross, and links that hang from it."""
    d.faster(SWING)
    weight(d, 1.0)
    centre, mass = d.point((0.0, 0.0, 0.0)), d.draw.about(0.5, 3.0)
    normal = (d.draw.between(-0.2, 0.2), d.draw.between(-0.2, 0.2), 1.0)
    frame: Any = d.draw.one(("translating", "moving"))
    d.bodies["car"] = SpatialRigid(mass=mass, inertia=inertia(d, mass), center=centre, frame=frame)
    d.vary("bodies.car.mass")
    along = (1.0, 0.0, -normal[0])
    curve = d.draw.driver_curve(d.draw.about(0.05, 0.5), d.period)
    if frame == "translating":
        d.joints["plane"] = PointOnPlane(bodies=("car", "ground"), point=centre, axis=normal)
        d.ask(plane=JointForce(joint="plane", component="magnitude"))
    else:
        d.joints["guide"] = Prismatic(bodies=("car", "ground"), point=centre, axis=along)
        d.ask(guide=JointForce(joint="guide", component="magnitude"))
    d.joints["lead"] = SpatialPositionDriver(bodies=("car", "ground"), point=centre, axis=along, curve=curve)
    d.ask(lead=JointForce(joint="lead", component="x"))
    before = Link("car", centre, centre)
    for k in range(d.draw.count(1, 2)):
        kinds = ("rod", "rigid", "flexible")
        kind = d.draw.one((Universal, Spherical, SpatialRevolute))
        before = tie(d, before, link(d, f"link{k}", before.end, np.array([0.3, 0.2, -1.0]) + d.draw.vector(0.5, 3), kinds), kind)
    if d.draw.chance(0.4):
        at = d.point(d.places[centre] + (0.3, 0.2, 0.1))
        d.bodies["wheel"] = SpatialRigid(
            mass=0.9, inertia=inertia(d, 0.9), center=at, frame="turning", axis=d.draw.vector(1.0, 3), origin=centre
        )
        other = d.point((0.5, -0.6, 0.4))
        stiffness = d.draw.about(20.0, 200.0)
        given = {"stiffness": stiffness, "damping": 0.01 * stiffness}
        d.loads["wire"] = SpatialSpringDamper(bodies=("wheel", "car"), points=(at, other), **given)
        d.vary("loads.wire.stiffness")
    pushes(d, 0.3)
    answers(d)


KINDS = {"chain": chain, "door": door, "crank": crank, "structure": structure, "free": free, "car": car}
