"""What precedes a run: the scene compiled with what its responses look at, and names and words checked."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Collection, Iterable, Mapping
from statistics import median
from typing import Literal, Protocol, get_args

import numpy as np

from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.description.design import Design, DesignVariable
from toolkit.description.run_options import RunOptions
from toolkit.foundation.compiled.compile_watch import CompileWatch
from toolkit.foundation.errors import InputError
from toolkit.foundation.value_types import Scalar
from toolkit.responses.response import Response
from toolkit.scene.resolution import loaded, resolve
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.system.system import System, compile_scene

Progress = Callable[[int, int], None]

REPEATED_RUNS, REPEATING_SECONDS = 5, 1.0
"""A run is repeated so often, as long as all together take less than this, in s."""


def price(watch: CompileWatch, timed: bool, work: Callable[[], object]) -> float:
    """Time of work that was watched once, in s, without the compilation of formulas.

    The first time also loads compiled code; if the work is `timed`, a short one is repeated and the median of the repetitions taken.
    """
    if not timed:
        return watch.rest
    first, times = watch.rest + watch.seconds, list[float]()
    while (watch.functions and not times) or (len(times) < REPEATED_RUNS and first + sum(times) < REPEATING_SECONDS):
        begun = clock.perf_counter()
        work()
        times.append(clock.perf_counter() - begun)
    return median(times or [first])


Kind = Literal["transient", "static"]
ANALYSES: dict[Kind, Callable[..., Solution]] = {"transient": simulate, "static": solve_statics}
"""Kind of analysis -> function that solves a system."""


def responses_of(scene: Scene, moving: bool = True) -> dict[str, Response]:
    """The scene's responses, as far as a motion has them; without motion those that a state at rest has."""
    known = {name: response for name, response in scene.responses.items() if isinstance(response, Response)}
    return {name: response for name, response in known.items() if not (response.needs_rest if moving else response.needs_motion)}


def moving(solution: Solution) -> bool:
    """Whether it is a transient solution."""
    return len(solution.times) > 1


def frozen(scene: Scene, solution: Solution, halvings: int = 0) -> Scene:
    """The scene with the times of its run, where that has chosen or halved steps: other designs are solved with the same steps, as
    derivatives suppose."""
    if not moving(solution) or (scene.solver.local_error is None and not solution.halved):
        return scene
    chosen = {"times": tuple(map(float, solution.whole_run)), "local_error": None, "halvings": halvings}
    return scene.model_copy(update={"solver": scene.solver.model_copy(update=chosen)})


def prepare(scene: Scene, design: list[str] | None = None) -> System:
    """Compile a scene with what its responses look at, after they had a look at the scene."""
    scene = resolve(scene)
    responses = [*{**responses_of(scene), **responses_of(scene, moving=False)}.values()]
    for response in responses:
        response.check(scene)
    markers = [marker for response in responses for marker in response.grips(scene)]
    return compile_scene(scene, design, tuple(dict.fromkeys(markers)))


def solve(system: System, kind: Kind, progress: Progress | None = None, options: RunOptions | None = None) -> Solution:
    """Transient or static solution of a system; by default with the scene's own options.

    Raises
    ------
    InputError
        There is no analysis of that kind.
    """
    check_kind(kind)
    return ANALYSES[kind](system, options, progress=progress)


def check_kind(kind: str) -> None:
    """Refuse an analysis that does not exist, as `solve`."""
    if kind not in get_args(Kind):
        raise InputError(f"there is no analysis {kind!r}. Choose one of: {', '.join(get_args(Kind))}.")


def check_names(design: Collection[str]) -> None:
    """Refuse what are no names of design variables, above all one text: it would be taken for its letters.

    Raises
    ------
    InputError
        It is one text, or something in it is none.
    """
    if isinstance(design, str):
        raise InputError(f"design variables are a list of names, not the text {design!r}. Write [{design!r}].")
    if not all(isinstance(name, str) for name in design):
        raise InputError("design variables are names: short names of the scene, or paths of its numbers.")


