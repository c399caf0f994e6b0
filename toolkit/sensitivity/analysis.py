"""One run of a scene, transient or static, and its responses with gradients."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from statistics import median
from typing import Any, Literal, TypeVar

import numpy as np

from toolkit.compile_watch import watched_compilation
from toolkit.design import Design
from toolkit.responses.response import Response
from toolkit.scene import Scene
from toolkit.solution import Solution
from toolkit.solvers.statics import solve_statics
from toolkit.solvers.transient import simulate
from toolkit.system import System, compile_scene

T = TypeVar("T")
Kind = Literal["transient", "static"]
Progress = Callable[[int, int], None]

REPEATS, WORTH_REPEATING = 5, 1.0
"""A run is repeated so often, as long as all together take less than this, in s."""


@dataclass(frozen=True)
class Result:
    """Values, units and gradients of the responses; `solution` is the run that they come from, wall times in s.

    `reason` says why the method was chosen, if nobody named one.
    """

    values: dict[str, Any]
    units: dict[str, str]
    gradients: dict[str, dict[str, float]]
    method: str
    solution: Solution
    wall_primal: float
    wall_sensitivity: float
    reason: str = ""


def responses_of(scene: Scene, moving: bool = True) -> dict[str, Response]:
    """The scene's responses; without motion only those that a state at rest has."""
    known = {name: response for name, response in scene.responses.items() if isinstance(response, Response)}
    return {name: response for name, response in known.items() if moving or not response.needs_motion}


def moving(solution: Solution) -> bool:
    """Whether it is a transient solution."""
    return len(solution.times) > 1


def frozen(scene: Scene, solution: Solution) -> Scene:
    """The scene with the times that its run has chosen: other designs are solved with the same steps, as derivatives suppose."""
    if scene.solver.local_error is None or not moving(solution):
        return scene
    chosen = {"times": tuple(map(float, solution.whole_run)), "local_error": None}
    return scene.model_copy(update={"solver": scene.solver.model_copy(update=chosen)})


def prepare(scene: Scene, design: list[str] | None = None) -> System:
    """Compile a scene with what its responses look at, after they had a look at the scene."""
    for response in responses_of(scene).values():
        response.check(scene)
    markers = [marker for response in responses_of(scene).values() for marker in response.markers()]
    return compile_scene(scene, design, tuple(dict.fromkeys(markers)))


def solve(system: System, kind: Kind, progress: Progress | None = None) -> Solution:
    """Transient or static solution of a system."""
    return solve_statics(system, progress=progress) if kind == "static" else simulate(system, progress=progress)


def evaluate_responses(solution: Solution) -> dict[str, Any]:
    """Values of all responses of the scene."""
    return {name: response.value(solution) for name, response in responses_of(solution.system.scene, moving(solution)).items()}


def evaluate_with_gradients(solution: Solution) -> tuple[dict[str, Any], dict[str, dict[str, float]]]:
    """Values of all responses of the scene, and their gradients by the derivatives that the solution holds."""
    found = {
        name: response.evaluate(solution) for name, response in responses_of(solution.system.scene, moving(solution)).items()
    }
    gradients = by_name(solution.system.design, found, (slopes for _, slopes in found.values()))
    return {name: value for name, (value, _) in found.items()}, gradients


def values_of(scene: Scene, kind: Kind) -> dict[str, Any]:
    """Values of all responses after one run, without derivatives."""
    return evaluate_responses(solve(prepare(scene), kind))


def direct(scene: Scene, design: list[str], kind: Kind, progress: Progress | None = None, system: System | None = None) -> Result:
    """Responses with gradients by direct differentiation; `system` is the scene with these design variables, if it is compiled already.

    The scene is solved without derivatives too, so that the price of the gradients is measured and not guessed.
    """
    system, primal_system = system or prepare(scene, design), prepare(scene)
    primal, _ = timed(primal_system, kind)
    total, solution = timed(system, kind, progress)
    extra = solution.wall.get("sensitivity", max(total - primal, 0.0))
    return result(scene, solution, *evaluate_with_gradients(solution), "direct", primal, extra)


def timed(system: System, kind: Kind, progress: Progress | None = None) -> tuple[float, Solution]:
    """Time of a run, and its solution.

    The first run also loads compiled code, so a short one is repeated and the median of the repetitions taken.
    """
    return repeated(lambda told: solve(system, kind, told), progress)


def repeated(work: Callable[[Progress | None], T], progress: Progress | None = None) -> tuple[float, T]:
    """Time of some work, measured as `timed` does, and what it returned; its first repetition reports progress.

    A repetition that had to compile anything does not count.
    """
    with watched_compilation() as compiled:
        first, found = _clocked(work, progress)
    times: list[float] = []
    while (compiled.functions and not times) or (len(times) < REPEATS and first + sum(times) < WORTH_REPEATING):
        seconds, found = _clocked(work, None)
        times.append(seconds)
    return median(times or [first]), found


def _clocked(work: Callable[[Progress | None], T], progress: Progress | None) -> tuple[float, T]:
    begun = clock.perf_counter()
    found = work(progress)
    return clock.perf_counter() - begun, found


def by_name(design: Design, responses: Iterable[str], slopes: Iterable[np.ndarray]) -> dict[str, dict[str, float]]:
    """Derivatives (n_x,) of each response as response -> variable -> derivative."""
    pairs = zip(responses, slopes, strict=True)
    return {name: dict(zip(design.names, map(float, each), strict=True)) for name, each in pairs}


def result(
    scene: Scene,
    solution: Solution,
    values: dict[str, Any],
    gradients: dict[str, dict[str, float]],
    method: str,
    primal: float,
    extra: float,
) -> Result:
    """Add the units."""
    units = {name: response.unit(scene.units) for name, response in responses_of(scene, moving(solution)).items()}
    return Result(
        {name: float(np.real(value)) for name, value in values.items()}, units, gradients, method, solution, primal, extra
    )
