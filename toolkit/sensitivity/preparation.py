"""What precedes a run: the scene compiled with what its responses look at, and names and words checked."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Literal, get_args

from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import InputError
from toolkit.responses.response import Response
from toolkit.scene.resolution import resolve
from toolkit.scene.scene import Scene
from toolkit.sensitivity.clock import Progress
from toolkit.system.solution import Solution
from toolkit.system.system import System, compile_scene

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
