"""What the answers of a random scene are: two finer runs by different formulations that must agree."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from toolkit.analyses.sensitivity.preparation import evaluate_with_gradients, prepare, responses_of, solve
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ToolkitError
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Displacement, Rotation
from toolkit.responses.over_time import TimeIntegral
from toolkit.responses.response import Instant
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.system.system import System

AGREED = 0.01
"""Difference of the two finer runs above which an answer is not known."""
FINER = (10, 40, 160)
"""Steps of the first of two finer runs in parts of the scene's own; the second has twice as many. Tried until they agree."""
MOST_STEPS = 24000
"""Steps of the finer of the two runs beyond which a scene has no reference."""
NO_FORCE = 1e-9
"""Force of a joint that holds nothing, in the units of the scenes, whose forces are from 0.1 to 100."""
SAMPLES = 48
"""Times at which an answer's size during the motion is looked for."""
STILL = 1e-6
"""Angle in rad, and displacement in parts of the model size, below which nothing moves."""
ELASTICITY = 0.02
"""A gradient is compared with the largest it has during the motion, and at least with this part of answer over variable."""


@dataclass(frozen=True)
class Answers:
    """Response -> value and size, variable -> gradient and size; sizes are the largest during the motion."""

    values: dict[str, float]
    sizes: dict[str, float]
    gradients: dict[str, dict[str, float]]
    gradient_sizes: dict[str, dict[str, float]]


def answers(solution: Solution, sizes: bool = True) -> Answers:
    """Of a run with the scene's design variables."""
    values, gradients = evaluate_with_gradients(solution)
    plain = {name: float(np.real(value)) for name, value in values.items()}
    size: dict[str, float] = {}
    slope: dict[str, dict[str, float]] = {}
    if sizes:
        for name, response in responses_of(solution.system.scene).items():
            size[name], found = _sizes(response, solution, plain[name], gradients[name])
            slope[name] = dict(zip(solution.system.design.names, _floored(solution.system, found, size[name]), strict=True))
    return Answers(plain, size, gradients, slope)


def _sizes(response: Any, solution: Solution, value: float, gradient: dict[str, float]) -> tuple[float, np.ndarray]:
    """Largest value and gradient (n_x,) during the motion; of an integral the integral of both sizes, of a maximum its own."""
    own = np.abs(list(gradient.values()))
    if isinstance(response, TimeIntegral):
        value, largest = _sizes(response.of, solution, 0.0, {})
        return value * float(solution.times[-1]), np.maximum(largest * float(solution.times[-1]), 0.0)
    if not isinstance(response, Instant):
        return abs(value), own
    steps = np.unique(np.linspace(0, len(solution.times) - 1, SAMPLES).astype(int))
    parts = [(int(n), response.at(solution, int(n))) for n in steps]
    slopes = [_total(part, solution, n) for n, part in parts]
    largest = np.nanmax(np.abs(slopes), axis=0)
    return float(max(abs(np.real(part.value)) for _, part in parts)), np.maximum(largest, own) if len(own) else largest


def _total(part: Any, solution: Solution, n: int) -> np.ndarray:
    total = np.zeros(solution.system.n_x) if part.design is None else np.real(part.design).astype(float)
    pairs = ((part.q, solution.dq), (part.v, solution.dv), (part.a, solution.da), (part.multipliers, solution.dmultipliers))
    return total + sum(np.real(partial) @ change[n] for partial, change in pairs if partial is not None)


def _floored(system: System, slopes: np.ndarray, size: float) -> np.ndarray:
    """Sizes of gradients (n_x,), at least what changes the answer a little when the variable changes by itself."""
    length = system.scene.size
    scales = [max(abs(each.value), length if each.path.startswith("points.") else 1e-12) for each in system.design.variables]
    return np.maximum(slopes, ELASTICITY * size / np.array(scales))


