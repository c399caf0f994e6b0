"""Maps over numbers of the scene, by decades: thickness, stiffness, mass ratio, load, speed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from toolkit.bodies.body import Body
from toolkit.bodies.model_body import ModelBody
from toolkit.foundation.dimensions import LABELLED
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import unit
from toolkit.scene.scene import Scene
from toolkit.scene_file.dimensions import dimensions, number_dimension
from toolkit.studies.stability.map import Axis, Map, over, scaled

THICKNESSES = (1 / 30, 0.1, 1 / 3, 1.0, 10 / 3, 10.0, 100 / 3)
"""Three decades: 0.05 to 50 mm of a skin of 1.5 mm."""
STIFFNESSES = tuple(10.0**k for k in (-11, -9, -7, -5, -4, -3, -2, -1, 0, 1, 2))
"""Of 70 GPa: about 1 Pa to 1e13 Pa."""
MASSES = tuple(10.0**k for k in (-8, -6, -4, -2, -1, 0, 1, 2, 4, 6, 8))
LOADS = (0.0, 1e-3, 1e-2, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6)
SPEEDS = (1e-3, 1e-2, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0, 1e3)


def thickness_map(scene: Scene) -> Map:
    """Thickness of all flexible bodies.

    Raises
    ------
    InputError
        No flexible body has one.
    """
    paths = [path for path in scene.model_parameters() if path.split(".")[-1].startswith("thickness")]
    return _by_factor(scene, "thickness", "thickness of flexible bodies", paths, THICKNESSES, "no flexible body has a thickness")


def stiffness_map(scene: Scene) -> Map:
    """Modulus of all flexible bodies, and stiffness of all springs.

    Raises
    ------
    InputError
        The scene has neither.
    """
    moduli = [
        path
        for path in scene.model_parameters()
        if path.startswith("bodies.") and number_dimension(scene, path) == LABELLED["stress"]
    ]
    springs = [path for path, dimension in dimensions(scene).items() if path.startswith("loads.") and path.endswith(".stiffness")]
    title = " and ".join([*(["modulus of flexible bodies"] if moduli else []), *(["stiffness of springs"] if springs else [])])
    return _by_factor(scene, "stiffness", title, [*moduli, *springs], STIFFNESSES, "nothing in the scene has a stiffness")


def mass_map(scene: Scene) -> Map:
    """Mass of the rigid bodies beside that of the flexible ones; among rigid bodies alone, of the first beside the others.

    Raises
    ------
    InputError
        The scene has no rigid body.
    """
    rigid = [name for name, body in scene.bodies.items() if body.proportional]
    flexible = any(isinstance(body, ModelBody) for body in scene.bodies.values())
    chosen = rigid if flexible else rigid[:1]
    title = "mass of the rigid bodies" if flexible else f"mass of body {chosen[0]!r}" if chosen else ""
    paths = [f"bodies.{name}.{path}" for name in chosen for path in _inertial(scene.bodies[name])]
    return _by_factor(scene, "mass", title, paths, MASSES, "the scene has no rigid body")


def _inertial(body: Body) -> list[str]:
    """Numbers that a rigid body's mass and moments of inertia are proportional to; products of inertia that are zero stay so."""
    return [path for path, value in body.numbers() if path.split(".")[0] in body.proportional and value != 0]


def load_map(scene: Scene) -> Map:
    """All torques, forces, pressures and accelerations of gravity at once.

    Raises
    ------
    InputError
        The scene has none.
    """
    written = [path.split(".") for path in dimensions(scene) if path.startswith("loads.")]
    paths = [".".join(keys) for keys in written if keys[2] in scene.loads[keys[1]].proportional]
    paths = [path for path in paths if scene.number(path) != 0]
    return _by_factor(scene, "load", "all loads", paths, LOADS, "the scene has no torque, force, pressure or gravity")


def speed_map(scene: Scene) -> Map:
    """The whole motion faster: velocities at the start, time curves, end time and step, in as many steps as before.

    Raises
    ------
    InputError
        Neither velocities nor time curves set a speed, or a results file does.
    """
    if scene.start_file is not None:
        raise InputError("the speed at the start is that of a results file (solver.start), which no factor changes")
    powers: dict[str, int] = {}
    for path, dimension in dimensions(scene).items():
        keys = path.split(".")
        timed = keys[0] in ("solver", "responses") or keys[2] in ("velocity", "angular_velocity", "elastic_velocity", "curve")
        if timed and dimension.mass == 0 and dimension.time:
            powers[path] = -dimension.time
    own = [path for path in powers if path.split(".")[0] not in ("solver", "responses") and scene.number(path) != 0]
    if not own:
        raise InputError("neither a velocity at the start nor a time curve sets a speed of the scene")
    axis = Axis("speed", SPEEDS, SPEEDS.index(1.0), factor=True)

    def faster(by: Any) -> Scene:
        return scaled(scene, {path: float(by) ** power for path, power in powers.items()})

    scenes = over((axis,), faster)
    return Map("speed", "speed of velocities, curves, end and step", (axis,), scenes, "half step")


def _by_factor(scene: Scene, name: str, title: str, paths: list[str], factors: tuple[float, ...], missing: str) -> Map:
    if not paths:
        raise InputError(missing)
    numbers = {float(np.real(scene.number(path))) for path in paths}
    alike = len(numbers) == 1 and len({number_dimension(scene, path) for path in paths}) == 1
    nominal, unit_of_it = (numbers.pop(), _unit(scene, paths[0])) if alike else (None, "")
    axis = Axis(name, factors, factors.index(1.0), unit_of_it, factor=True, nominal=nominal)
    scenes = over((axis,), lambda by: scaled(scene, {path: by for path in paths}))
    return Map(name, title, (axis,), scenes, "half step")


def _unit(scene: Scene, path: str) -> str:
    """Label of the unit of a number, where its dimension has one."""
    dimension = number_dimension(scene, path)
    known = [quantity for quantity, each in LABELLED.items() if each == dimension]
    return unit(scene.units, known[0]) if known else ""


PHYSICS: dict[str, Callable[[Scene], Map]] = {
    "thickness": thickness_map, "stiffness": stiffness_map, "mass": mass_map, "load": load_map, "speed": speed_map,
}  # fmt: skip
