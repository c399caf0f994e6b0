"""Random scenes at the edges of what bodies of one frame can tell, each with a finer scene that tells what is true.

Beams held at both ends, loads that are put on at once, loads that follow, reduced bases away from the design that they were made at,
damping that follows the mass, and joints that repeat each other. The finer scene has the same loads and joints, and bodies with twice
the elements, all coordinates and eight floating frames.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from preprocessing import build
from tests.models.kept_files import write_once
from tests.random_scenes.draft import Draft
from tests.random_scenes.draw import Draw
from tests.random_scenes.solver import random_options
from toolkit.components.bodies.flexible import Flexible
from toolkit.components.bodies.rigid import Rigid
from toolkit.components.curves.polynomial import Constant
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.rigid_joint import RigidJoint
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.point_force import PointForce
from toolkit.description.run_options import RunOptions
from toolkit.reduced_model.file import save
from toolkit.responses.energy import StrainEnergy
from toolkit.responses.extremes import TimeMax
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Displacement
from toolkit.responses.stress import MaxStress
from toolkit.scene.scene import Scene

MODULUS, DENSITY, THICKNESS, WIDTH, LENGTH = 2e9, 1200.0, 0.02, 0.03, 1.0
STIFFNESS = MODULUS * WIDTH * THICKNESS**3 / 12
PERIOD = 2 * np.pi / (3.516 * np.sqrt(STIFFNESS / (DENSITY * WIDTH * THICKNESS)) / LENGTH**2)
"""First of the clamped beam, s."""
FRAMES = 8
"""Of each body of a finer scene."""

BODY = """units = "m-kg-s"
dimension = 2
clamp = ["A"]
nodes = {{ A = [0.0, 0.0], M = [0.5, 0.0], B = [1.0, 0.0] }}
beams = [
    {{ from = "A", to = "M", section = "root", elements = {elements} }},
    {{ from = "M", to = "B", section = "outer", elements = {elements} }},
]
interface_points = {{ start = {{ node = "A" }}, middle = {{ node = "M" }}, end = {{ node = "B" }} }}
damping = {{ mass = {mass}, stiffness = 1e-3 }}
basis = {{ {basis} }}
sections.root = {{ kind = "rectangle", thickness = 0.02, width = 0.03, material = "m" }}
sections.outer = {{ kind = "rectangle", thickness = 0.02, width = 0.03, material = "m" }}
materials.m = {{ youngs_modulus = 2e9, density = 1200.0 }}
"""
BASES = {
    "full": 'kind = "full"',
    "craig": 'kind = "craig-bampton", count = 2',
    "modes": 'kind = "eigenmodes", count = 3',
    "kept_modes": 'kind = "eigenmodes", count = 2, derivative = "frozen"',
    "kept_craig": 'kind = "craig-bampton", count = 1, derivative = "frozen"',
}
"""Name -> basis; those that are kept do not follow the design."""


class Pair(NamedTuple):
    """A scene, and a finer one of the same mechanism."""

    kind: str
    scene: Scene
    finer: Scene


def strained_scene(seed: int, directory: Path) -> Pair:
    """The scene of a seed, with reduced models in `directory`, where those that are missing are built."""
    draw = Draw(seed + 1_000_000)
    kind = draw.one(list(KINDS))
    draft = Draft(draw, directory, 2)
    KINDS[kind](draft)
    scene = draft.scene(_options(draft, kind))
    return Pair(kind, scene, finer(scene))


def finer(scene: Scene) -> Scene:
    """The same mechanism with more elements, all coordinates and eight frames for every flexible body."""
    bodies = {}
    for name, body in scene.bodies.items():
        if isinstance(body, Flexible):
            mass = body.model.split("_")[-1].removesuffix(".h5")
            file = _model(scene.directory, "full", 8, mass)
            body = body.model_copy(update={"model": file, "frames": FRAMES})
        bodies[name] = body
    return scene.model_copy(update={"bodies": bodies})


def _model(directory: Path, basis: str, elements: int, mass: str = "0") -> str:
    """The name of the reduced model's file, which is built if it is missing."""
    name = f"{basis}_{elements}_{mass}"
    text = BODY.format(elements=elements, mass=mass, basis=BASES[basis])

    def write(own: Path) -> None:
        (own / f"{name}.toml").write_text(text)
        save(build(own / f"{name}.toml"), own / f"{name}.h5")

    write_once(directory, (name, text), write)
    return f"{name}.h5"


