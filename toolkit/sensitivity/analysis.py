"""One run of a scene, transient or static, and its responses with gradients."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from typing import Any, Literal

import numpy as np

from toolkit.responses.response import Response
from toolkit.scene import Scene
from toolkit.solution import Solution
from toolkit.solvers.statics import solve_statics
from toolkit.solvers.transient import simulate
from toolkit.system import System, compile_scene

Kind = Literal["transient", "static"]
Progress = Callable[[int, int], None]

REPEATS, WORTH_REPEATING = 5, 0.1
"""A run shorter than this, in s, is timed this many times."""


@dataclass(frozen=True)
class Result:
    """Values, units and gradients of the responses; `solution` is the run that they come from, wall times in s."""

    values: dict[str, Any]
    units: dict[str, str]
    gradients: dict[str, dict[str, float]]
    method: str
    solution: Solution
    wall_primal: float
    wall_sensitivity: float


def responses_of(scene: Scene, moving: bool = True) -> dict[str, Response]:
    """The scene's responses; without motion only those that a state at rest has."""
    known = {name: response for name, response in scene.responses.items() if isinstance(response, Response)}
    return {name: response for name, response in known.items() if moving or not response.needs_motion}


def moving(solution: Solution) -> bool:
    """Whether it is a transient solution."""
    return len(solution.times) > 1


def prepare(scene: Scene, design: list[str] | None = None) -> System:
    """Compile a scene with what its responses look at."""
    markers = [marker for response in responses_of(scene).values() for marker in response.markers()]
    return compile_scene(scene, design, tuple(dict.fromkeys(markers)))


def solve(system: System, kind: Kind, progress: Progress | None = None) -> Solution:
    """Transient or static solution of a system."""
    return solve_statics(system, progress=progress) if kind == "static" else simulate(system, progress=progress)


def evaluate_responses(solution: Solution) -> dict[str, Any]:
    """Values of all responses of the scene."""
    return {name: response.value(solution) for name, response in responses_of(solution.system.scene, moving(solution)).items()}


def values_of(scene: Scene, kind: Kind) -> dict[str, Any]:
    """Values of all responses after one run, without derivatives."""
    return evaluate_responses(solve(prepare(scene), kind))


def direct(scene: Scene, design: list[str], kind: Kind, progress: Progress | None = None) -> Result:
    """Responses with gradients by direct differentiation.

    The scene is solved without derivatives too, so that the price of the gradients is measured and not guessed.
    """
    system, primal_system = prepare(scene, design), prepare(scene)
    _warm_up(system, primal_system, kind)
    primal, _ = timed(primal_system, kind)
    total, solution = timed(system, kind, progress)
    gradients = {
        name: dict(zip(system.design.names, map(float, response.gradient(solution)), strict=True))
        for name, response in responses_of(scene, moving(solution)).items()
    }
    extra = solution.wall.get("sensitivity", max(total - primal, 0.0))
    return result(scene, solution, gradients, "direct", primal, extra)


def timed(system: System, kind: Kind, progress: Progress | None = None) -> tuple[float, Solution]:
    """Time of a run, and its solution; a run of a few milliseconds is repeated and the median taken, for one number would be noise."""
    times: list[float] = []
    while not times or (len(times) < REPEATS and times[0] < WORTH_REPEATING):
        begun = clock.perf_counter()
        solution = solve(system, kind, progress)
        times.append(clock.perf_counter() - begun)
    return median(times), solution


def result(
    scene: Scene, solution: Solution, gradients: dict[str, dict[str, float]], method: str, primal: float, extra: float
) -> Result:
    """Collect values and units."""
    units = {name: response.unit(scene.units) for name, response in responses_of(scene, moving(solution)).items()}
    values = {name: float(np.real(value)) for name, value in evaluate_responses(solution).items()}
    return Result(values, units, gradients, method, solution, primal, extra)


def _warm_up(system: System, primal: System, kind: Kind) -> None:
    """One short run of each, so that loading compiled code is not counted as solving."""
    if kind == "static":
        return
    options = system.scene.solver.model_copy(update={"end_time": system.scene.solver.step})
    for each in (system, primal):
        simulate(each, options)