def errors(scene: Scene, found: Answers, true: Answers) -> tuple[dict[str, float], dict[str, float]]:
    """Relative errors of all values, and of all gradients by the name "response by variable"."""
    least = {name: _least(scene, name) for name in true.values}
    values = {name: abs(_difference(scene, name, found, true)) / max(true.sizes[name], least[name]) for name in true.values}
    gradients = {
        f"{name} by {x}": abs(found.gradients[name][x] - slope) / (true.gradient_sizes[name][x] or 1e-300)
        for name, slopes in true.gradients.items()
        for x, slope in slopes.items()
        if true.sizes[name] > least[name]
    }
    return values, gradients


def _least(scene: Scene, name: str) -> float:
    """A size below which an answer is zero: what a joint locks turns and moves by round-off."""
    response = scene.responses[name]
    if isinstance(response, JointForce):
        return NO_FORCE
    return STILL * (
        1.0 if isinstance(response, Rotation) else loaded(scene).size if isinstance(response, Displacement) else 1e-300
    )


def _difference(scene: Scene, name: str, found: Answers, true: Answers) -> float:
    """Of two values; angles in space repeat after a turn."""
    off = found.values[name] - true.values[name]
    turns = isinstance(scene.responses[name], Rotation) and scene.dimension == 3
    return float((off + np.pi) % (2 * np.pi) - np.pi) if turns else off


@dataclass(frozen=True)
class Reference:
    """The answers, and how far the two runs that they come from are apart; `why` there is none."""

    answers: Answers | None
    values: dict[str, float]
    gradients: dict[str, float]
    finer: int = 0
    why: str = ""

    @property
    def unknown(self) -> list[str]:
        """Values that the two runs disagree on."""
        return [name for name, off in self.values.items() if not off <= AGREED]


def reference(scene: Scene, steps: int) -> Reference:
    """Answers of a scene whose own run took `steps` steps."""
    last = Reference(None, {}, {}, why="too many steps")
    for finer in FINER:
        if 2 * finer * steps > MOST_STEPS and finer > FINER[0]:
            break
        try:
            first = answers(_run(scene, finer * steps, "index-1", 0.5), sizes=False)
            second = answers(
                _run(scene, 2 * finer * steps, "index-3" if _open(scene) else "ggl", 0.8 if not _open(scene) else 0.6)
            )
        except (ToolkitError, FloatingPointError) as error:
            last = Reference(None, {}, {}, finer, f"{type(error).__name__}: {error}")
            continue
        last = Reference(second, *errors(scene, first, second), finer)
        if not last.unknown and max(last.gradients.values(), default=0.0) <= AGREED:
            break
    return last


def model_reference(finer: Scene, steps: int) -> Reference:
    """Answers of a scene with finer models of its flexible bodies, in so many steps."""
    try:
        return Reference(answers(_run(finer, steps, "index-1", 0.5)), {}, {})
    except (ToolkitError, FloatingPointError) as error:
        return Reference(None, {}, {}, why=f"{type(error).__name__}: {error}")


def confirmed_reference(finer: Scene, steps: int) -> Reference:
    """The same with a second run of another formulation with twice the steps, and how far they are apart: a sudden torque on small elements
    leaves the first steps with stresses of the steps' own making."""
    try:
        first = answers(_run(finer, steps, "index-1", 0.5), sizes=False)
        second = answers(_run(finer, 2 * steps, "index-3" if _open(finer) else "ggl", 0.8 if not _open(finer) else 0.6))
        return Reference(second, *errors(finer, first, second))
    except (ToolkitError, FloatingPointError) as error:
        return Reference(None, {}, {}, why=f"{type(error).__name__}: {error}")


def _open(scene: Scene) -> bool:
    """Whether stabilised index 2 cannot solve it."""
    return scene.solver.quasi_static or scene.solver.redundant == "least-squares"


def _run(scene: Scene, steps: int, formulation: str, rho_inf: float) -> Solution:
    options = scene.solver
    fine = RunOptions.model_validate(
        {
            "end_time": options.end_time,
            "step": options.end_time / steps,
            "formulation": formulation,
            "rho_inf": rho_inf,
            "quasi_static": options.quasi_static,
            "redundant": options.redundant,
            "assemble": options.assemble,
            "tolerance": 1e-11,
        }
    )
    finer = scene.model_copy(update={"solver": fine})
    return solve(prepare(finer, list(scene.design)), "transient")
