"""One run of a scene, transient or static, and its responses with gradients."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property, partial
from statistics import median
from typing import Any, Literal, TypeVar, get_args

import numpy as np

from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.description.design import Design
from toolkit.description.run_options import RunOptions
from toolkit.foundation.compiled.compile_watch import watched_compilation
from toolkit.foundation.errors import InputError
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.responses.folded_rotations import folded_rotations
from toolkit.responses.magnitude import largest_slopes, magnitude_that_counts
from toolkit.responses.response import Response
from toolkit.scene.scene import Scene
from toolkit.sensitivity.errors.force_cautions import force_cautions
from toolkit.sensitivity.errors.step_cautions import step_cautions
from toolkit.sensitivity.errors.step_error import Repeat, StepError, step_error
from toolkit.sensitivity.sizes import variable_sizes
from toolkit.system.solution import Solution
from toolkit.system.system import System, compile_scene
from toolkit.validity.judge import cautions, measures
from toolkit.validity.motion.motion import SUSPICIOUS

T = TypeVar("T")
Kind = Literal["transient", "static"]
Progress = Callable[[int, int], None]

UNIMPORTANT = 0.02
"""A derivative that changes its response by less than this part of its magnitude, where the variable changes by all of its size, is
compared with such a change instead of with itself."""
REPEATS, WORTH_REPEATING = 5, 1.0
"""A run is repeated so often, as long as all together take less than this, in s."""


@dataclass(frozen=True)
class Result:
    """Values, units and gradients of the responses; `solution` is the run that they come from, wall times in s.

    `reason` says why the method was chosen, if nobody named one. `repeat` is the same analysis with other options: `verdict` needs it.
    """

    values: dict[str, Any]
    units: dict[str, str]
    gradients: dict[str, dict[str, float]]
    method: str
    solution: Solution
    wall_primal: float
    wall_sensitivity: float
    reason: str = ""
    repeat: Repeat | None = field(default=None, compare=False)

    @cached_property
    def measures(self) -> dict[str, Any]:
        """What the states tell about how exactly they were found, see `toolkit.validity.judge.measures`."""
        return measures(self.solution)

    @cached_property
    def step_error(self) -> StepError | None:
        """Estimated errors by the length of the steps, measured by the same run with steps of another length when it is first asked for."""
        scene, solution = self.solution.system.scene, self.solution
        if self.repeat is None or not moving(solution) or not self.values:
            return None
        balance, responses = self.measures["energy_balance"], responses_of(scene)
        suspicious = not max(balance.values(), default=0.0) <= SUSPICIOUS
        scales = {name: magnitude_that_counts(each, solution, self.values[name]) for name, each in responses.items()}
        return step_error(solution, self.values, self.gradients, scales, self._slope_scales(scales), self.repeat, suspicious)

    def _slope_scales(self, scales: dict[str, float]) -> dict[str, dict[str, float]]:
        """What errors of derivatives are compared with: the largest in the motion, or a small effect of all of the variable."""
        scene, solution = self.solution.system.scene, self.solution
        sizes, found = variable_sizes(scene, self) if self.gradients else {}, {}
        for f, response in responses_of(scene).items() if sizes else ():
            largest = dict(zip(solution.system.design.names, largest_slopes(response, solution), strict=True))
            found[f] = {x: max(largest.get(x, 0.0), UNIMPORTANT * scales[f] / size if size else 0.0) for x, size in sizes.items()}
        return found

    @cached_property
    def verdict(self) -> Verdict:
        """Whether values and gradients can be trusted, and why not; found out when it is first asked for, at the price of half a run."""
        if self.repeat is None or not moving(self.solution) or not self.values:
            found = self.solution.verdict
            return Verdict.of([*found.warnings, *self._undefined()], found.measures)
        measured, options = dict(self.measures), self.solution.options or self.solution.system.scene.solver
        about_steps = step_cautions(self.step_error, self.values, self.gradients, options)
        if self.step_error is not None:
            estimated = {
                "how": self.step_error.how,
                "relative_to": "the largest magnitude in the motion",
                "responses": self.step_error.values,
                "gradients": self.step_error.gradients,
            }
            measured["estimated_error"] = {**measured["estimated_error"], **estimated}
        about_forces = force_cautions(self.solution, measured["force_noise"])
        about_responses = (*about_forces, *about_steps, *folded_rotations(self.solution), *self._undefined())
        return Verdict.of([*cautions(self.solution, measured), *about_responses], measured)

    @property
    def warnings(self) -> tuple[Caution, ...]:
        """All that whoever reads the numbers has to know, doubts first."""
        return self.verdict.warnings

    def _undefined(self) -> Iterator[Caution]:
        """Values and derivatives that do not exist at this design."""
        numbers = {f"the value of {name}": value for name, value in self.values.items()}
        numbers |= {f"the derivative of {f} by {x}": slope for f, slopes in self.gradients.items() for x, slope in slopes.items()}
        for what, number in numbers.items():
            if not np.isfinite(number):
                yield Caution("undefined", f"{what} does not exist at this design; it is nan, in JSON null.", doubt=False)


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


def solve(system: System, kind: Kind, progress: Progress | None = None, options: RunOptions | None = None) -> Solution:
    """Transient or static solution of a system; by default with the scene's own options.

    Raises
    ------
    InputError
        There is no analysis of that kind.
    """
    check_kind(kind)
    return (solve_statics if kind == "static" else simulate)(system, options, progress=progress)


def check_kind(kind: str) -> None:
    """Refuse an analysis that does not exist, as `solve`."""
    if kind not in get_args(Kind):
        raise InputError(f"there is no analysis {kind!r}. Choose one of: {', '.join(get_args(Kind))}.")


def check_names(design: Iterable[str]) -> None:
    """Refuse a text where names of design variables belong: it would be taken for its letters.

    Raises
    ------
    InputError
        It is one text.
    """
    if isinstance(design, str):
        raise InputError(f"design variables are a list of names, not the text {design!r}. Write [{design!r}].")


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

    Raises
    ------
    InputError
        There is no analysis of that kind, or no variable of that name.
    """
    check_kind(kind)
    check_names(design)
    system, primal_system = system or prepare(scene, design), prepare(scene)
    primal, _ = timed(primal_system, kind)
    total, solution = timed(system, kind, progress)
    extra = solution.wall.get("sensitivity", max(total - primal, 0.0))
    return result(scene, solution, *evaluate_with_gradients(solution), "direct", primal, extra, partial(again, system))


def again(system: System, options: RunOptions) -> tuple[dict[str, Any], dict[str, dict[str, float]]]:
    """Values of a motion, and gradients by direct differentiation if the system has design variables, with other options."""
    values, gradients = evaluate_with_gradients(simulate(system, options))
    return values, gradients if system.n_x else {}


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
    repeat: Repeat | None = None,
) -> Result:
    """Add the units."""
    units = {name: response.unit(scene.units) for name, response in responses_of(scene, moving(solution)).items()}
    return Result(
        {name: float(np.real(value)) for name, value in values.items()},
        units,
        gradients,
        method,
        solution,
        primal,
        extra,
        repeat=repeat,
    )
