"""Gradients by repeated runs: the methods that judge the analytical ones, or serve where those do not exist.

With the step h:

    complex step         df/dx = Im f(x + i h) / h,  h = 1e-30: exact to round-off; the run is plain Python, some 1000 times slower
    forward difference   [f(x + h) - f(x)] / h,       h = 1e-6 |x| as in the paper
    central difference   [f(x + h) - f(x - h)] / 2h,  h = 1e-5 |x|
"""

from __future__ import annotations

import time as clock
from functools import partial
from typing import Any

import numpy as np

from toolkit.analyses.statics import equilibrium_beside
from toolkit.compilation.quantities import STEP
from toolkit.description.design import DesignVariable
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene
from toolkit.sensitivity.analysis import (
    Kind,
    Progress,
    Result,
    again,
    check_kind,
    check_names,
    evaluate_responses,
    frozen,
    prepare,
    result,
    timed,
    values_of,
)
from toolkit.sensitivity.errors.step_error import Gradients, Values
from toolkit.sensitivity.method_names import METHODS, NUMERICAL
from toolkit.sensitivity.sizes import typical_size
from toolkit.system.solution import Solution

RELATIVE_STEP = {"forward-difference": 1e-6, "central-difference": 1e-5}


def numerical(
    scene: Scene, design: list[str], kind: Kind, method: str, progress: Progress | None = None, relative_step: float | None = None
) -> Result:
    """Responses with gradients by repeated runs of the whole analysis.

    Raises
    ------
    InputError
        The method is unknown.
    """
    if method not in NUMERICAL:
        raise InputError(f"unknown method {method!r}; available: {', '.join(METHODS)}.")
    check_kind(kind)
    check_names(design)
    variables = scene.design_variables(design)
    system = prepare(scene)
    primal, solution = timed(system, kind)
    base, scene = evaluate_responses(solution), frozen(scene, solution)
    gradients: dict[str, dict[str, float]] = {name: {} for name in base}
    begun = clock.perf_counter()
    for k, variable in enumerate(variables):
        for name, value in derivative(scene, variable, kind, method, base, relative_step, solution).items():
            gradients[name][variable.name] = float(value)
        if progress:
            progress(k + 1, len(variables))
    extra = clock.perf_counter() - begun
    return result(scene, solution, base, gradients, method, primal, extra, partial(_again_directly, scene, design))


def _again_directly(scene: Scene, design: list[str], options: RunOptions) -> tuple[Values, Gradients]:
    """By direct differentiation: what other steps change about a derivative is far more than both methods differ by."""
    return again(prepare(scene, design), options)


def derivative(
    scene: Scene,
    variable: DesignVariable,
    kind: Kind,
    method: str,
    base: dict[str, Any],
    relative_step: float | None = None,
    known: Solution | None = None,
) -> dict[str, Any]:
    """Derivative of all responses by one variable; beside a `known` equilibrium a complex step need not follow the path there again."""

    def shifted(step: complex) -> dict[str, Any]:
        return values_of(scene.with_number(variable.path, variable.value + step), kind)

    if method == "complex-step" and kind == "static" and known is not None:
        beside = equilibrium_beside(prepare(scene.with_number(variable.path, variable.value + 1j * STEP)), known)
        return {name: np.imag(value) / STEP for name, value in evaluate_responses(beside).items()}
    if method == "complex-step":
        return {name: np.imag(value) / STEP for name, value in shifted(1j * STEP).items()}
    h = (RELATIVE_STEP[method] if relative_step is None else relative_step) * typical_size(scene, variable)
    up = shifted(h)
    if method == "forward-difference":
        return {name: (value - base[name]) / h for name, value in up.items()}
    down = shifted(-h)
    return {name: (value - down[name]) / (2 * h) for name, value in up.items()}