def _options(d: Draft, kind: str) -> RunOptions:
    """Of any kind; where loads are put on at once, steps from fine to longer than the vibration."""
    options = random_options(d)
    if kind != "sudden":
        return options
    end = d.draw.about(1.0 * d.period, 8.0 * d.period)
    steps = max(4, round(end / d.draw.about(0.01 * d.period, 2.0 * d.period)))
    return RunOptions(end_time=end, step=float(end / steps))


def _beam(d: Draft, bases: tuple[str, ...], frame: Any = "grounded", mass: str = "0", **values: float) -> tuple[str, str, str]:
    """A beam of a metre along x; its points at start, middle and end."""
    basis = d.draw.one(bases)
    d.bodies["beam"] = Flexible(model=_model(d.directory, basis, d.draw.one((3, 4, 6)), mass), frame=frame, **values)
    d.faster(PERIOD)
    d.vary("bodies.beam.thickness_root", "bodies.beam.thickness_outer", "bodies.beam.youngs_modulus_m", "bodies.beam.density_m")
    places = {"start": 0.0, "middle": 0.5, "end": LENGTH}
    start, middle, end = (d.interface("beam", name, np.array([x, 0.0])) for name, x in places.items())
    for name, point in (("middle", middle), ("end", end)):
        way = Displacement(body="beam", point=point, component="y")
        d.ask(**{name: way, f"most_{name}": TimeMax(of=Displacement(body="beam", point=point, component="magnitude"))})
    d.ask(stress=MaxStress(body="beam", measure="absolute"), strain=StrainEnergy())
    return start, middle, end


def _curve(d: Draft) -> Any:
    """Put on slowly, as fast as the beam moves, or at once."""
    return d.draw.one((Constant(), SmoothStep(duration=d.draw.about(0.3 * d.period, 3 * d.period))))


def held(d: Draft) -> None:
    """A beam held at both ends, under a force across it."""
    both = d.draw.chance(0.5)
    start, middle, end = _beam(d, ("full", "craig"), "moving" if both else "grounded")
    d.period *= 0.35
    if both:
        d.joints["left"] = Revolute(bodies=("beam", "ground"), point=start)
    d.joints["right"] = d.draw.one((Revolute, RigidJoint))(bodies=("beam", "ground"), point=end)
    force = d.draw.about(0.03, 2.0) * THICKNESS * 48 * STIFFNESS / LENGTH**3
    d.loads["push"] = PointForce(body="beam", point=middle, force=(0.0, force), curve=_curve(d))
    d.vary("loads.push.force.y")
    d.ask(pull=JointForce(joint="right", component="magnitude"))
    del d.asked["end"], d.asked["most_end"]  # which is held
    d.at_rest = True


def sudden(d: Draft) -> None:
    """A cantilever, perhaps with a mass at its end, under a force that is there at once."""
    _, middle, end = _beam(d, ("full", "craig", "modes"))
    if d.draw.chance(0.3):
        centre = d.point((LENGTH, 0.0))
        d.bodies["mass"] = Rigid(mass=d.draw.about(0.02, 1.0), inertia=1e-4, center=centre)
        d.joints["glue"] = RigidJoint(bodies=("mass", "beam"), point=end)
        d.vary("bodies.mass.mass")
    force = d.draw.about(0.002, 0.1) * 3 * STIFFNESS / LENGTH**2
    d.loads["push"] = PointForce(body="beam", point=d.draw.one((middle, end)), force=(0.0, force))
    d.vary("loads.push.force.y")