def evaluate_responses(solution: Solution) -> dict[str, Scalar]:
    """Values of all responses of the scene."""
    return {name: response.value(solution) for name, response in responses_of(solution.system.scene, moving(solution)).items()}


def evaluate_with_gradients(solution: Solution) -> tuple[dict[str, Scalar], dict[str, dict[str, float]]]:
    """Values of all responses of the scene, and their gradients by the derivatives that the solution holds."""
    found = {
        name: response.evaluate(solution) for name, response in responses_of(solution.system.scene, moving(solution)).items()
    }
    gradients = by_name(solution.system.design, found, (slopes for _, slopes in found.values()))
    return {name: value for name, (value, _) in found.items()}, gradients


def values_of(scene: Scene, kind: Kind) -> dict[str, Scalar]:
    """Values of all responses after one run, without derivatives."""
    return evaluate_responses(solve(prepare(scene), kind))


def by_name(design: Design, responses: Iterable[str], slopes: Iterable[np.ndarray]) -> dict[str, dict[str, float]]:
    """Derivatives (n_x,) of each response as response -> variable -> derivative."""
    pairs = zip(responses, slopes, strict=True)
    return {name: dict(zip(design.names, map(float, each), strict=True)) for name, each in pairs}


EPS = float(np.finfo(float).eps)


class Differentiated(Protocol):
    """What knows values and gradients of responses."""

    @property
    def values(self) -> dict[str, Scalar]:
        """Response -> value."""

    @property
    def gradients(self) -> dict[str, dict[str, float]]:
        """Response -> variable -> derivative."""


def typical_size(scene: Scene, variable: DesignVariable) -> float:
    """What a relative step refers to: the value, or for a zero the model size (points) or one."""
    if variable.value != 0:
        return abs(variable.value)
    return loaded(scene).size if variable.path.startswith("points.") else 1.0


def variable_sizes(scene: Scene, exact: Differentiated) -> dict[str, float]:
    """What a relative step of each variable refers to.

    It is the value; for a zero of a point the model size; for another zero the change that moves no response further than the others
    can, or than its value (one in the scene's units could be anything, as 1 mm/s, or 1 s of damping), and no body further than the
    model size or by more than 1 rad.
    """
    variables = list(scene.design_variables(list(next(iter(exact.gradients.values()), {}))))
    known = {v.name: typical_size(scene, v) for v in variables if v.value != 0 or v.path.startswith("points.")}
    scales = response_scales(exact, known)
    sizes = {}
    for variable in variables:
        slopes = {f: abs(slopes[variable.name]) for f, slopes in exact.gradients.items()}
        allowed = [scales[f] / slope for f, slope in slopes.items() if slope > EPS * scales[f]]
        sizes[variable.name] = known.get(variable.name, min([*allowed, _reach(scene, variable.path)]))
    return sizes


def _reach(scene: Scene, path: str) -> float:
    """Largest sensible change of a place, angle, velocity or time; 1 in the scene's units for what is none of these."""
    group, owner, *name = path.split(".")
    time = scene.solver.end_time
    if name[:1] in (["velocity"], ["angular_velocity"]):
        said = getattr(scene, group)[owner].quantity_of(name[0])
        place = int(name[1]) if name[1:] else 0
        return (1.0 if said is not None and said.measure(place).angle else loaded(scene).size) / time
    if name[:1] in (["position"], ["deflection"]):
        return loaded(scene).size
    if name[:1] == ["elastic_velocity"]:
        return loaded(scene).size / time
    return time if name[-1] in ("start", "duration") else 1.0


def response_scales(exact: Differentiated, sizes: Mapping[str, float]) -> dict[str, float]:
    """Response -> the largest of its value and of its changes by the variables that have a size."""
    return {
        f: max([abs(exact.values[f]), *(abs(slopes[x]) * size for x, size in sizes.items())], default=0.0)
        for f, slopes in exact.gradients.items()
    }
