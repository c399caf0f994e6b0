"""Gradients by direct differentiation: the run carries the derivatives of its states along."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from toolkit.analyses.run_start import known_start
from toolkit.analyses.transient import simulate
from toolkit.description.run_options import RunOptions
from toolkit.foundation.compiled.compile_watch import watched_compilation
from toolkit.foundation.processes.one_thread import one_thread
from toolkit.scene.scene import Scene
from toolkit.sensitivity.clock import Progress, price
from toolkit.sensitivity.compiled import Compiled
from toolkit.sensitivity.errors.step_error import Repeat
from toolkit.sensitivity.evaluation import evaluate_responses, evaluate_with_gradients
from toolkit.sensitivity.preparation import ANALYSES, Kind, check_kind, check_names, frozen, solve
from toolkit.sensitivity.run import Run, run_of
from toolkit.solvers.start.initial_conditions import Motion, State
from toolkit.system.solution import Solution
from toolkit.system.system import System


@one_thread()
def direct(scene: Scene, design: list[str], kind: Kind, progress: Progress | None = None, timed: bool = False) -> Run:
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
    timed
        Whether to measure what a run costs, without derivatives and with them, as `clock.price`; by default the scene is solved once.

    Raises
    ------
    InputError
        There is no analysis of that kind, or no variable of that name.
    """
    check_kind(kind)
    check_names(design)
    return by_direct(Compiled(scene, tuple(design)), kind, progress, timed)


def by_direct(compiled: Compiled, kind: Kind, progress: Progress | None = None, timed: bool = False) -> Run:
    """Responses of a compiled scene with gradients by direct differentiation."""
    primal = None
    if timed:
        with watched_compilation() as watch:
            solve(compiled.primal, kind)
        primal = price(watch, timed, partial(solve, compiled.primal, kind))
    with watched_compilation() as watch:
        solution = ANALYSES[kind](compiled.full, progress=progress)
    total, extra = price(watch, timed, partial(solve, compiled.full, kind)), solution.sensitivity_seconds
    if extra is None:
        extra = None if primal is None else max(total - primal, 0.0)
    elif primal is None:
        primal = total - extra
    found = evaluated(solution, True, partial(again, compiled.full, known=known_start(solution)), primal, extra)
    return replace(found, enriched=partial(enriched, compiled, kind, solution, by_direct))


def values_alone(compiled: Compiled, kind: Kind) -> Run:
    """Responses of a compiled scene without gradients."""
    return with_values(compiled, kind, solve(compiled.primal, kind))


def with_values(compiled: Compiled, kind: Kind, solution: Solution, seconds: float | None = None) -> Run:
    """Responses of a compiled scene that was solved without gradients, in so many seconds."""
    found = evaluated(solution, False, partial(again, compiled.primal, known=known_start(solution)), seconds, 0.0)
    return replace(found, enriched=partial(enriched, compiled, kind, solution, values_alone))


def enriched(
    compiled: Compiled, kind: Kind, solution: Solution, method: Callable[[Compiled, Kind], Run]
) -> tuple[dict[str, Any], dict[str, dict[str, float]]]:
    """Values and gradients with more shapes in frozen bodies, and the same steps."""
    other = compiled.enriched()
    if kind == "transient" and compiled.scene.solver.local_error is not None:
        other = Compiled(frozen(other.scene, solution), other.names)
    found = method(other, kind)
    return found.values, found.gradients


def evaluated(
    solution: Solution,
    gradients: bool,
    repeat: Repeat | None = None,
    primal: float | None = None,
    extra: float | None = None,
) -> Run:
    """Run of a solution, with the gradients that its derivatives give or without; other arguments as the fields of `Run`."""
    values, slopes = evaluate_with_gradients(solution) if gradients else (evaluate_responses(solution), {})
    return run_of(solution, values, slopes, "direct" if gradients else "none", primal, extra, repeat)


def again(
    system: System,
    options: RunOptions,
    q: np.ndarray | None = None,
    v: np.ndarray | None = None,
    known: Motion | State | None = None,
) -> tuple[dict[str, Any], dict[str, dict[str, float]]]:
    """Values of a motion, and gradients by direct differentiation if the system has design variables, with other options; `q` and `v` are
    its start if it is not the scene's, `known` what was found for it."""
    values, gradients = evaluate_with_gradients(simulate(system, options, q, v, known=known))
    return values, gradients if system.n_x else {}
