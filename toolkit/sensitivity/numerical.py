"""Gradients by repeated runs: the methods that judge the analytical ones, or serve where those do not exist.

With the step h:

    complex step         df/dx = Im f(x + i h) / h,  h = 1e-30: exact to round-off; the run is plain Python, some 1000 times slower
    forward difference   [f(x + h) - f(x)] / h,       h = 1e-6 |x| as in the paper
    central difference   [f(x + h) - f(x - h)] / 2h,  h = 1e-5 |x|
"""

from __future__ import annotations

import time
from functools import partial
from typing import Any

import numpy as np

from toolkit.analyses.run_start import start_at_rest
from toolkit.analyses.statics import equilibrium_beside
from toolkit.analyses.transient import simulate
from toolkit.compilation.quantities import STEP
from toolkit.description.design import DesignVariable
from toolkit.description.run_options import RunOptions
from toolkit.foundation.compiled.compile_watch import watched_compilation
from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene
from toolkit.sensitivity.clock import Progress, price
from toolkit.sensitivity.compiled import Compiled
from toolkit.sensitivity.direct import again
from toolkit.sensitivity.errors.step_error import Gradients, Values
from toolkit.sensitivity.evaluation import evaluate_responses, values_of
from toolkit.sensitivity.method_names import METHODS, NUMERICAL
from toolkit.sensitivity.preparation import Kind, check_kind, check_names, frozen, prepare, solve
from toolkit.sensitivity.run import Run, run_of
from toolkit.sensitivity.sizes import typical_size
from toolkit.solvers.start.kept_start import refuse_differences
from toolkit.system.solution import Solution

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
            gradients[name][variable.name] = float(value)
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
    base: dict[str, Any],
    relative_step: float | None = None,
    known: Solution | None = None,
    along: Solution | None = None,
) -> dict[str, Any]:
    """Derivatives of all responses by one variable, by repeated runs.

    A complex step need not follow the path to a `known` equilibrium again, which is that of the scene or the one that a motion
    starts in; `along` a known motion it takes fewer iterations.
    """

    def shifted(step: complex) -> dict[str, Any]:
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
