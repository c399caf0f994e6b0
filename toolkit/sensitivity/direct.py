"""Gradients by direct differentiation: the run carries the derivatives of its states along."""

from __future__ import annotations

from functools import partial
from typing import Any

from toolkit.analyses.transient import simulate
from toolkit.description.run_options import RunOptions
from toolkit.scene.scene import Scene
from toolkit.sensitivity.clock import Clock, Progress, once
from toolkit.sensitivity.compiled import Compiled
from toolkit.sensitivity.errors.step_error import Repeat
from toolkit.sensitivity.evaluation import evaluate_responses, evaluate_with_gradients
from toolkit.sensitivity.preparation import Kind, check_kind, check_names, solve
from toolkit.sensitivity.result import Result, result
from toolkit.system.solution import Solution
from toolkit.system.system import System


def direct(scene: Scene, design: list[str], kind: Kind, progress: Progress | None = None, clock: Clock = once) -> Result:
    """Responses of a scene with gradients by direct differentiation.

    Parameters
    ----------
    scene
        The scene.
    design
        Design variables, by short name or path.
    kind
        "transient" or "static".
    progress
        Called with the steps done and the steps in all.
    clock
        `clock.repeated` measures what a run costs, without derivatives and with them; by default the scene is solved once.

    Raises
    ------
    InputError
        There is no analysis of that kind, or no variable of that name.
    """
    check_kind(kind)
    check_names(design)
    return by_direct(Compiled(scene, tuple(design)), kind, progress, clock)


def by_direct(compiled: Compiled, kind: Kind, progress: Progress | None = None, clock: Clock = once) -> Result:
    """The same of a compiled scene."""
    primal = None if clock is once else clock(partial(solve, compiled.primal, kind), None)[0]
    total, solution = clock(partial(solve, compiled.full, kind), progress)
    extra = solution.wall.get("sensitivity")
    if extra is None:
        extra = None if primal is None else max(total - primal, 0.0)
    elif primal is None:
        primal = total - extra
    evaluated = evaluate_with_gradients(solution)
    return result(compiled.scene, solution, *evaluated, "direct", primal, extra, partial(again, compiled.full))


def evaluated(scene: Scene, solution: Solution, gradients: bool, repeat: Repeat | None = None) -> Result:
    """The result of a run that was solved without a look at the clock; `repeat` as in `Result`."""
    values, slopes = evaluate_with_gradients(solution) if gradients else (evaluate_responses(solution), {})
    return result(scene, solution, values, slopes, "direct" if gradients else "none", None, None, repeat)


def values_alone(compiled: Compiled, kind: Kind, progress: Progress | None = None, clock: Clock = once) -> Result:
    """Responses of a compiled scene without gradients."""
    primal, solution = clock(partial(solve, compiled.primal, kind), progress)
    values = evaluate_responses(solution)
    return result(compiled.scene, solution, values, {}, "none", primal, 0.0, partial(again, compiled.primal))


def again(system: System, options: RunOptions) -> tuple[dict[str, Any], dict[str, dict[str, float]]]:
    """Values of a motion, and gradients by direct differentiation if the system has design variables, with other options."""
    values, gradients = evaluate_with_gradients(simulate(system, options))
    return values, gradients if system.n_x else {}
