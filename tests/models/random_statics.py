"""Random scenes whose static path may turn back, branch, or go through: trusses, arches, linkages, wings, in the plane and in space."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from toolkit.components.bodies.rigid import Rigid, Rod, SpatialRigid, SpatialRod
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.driver import AngleDriver
from toolkit.components.joints.revolute import Revolute, SpatialRevolute
from toolkit.components.joints.slider import Slider
from toolkit.components.joints.spherical import Spherical
from toolkit.components.joints.universal import Universal
from toolkit.components.loads.point_force import PointForce, SpatialPointForce
from toolkit.components.loads.springs import (
    RotationalSpringDamper,
    SpatialRotationalSpringDamper,
    SpatialSpringDamper,
    SpringDamper,
)
from toolkit.components.loads.torque import SpatialTorque, Torque
from toolkit.description.design import Point
from toolkit.files.scene_reader import read_scene
from toolkit.scene.scene import Scene

WING = Path(__file__).parents[2] / "models" / "morphing_wing" / "scene.toml"
SNAPPING = {
    "points.A": (73.89861560382003, -11.05548749841379),
    "points.B": (71.72011338376805, -15.825445897809107),
    "points.D": (52.59059437217881, 1.5960507670675916),
    "bodies.skin.thickness": 1.374579507272018,
    "loads.drive.torque": 4183.4842104370755,
}
"""A design whose path turns back at 11.70 % of the torque and again at 11.01 %, within two hundredths of the way of its driven rod."""

RNG = np.random.Generator


def points(places: dict[str, Any]) -> dict[str, Point]:
    return {name: Point(**dict(zip("xyz", map(float, place), strict=False))) for name, place in places.items()}


def planar(places: dict[str, Any], bodies: dict, joints: dict, loads: dict) -> Scene:
    return Scene(units="m-kg-s", points=points(places), bodies=bodies, joints=joints, loads=loads)


def truss(rng: RNG) -> Scene:
    """One to three nodes over each other, each on two springs to those below: every layer may snap, or buckle sideways."""
    layers = int(rng.integers(1, 4))
    places: dict[str, Any] = {"L": (-1.0, 0.0), "R": (1.0 + rng.uniform(-0.2, 0.2), rng.uniform(-0.05, 0.05))}
    bodies, joints, loads, below, height = {}, {}, {}, ("ground", "ground"), 0.0
    for k in range(layers):
        height += rng.uniform(0.1, 0.9)
        name, ends = f"P{k}", (f"P{k}", f"P{k}b")
        places[ends[0]], places[ends[1]] = (rng.uniform(-0.2, 0.2), height), (rng.uniform(0.8, 1.2), height)
        bodies[name] = Rigid(mass=1.0, inertia=1.0, center=ends[0])
        joints[name] = AngleDriver(bodies=(name, "ground"), point=ends[0], curve=SmoothStep(height=0.0))
        feet = ("L", "R") if k == 0 else (f"P{k - 1}", f"P{k - 1}b")
        for s, foot in enumerate(feet):
            loads[f"{name}{s}"] = SpringDamper(bodies=(name, below[s]), points=(ends[0], foot), stiffness=rng.uniform(300, 3000))
        below = (name, name)
    loads["push"] = PointForce(body=name, point=ends[0], force=(rng.normal(0, 2), -(10 ** rng.uniform(0.3, 2.7))))
    return planar(places, bodies, joints, loads)


def arch(rng: RNG) -> Scene:
    """Three to six rods with springs between them along a shallow arch, against a spring at one end."""
    count, rise = int(rng.integers(3, 7)), 10 ** rng.uniform(-1.5, -0.4)
    along = np.linspace(-1, 1, count + 1)
    places = {f"N{k}": (x, rise * (1 - x**2) + 0.02 * rise * rng.normal()) for k, x in enumerate(along)}
    places["W"] = (2.0, places[f"N{count}"][1])
    names = [f"rod{k}" for k in range(count)]
    bodies = {name: Rod(between=(f"N{k}", f"N{k + 1}"), area=1.0, density=1.0) for k, name in enumerate(names)}
    joints: dict[str, Any] = {"first": Revolute(bodies=("rod0", "ground"), point="N0")}
    loads: dict[str, Any] = {}
    for k, (left, right) in enumerate(pairwise(names), 1):
        joints[f"N{k}"] = Revolute(bodies=(right, left), point=f"N{k}")
        loads[f"spring{k}"] = RotationalSpringDamper(bodies=(right, left), point=f"N{k}", stiffness=rng.uniform(0.2, 2.0))
    joints["last"] = Slider(bodies=(names[-1], "ground"), point=f"N{count}", axis=(1.0, rng.normal(0, 0.05)))
    loads["wall"] = SpringDamper(bodies=(names[-1], "ground"), points=(f"N{count}", "W"), stiffness=10 ** rng.uniform(1.5, 3.5))
    at = int(rng.integers(1, count))
    loads["push"] = PointForce(body=names[at], point=f"N{at}", force=(rng.normal(0, 0.5), -(10 ** rng.uniform(-0.3, 1.8))))
    return planar(places, bodies, joints, loads)


def four_bar(rng: RNG) -> Scene:
    """A crank, a coupler and a rocker with springs in their joints and one across, under a torque: dead points and snaps."""
    places = {
        "O": (0.0, 0.0),
        "T": rng.normal((0.3, 0.6), 0.3),
        "S": rng.normal((1.3, 0.7), 0.3),
        "Q": rng.normal((1.2, 0.0), 0.2),
        "K": rng.normal((0.6, 0.9), 0.3),
        "W": rng.normal((0.5, -0.6), 0.4),
    }
    ends = {"crank": ("O", "T"), "coupler": ("T", "S"), "rocker": ("S", "Q")}
    bodies = {name: Rod(between=between, area=1.0, density=1.0) for name, between in ends.items()}
    pairs = {"O": ("crank", "ground"), "T": ("coupler", "crank"), "S": ("rocker", "coupler"), "Q": ("rocker", "ground")}
    joints = {name: Revolute(bodies=pair, point=name) for name, pair in pairs.items()}
    loads: dict[str, Any] = {
        name: RotationalSpringDamper(bodies=pair, point=name, stiffness=rng.uniform(0.0, 3.0), rest_angle=rng.normal(0, 0.2))
        for name, pair in pairs.items()
    }
    loads["across"] = SpringDamper(
        bodies=("coupler", "ground"), points=("K", "W"), stiffness=rng.uniform(0, 60), length=rng.uniform(0.5, 2.5)
    )
    loads["drive"] = Torque(body="crank", point="O", torque=rng.choice([-1, 1]) * 10 ** rng.uniform(-0.3, 1.7))
    return planar(places, bodies, joints, loads)


def wing(rng: RNG) -> Scene:
    """Near the design that snaps twice within a load step."""
    changed = {
        name: [value + rng.normal(0, 0.6) for value in given] if isinstance(given, tuple) else given * rng.uniform(0.9, 1.1)
        for name, given in SNAPPING.items()
    }
    return read_scene(WING, {name: str(value) for name, value in changed.items()})


def dome(rng: RNG) -> Scene:
    """One or two nodes in space on springs from a ring below: they snap straight through, or sideways."""
    nodes, legs = int(rng.integers(1, 3)), int(rng.integers(3, 6))
    places: dict[str, Any] = {}
    bodies, loads, height = {}, {}, 0.0
    for k in range(nodes):
        height += rng.uniform(0.15, 0.8)
        places[f"P{k}"] = (*rng.normal(0, 0.1, 2), height)
        bodies[f"node{k}"] = SpatialRigid(mass=1.0, inertia=(1.0, 1.0, 1.0), center=f"P{k}", frame="translating")
        for leg in range(legs):
            angle, foot = 2 * np.pi * (leg + 0.3 * k + 0.2 * rng.normal()) / legs, f"F{k}{leg}"
            places[foot] = (np.cos(angle), np.sin(angle), rng.normal(0, 0.05))
            loads[f"leg{k}{leg}"] = SpatialSpringDamper(
                bodies=(f"node{k}", "ground"), points=(f"P{k}", foot), stiffness=rng.uniform(200, 2000)
            )
    if nodes == 2:
        loads["tie"] = SpatialSpringDamper(bodies=("node1", "node0"), points=("P1", "P0"), stiffness=rng.uniform(200, 2000))
    force = (*rng.normal(0, 2, 2), -(10 ** rng.uniform(0.3, 2.7)))
    loads["push"] = SpatialPointForce(body=f"node{nodes - 1}", point=f"P{nodes - 1}", force=force)
    return Scene(units="m-kg-s", dimension=3, points=points(places), bodies=bodies, loads=loads)


def spatial_linkage(rng: RNG) -> Scene:
    """Crank, coupler and rocker about axes that are not parallel, with springs, under a torque fixed in space."""
    axes = [np.array([0.0, 0.0, 1.0]) + 0.3 * rng.normal(size=3) for _ in range(2)]
    places = {
        "O": (0.0, 0.0, 0.0),
        "T": rng.normal((0.3, 0.6, 0.1), 0.2),
        "S": rng.normal((1.3, 0.7, 0.2), 0.2),
        "Q": rng.normal((1.2, 0.0, 0.0), 0.2),
        "W": rng.normal((0.5, -0.6, 0.5), 0.4),
    }
    ends = {"crank": ("O", "T"), "coupler": ("T", "S"), "rocker": ("S", "Q")}
    bodies = {name: SpatialRod(between=between, area=0.01, density=1.0) for name, between in ends.items()}
    along = np.subtract(places["S"], places["T"])
    first = np.cross(along, rng.normal(size=3))
    joints = {
        "O": SpatialRevolute(bodies=("crank", "ground"), point="O", axis=tuple(axes[0])),
        "T": Universal(bodies=("coupler", "crank"), point="T", axes_of_cross=(tuple(first), tuple(np.cross(along, first)))),
        "S": Spherical(bodies=("rocker", "coupler"), point="S"),
        "Q": SpatialRevolute(bodies=("rocker", "ground"), point="Q", axis=tuple(axes[1])),
    }
    turning = {"bodies": ("crank", "ground"), "point": "O", "axis": tuple(axes[0])}
    size = 10 ** rng.uniform(-0.3, 1.2) * rng.choice([-1, 1])
    loads = {
        "coil": SpatialRotationalSpringDamper(**turning, stiffness=rng.uniform(0.2, 3.0)),
        "across": SpatialSpringDamper(
            bodies=("coupler", "ground"), points=("S", "W"), stiffness=rng.uniform(0, 60), length=rng.uniform(0.5, 2.0)
        ),
        "drive": SpatialTorque(body="crank", point="O", torque=tuple(size * axes[0])),
    }
    return Scene(units="m-kg-s", dimension=3, points=points(places), bodies=bodies, joints=joints, loads=loads)


KINDS: dict[str, Callable[[RNG], Scene]] = {
    "truss": truss, "arch": arch, "four-bar": four_bar, "wing": wing, "dome": dome, "spatial linkage": spatial_linkage,
}  # fmt: skip


def random_scene(kind: str, seed: int) -> Scene:
    """The scene of a kind that belongs to a seed."""
    return KINDS[kind](np.random.default_rng([seed, list(KINDS).index(kind)]))
