"""Maps, with their axes and the scene of every cell: over numbers of the scene, and over settings of the solver."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal

import numpy as np

from toolkit.components.bodies.body import Body
from toolkit.components.bodies.model_body import ModelBody
from toolkit.description.run_options import Baumgarte, time_grid
from toolkit.files.gradient_units import dimensions, number_dimension
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import LABELLED, unit
from toolkit.scene.scene import Scene

Judge = Literal["reference", "half step", "own units"]


@dataclass(frozen=True)
class Axis:
    """Values of one thing that a map varies.

    `own` is the number of the value that the scene has as it stands. A `factor` multiplies what the scene has: `nominal`, if that is one
    number. Text instead of numbers has no order.
    """

    name: str
    values: tuple[float | str, ...]
    own: int | None = None
    unit: str = ""
    factor: bool = False
    nominal: float | None = None

    def label(self, index: int) -> str:
        """One value, short."""
        value = self.values[index]
        return value if isinstance(value, str) else brief(value)

    def long_label(self, index: int) -> str:
        """One value with its unit; of a factor also the number that comes out."""
        value = self.values[index]
        if isinstance(value, str):
            return value
        if self.factor and self.nominal is not None:
            return f"{brief(value * self.nominal)} {self.unit} (x {brief(value)})".replace("  ", " ")
        return f"x {brief(value)}" if self.factor else f"{brief(value)} {self.unit}".strip()


def brief(value: float) -> str:
    """Three digits of a number, without zeros that say nothing."""
    if value == 0 or 1e-3 <= abs(value) < 1e5:
        return f"{float(f'{value:.3g}') + 0.0:g}"  # no minus before a zero
    digits, power = f"{value:.2e}".split("e")
    return f"{digits.rstrip('0').rstrip('.')}e{int(power)}"


@dataclass(frozen=True)
class Map:
    """Cells over one axis or two; `scenes` has the number of the value on each axis -> scene.

    `judge` says what the responses of a cell are compared with: the scene's own motion with a fine step, where the map varies the
    solver; the same cell with half the step, where it varies the physics; or the scene as it stands, in its own units.
    """

    name: str
    title: str
    axes: tuple[Axis, ...]
    scenes: Mapping[tuple[int, ...], Scene]
    judge: Judge


def over(axes: tuple[Axis, ...], scene_at: Callable[..., Scene]) -> dict[tuple[int, ...], Scene]:
    """Scenes of all cells from the values on the axes."""
    found = {}
    for index in np.ndindex(*(len(axis.values) for axis in axes)):
        found[index] = scene_at(*(axis.values[k] for axis, k in zip(axes, index, strict=True)))
    return found


def scaled(scene: Scene, paths: Mapping[str, float]) -> Scene:
    """The scene with the numbers at some paths multiplied by factors."""
    for path, by in paths.items():
        if by != 1:
            scene = scene.with_number(path, by * scene.number(path))
    return scene


def with_options(scene: Scene, **changes: object) -> Scene:
    """The scene with other options of the solver."""
    return scene.model_copy(update={"solver": scene.solver.model_copy(update=changes)})


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

    def faster(by: float) -> Scene:
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


FINER, COARSER = (100, 30, 10, 3), (3, 10, 30, 100, 300, 1000)
"""Steps, as divisors and multiples of the scene's own: half a decade apart; finer ones are whole parts, so that times stay on the grid."""
FINER_ERROR = (10, 3)
"""Likewise where the run chooses its steps: the local error falls by the cube."""
FEWEST_STEPS = 3
RADII = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
FACTORS = (0.0, 0.01, 0.1, 0.3, 1.0, 10.0, 100.0)
"""Constants of the stabilisation, in 1/step."""
DAMPING, STIFFNESS = 1.0, np.sqrt(2)
"""What they are by default."""


def refined(scene: Scene, parts: int) -> Scene:
    """The scene with every step in parts; error control with a local error that such steps would have, of third order in the step."""
    options = scene.solver
    changes: dict[str, Any] = {"step": options.step / parts}
    if options.local_error is not None:
        changes["local_error"] = options.local_error / parts**3
    if options.times is not None:
        split = [np.linspace(a, b, parts, endpoint=False) for a, b in pairwise(options.times)]
        changes["times"] = (*map(float, np.concatenate(split)), options.times[-1])
    return with_options(scene, **changes)


def finest_first(scene: Scene) -> list[Scene]:
    """Candidates for the reference: the scene refined, as it stands, and with coarser steps."""
    coarser = [with_options(scene, step=step) for step in coarser_steps(scene)] if scene.solver.times is None else []
    parts = FINER if scene.solver.local_error is None else FINER_ERROR
    return [*(refined(scene, each) for each in (*parts, 1)), *coarser]


def coarser_steps(scene: Scene) -> list[float]:
    """Multiples of the scene's step."""
    own, end = scene.solver.step, scene.solver.end_time
    return [own * times for times in COARSER if own * times <= end / FEWEST_STEPS]


def steps_needed(scene: Scene) -> int:
    """Steps of a scene, by its times or its (largest) step."""
    options = scene.solver
    return len(options.times) - 1 if options.times else int(np.ceil(options.end_time / options.step * (1 - 1e-9)))


def step_map(scene: Scene, most_steps: int) -> Map:
    """Step x rho_inf, with steps of which at most `most_steps` are needed.

    Raises
    ------
    InputError
        The scene gives its times, or none of the steps is allowed.
    """
    if scene.solver.times is not None:
        raise InputError("the scene gives its times, so that no step can be chosen")
    rho, own = scene.solver.rho_inf, scene.solver.step
    wanted = (*(own / parts for parts in FINER), own, *coarser_steps(scene))
    steps = tuple(step for step in wanted if steps_needed(with_options(scene, step=step)) <= most_steps)
    if not steps:
        raise InputError(f"every step needs more than {most_steps} steps (--most-steps)")
    radii = tuple(sorted({*RADII, rho}))
    axes = (
        Axis("step", steps, steps.index(own) if own in steps else None, unit=unit(scene.units, "time")),
        Axis("rho_inf", radii, radii.index(rho)),
    )
    scenes = over(axes, lambda step, radius: with_options(scene, step=step, rho_inf=radius))
    return Map("step", "step x rho_inf", axes, scenes, "reference")


def baumgarte_map(scene: Scene) -> Map:
    """Damping x stiffness of the stabilisation of the joints, in 1/step.

    Raises
    ------
    InputError
        The scene has no joints, or its formulation needs no stabilisation.
    """
    if not scene.joints:
        raise InputError("the scene has no joints, so nothing is stabilised")
    if scene.solver.formulation != "index-1":
        raise InputError("the scene's formulation keeps positions on the joints without stabilisation")
    step = float(time_grid(scene.solver)[1])
    written = scene.solver.baumgarte
    own = [
        default if value is None else float(value) * step
        for value, default in ((written.damping, DAMPING), (written.stiffness, STIFFNESS))
    ]
    names = ("damping x step", "stiffness x step")
    values = [tuple(sorted({*FACTORS, round(value, 12)})) for value in own]
    axes = tuple(Axis(name, found, found.index(round(value, 12))) for name, found, value in zip(names, values, own, strict=True))
    scenes = over(axes, lambda a, b: with_options(scene, baumgarte=Baumgarte(damping=a / step, stiffness=b / step)))
    return Map("baumgarte", "stabilisation (Baumgarte): damping x stiffness", axes, scenes, "reference")
