"""Gradients by direct differentiation: the run carries the derivatives of its states along.

Gradients by repeated runs: the methods that judge the analytical ones, or serve where those do not exist.

With the step h:

    complex step         df/dx = Im f(x + i h) / h,  h = 1e-30: exact to round-off; the run is plain Python, some 1000 times slower
    forward difference   [f(x + h) - f(x)] / h,       h = 1e-6 |x| as in the paper
    central difference   [f(x + h) - f(x - h)] / 2h,  h = 1e-5 |x|
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from toolkit.analyses.run_start import known_start, start_at_rest
from toolkit.analyses.sensitivity.compiled import Compiled
from toolkit.analyses.sensitivity.errors.step_error import Gradients, Repeat, Values
from toolkit.analyses.sensitivity.method_names import METHODS, NUMERICAL
from toolkit.analyses.sensitivity.preparation import (
    ANALYSES,
    Kind,
    Progress,
    check_kind,
    check_names,
    evaluate_responses,
    evaluate_with_gradients,
    frozen,
    prepare,
    price,
    solve,
    typical_size,
    values_of,
)
from toolkit.analyses.sensitivity.run import Run, run_of
from toolkit.analyses.statics import equilibrium_beside
from toolkit.analyses.transient import simulate
from toolkit.description.design import DesignVariable
from toolkit.description.run_options import RunOptions
from toolkit.foundation.compiled.compile_watch import watched_compilation
from toolkit.foundation.errors import InputError
from toolkit.foundation.processes import one_thread
from toolkit.foundation.value_types import Scalar
from toolkit.responses.extremes import at_peaks
from toolkit.scene.scene import Scene
from toolkit.solvers.start.initial_conditions import ConsistentMotion, State
from toolkit.solvers.start.kept_start import refuse_differences
from toolkit.system.quantities import STEP
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
        Whether to measure what a run costs, without derivatives and with them, as `preparation.price`; by default the scene is solved once.

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
) -> tuple[dict[str, float], dict[str, dict[str, float]]]:
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
    known: ConsistentMotion | State | None = None,
) -> tuple[dict[str, Scalar], dict[str, dict[str, float]]]:
    """Values of a motion, and gradients by direct differentiation if the system has design variables, with other options; `q` and `v` are
    its start if it is not the scene's, `known` what was found for it. Gradients of extremes are those at peaks between the steps."""
    solution = simulate(system, options, q, v, known=known)
    values, gradients = evaluate_with_gradients(solution)
    return values, at_peaks(gradients, solution) if system.n_x else {}


RELATIVE_STEP = {"forward-difference": 1e-6, "central-difference": 1e-5}


def numerical(
    scene: Scene,
    design: list[str],
    kind: Kind,
    method: str,
    progress: Progress | None = None,
    relative_step: float | None = None,
    timed: bool = False,
) -> Run:
    """Responses with gradients by repeated runs of the whole analysis; raises as `by_repetition`."""
    check_kind(kind)
    check_names(design)
    return by_repetition(Compiled(scene, tuple(design)), kind, method, progress, relative_step, timed)


def by_repetition(
    compiled: Compiled,
    kind: Kind,
    method: str,
    progress: Progress | None = None,
    relative_step: float | None = None,
    timed: bool = False,
) -> Run:
    """Responses with gradients of a compiled scene, by repeated runs of the whole analysis.

    Raises
    ------
    InputError
        The method is unknown.
    """
    if method not in NUMERICAL:
        raise InputError(f"unknown method {method!r}; available: {', '.join(METHODS)}.")
    variables = compiled.design
    if method in RELATIVE_STEP and kind == "transient":
        refuse_differences(compiled.scene, (path for variable in variables for path in variable.paths))
    with watched_compilation() as watch:
        solution = solve(compiled.primal, kind)
    primal = price(watch, timed, partial(solve, compiled.primal, kind))
    base, scene = evaluate_responses(solution), frozen(compiled.scene, solution)
    known = _equilibrium(compiled, kind, solution) if method == "complex-step" else None
    gradients: dict[str, dict[str, float]] = {name: {} for name in base}
    begun = time.perf_counter()
    for k, variable in enumerate(variables):
        for name, value in derivative(scene, variable, kind, method, base, relative_step, known, solution).items():
            gradients[name][variable.name] = float(np.real(value))
        if progress:
            progress(k + 1, len(variables))
    extra = time.perf_counter() - begun
    repeat = partial(_again_directly, scene, list(compiled.names))
    return run_of(solution, base, gradients, method, primal, extra, repeat)


def _again_directly(scene: Scene, design: list[str], options: RunOptions) -> tuple[Values, Gradients]:
    """Values and gradients with other options, by direct differentiation.

    Other steps change a derivative far more than both methods differ.
    """
    return again(prepare(scene, design), options)


def _equilibrium(compiled: Compiled, kind: Kind, solution: Solution) -> Solution | None:
    return solution if kind == "static" else start_at_rest(compiled.primal, compiled.scene.solver)


def derivative(
    scene: Scene,
    variable: DesignVariable,
    kind: Kind,
    method: str,
    base: Mapping[str, Scalar],
    relative_step: float | None = None,
    known: Solution | None = None,
    along: Solution | None = None,
) -> dict[str, Scalar]:
    """Derivatives of all responses by one variable, by repeated runs.

    A complex step need not follow the path to a `known` equilibrium again, which is that of the scene or the one that a motion
    starts in; `along` a known motion it takes fewer iterations.
    """

    def shifted(step: complex) -> dict[str, Scalar]:
        moved = scene.moved(variable, step)
        if not isinstance(step, complex) or (kind == "static" and not known):
            return values_of(moved, kind)
        system = prepare(moved)
        if kind == "static" and known:
            return evaluate_responses(equilibrium_beside(system, known))
        return evaluate_responses(simulate(system, beside=known, along=along))

    if method == "complex-step":
        return {name: np.imag(value) / STEP for name, value in shifted(1j * STEP).items()}
    h = (RELATIVE_STEP[method] if relative_step is None else relative_step) * typical_size(scene, variable)
    up = shifted(h)
    if method == "forward-difference":
        return {name: (value - base[name]) / h for name, value in up.items()}
    down = shifted(-h)
    return {name: (value - down[name]) / (2 * h) for name, value in up.items()}