def follower(d: Draft) -> None:
    """A column pressed by a force that follows its end, pushed aside a little."""
    _, _, end = _beam(d, ("full", "craig", "modes"))
    press = d.draw.about(0.5, 25.0) * STIFFNESS / LENGTH**2
    d.loads["press"] = PointForce(body="beam", point=end, force=(-press, 0.0), frame="body", curve=_curve(d))
    aside = d.draw.about(0.0005, 0.02) * 3 * STIFFNESS / LENGTH**2
    d.loads["aside"] = PointForce(body="beam", point=end, force=(0.0, aside), curve=_curve(d))
    d.vary("loads.press.force.x", "loads.aside.force.y")


def pulled(d: Draft) -> None:
    """A cantilever pulled or pressed along its line, and pushed aside."""
    _, _, end = _beam(d, ("full", "craig", "modes"))
    along = d.draw.one((1.0, 1.0, -0.1)) * d.draw.about(0.01, 10.0) * STIFFNESS / LENGTH**2
    d.loads["pull"] = PointForce(body="beam", point=end, force=(along, 0.0))
    aside = d.draw.about(0.0005, 0.05) * 3 * STIFFNESS / LENGTH**2
    d.loads["aside"] = PointForce(body="beam", point=end, force=(0.0, aside), curve=_curve(d))
    d.vary("loads.pull.force.x", "loads.aside.force.y")


def away(d: Draft) -> None:
    """A cantilever whose basis was made at another design."""
    values = {name: THICKNESS * d.draw.about(0.5, 2.0) for name in ("thickness_root", "thickness_outer") if d.draw.chance(0.7)}
    _, middle, end = _beam(d, ("kept_modes", "kept_craig", "full"), **values)
    force = d.draw.about(0.002, 0.03) * 3 * STIFFNESS / LENGTH**2
    d.loads["push"] = PointForce(body="beam", point=d.draw.one((middle, end)), force=(0.0, force), curve=_curve(d))
    d.vary("loads.push.force.y")


def damped(d: Draft) -> None:
    """A hinged beam that swings, or a clamped one, with damping that follows its mass."""
    hinged = d.draw.chance(0.5)
    start, _, end = _beam(d, ("full", "craig", "modes"), "moving" if hinged else "grounded", d.draw.one(("0.5", "3", "20")))
    if hinged:
        d.joints["pin"] = Revolute(bodies=("beam", "ground"), point=start)
        d.loads["weight"] = Gravity(acceleration=(0.0, -d.draw.about(0.3, 9.81)))
    force = d.draw.about(0.0005, 0.01) * 3 * STIFFNESS / LENGTH**2
    d.loads["push"] = PointForce(body="beam", point=end, force=(0.0, force), curve=_curve(d))
    d.vary("loads.push.force.y", "bodies.beam.damping_mass")


def redundant(d: Draft) -> None:
    """A carriage on two parallel guides with a beam on it; somewhere else a pendulum that touches nothing."""
    d.redundant = True
    start, _, end = _beam(d, ("full", "craig"), "moving")
    centre, aside = d.point((0.0, 0.0)), d.point((0.0, -0.3))
    d.bodies["carriage"] = Rigid(mass=d.draw.about(0.2, 3.0), inertia=0.02, center=centre)
    axis = d.draw.vector(1.0, 2)
    for name, point in (("upper", centre), ("lower", aside)):
        d.joints[name] = Slider(bodies=("carriage", "ground"), point=point, axis=axis, lock_rotation=True)
        d.ask(**{name: JointForce(joint=name, component="magnitude")})
    d.joints["root"] = RigidJoint(bodies=("beam", "carriage"), point=start)
    force = d.draw.about(0.0005, 0.01) * 3 * STIFFNESS / LENGTH**2
    d.loads["push"] = PointForce(body="beam", point=end, force=(0.3 * force, force), curve=_curve(d))
    d.vary("loads.push.force.y", "bodies.carriage.mass")


KINDS = {
    "held": held,
    "sudden": sudden,
    "follower": follower,
    "pulled": pulled,
    "away": away,
    "damped": damped,
    "redundant": redundant,
}
