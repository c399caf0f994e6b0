"""Checks of gradients that a user can call: Taylor test, V-curve of differences, comparison of methods."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from toolkit.errors import ConvergenceError, InputError, ToolkitError
from toolkit.scene import Scene
from toolkit.sensitivity.adjoint import adjoint_gradients, by_name
from toolkit.sensitivity.analysis import Kind, Progress, Result, direct, values_of
from toolkit.sensitivity.numerical import numerical, typical_size

Gradients = dict[str, dict[str, float]]
NEGLIGIBLE = 1e-6
"""Part of a response's largest change (by a variable's own size) below which a derivative is compared with that change instead:
what is far smaller than its neighbours is made of their round-off."""
MOST_DIGITS = 16.0
UNSEEN = 1e-11
"""Part of a value below which a remainder is round-off of the run that computed it."""


class DisagreementError(ToolkitError, ArithmeticError):
    """Two methods that are exact give different gradients: one of them is wrong."""


@dataclass(frozen=True)
class Certificate:
    """What independent methods say about the gradients of a scene.

    Attributes
    ----------
    exact : Result
        By direct differentiation.
    differences : dict
        "adjoint" and "complex-step" -> response -> variable -> relative difference to `exact`.
    rates : dict
        Response -> rate at which Taylor's remainder vanishes; 2 if the gradient is right and the response smooth, infinite if the
        response is linear.
    curve : list of pairs
        Relative step of central differences, and their largest relative difference to `exact`.
    """

    exact: Result
    differences: dict[str, Gradients]
    rates: dict[str, float]
    curve: list[tuple[float, float]]

    def check(self, tolerance: float) -> None:
        """Refuse gradients on which the exact methods disagree.

        Raises
        ------
        DisagreementError
            Names method, response and variable.
        """
        for method, found in self.differences.items():
            for response, slopes in found.items():
                for variable, difference in slopes.items():
                    if difference > tolerance:
                        raise DisagreementError(
                            f"direct differentiation and {method} disagree on d {response} / d {variable}: relative difference "
                            f"{difference:.1e}, more than {tolerance:.1e}. Tighten solver.tolerance; if that does not help, one of them "
                            "is wrong: check components of your own with toolkit.conformance, and report what remains."
                        )


def certify(scene: Scene, design: list[str], kind: Kind, progress: Progress = lambda *_: None) -> Certificate:
    """Compare direct differentiation with the adjoint, a complex step, Taylor's remainder and central differences.

    Raises
    ------
    InputError
        As `direct`.
    """
    exact = direct(scene, design, kind)
    if not exact.gradients or not design:
        raise InputError("there is nothing to compare: the scene needs a table [responses] and a design variable.")
    progress(1, 5)
    stepped = numerical(scene, design, kind, "complex-step").gradients
    progress(2, 5)
    return compare(exact, kind, stepped, lambda done, total: progress(2 + done, 2 + total))


def compare(exact: Result, kind: Kind, stepped: Gradients, progress: Progress = lambda *_: None) -> Certificate:
    """The certificate of a result of direct differentiation, whose gradients by a complex step are at hand."""
    system = exact.solution.system
    scene, design = system.scene, list(system.design.names)
    backwards = by_name(system, *adjoint_gradients(system, exact.solution))
    progress(1, 3)
    rates = taylor_rates(scene, design, kind, exact=exact)
    progress(2, 3)
    curve = step_study(scene, design, kind, exact=exact)
    progress(3, 3)
    others = {"adjoint": backwards, "complex-step": stepped}
    return Certificate(exact, {method: _differences(scene, exact, other) for method, other in others.items()}, rates, curve)


def digits(difference: float) -> float:
    """How many decimal digits agree, 16 at most; nan where there was nothing to compare."""
    return float(min(MOST_DIGITS, -np.log10(difference))) if difference > 0 else (MOST_DIGITS if difference == 0 else np.nan)


def _differences(scene: Scene, exact: Result, other: Gradients) -> Gradients:
    """Relative differences, response by response and variable by variable.

    A derivative is compared with itself, or with what is far larger and only round-off away: a part `NEGLIGIBLE` of the response's
    largest change, and of its value, each per the variable's own size.
    """
    names = list(next(iter(exact.gradients.values()), {}))
    sizes = {variable.name: typical_size(scene, variable) for variable in scene.design_variables(names)}
    found: Gradients = {}
    for response, slopes in exact.gradients.items():
        changes = [abs(slope) * sizes[x] for x, slope in slopes.items()]
        largest = max([*changes, abs(exact.values[response]), np.finfo(float).tiny])
        scales = {x: max(abs(slope), NEGLIGIBLE * largest / sizes[x]) for x, slope in slopes.items()}
        found[response] = {x: abs(slope - other[response][x]) / scales[x] for x, slope in slopes.items()}
    return found


def taylor_rates(
    scene: Scene, design: list[str], kind: Kind, steps: Sequence[float] = (2e-3, 1e-3, 5e-4), exact: Result | None = None
) -> dict[str, float]:
    """Rate at which |f(x + h d) - f(x) - h g . d| vanishes, d = x (all variables by the same part h): 2 if g is the gradient.

    `exact` is the result of direct differentiation, computed here if there is none.

    Returns
    -------
    rates : dict
        Response -> fitted rate; infinite where every remainder is round-off, so that nothing is left to vanish.
    """
    variables = scene.design_variables(design)
    base = exact or direct(scene, design, kind)
    sizes = {variable.name: typical_size(scene, variable) for variable in variables}
    remainders: dict[str, list[float]] = {name: [] for name in base.values}
    for h in steps:
        moved = scene
        for variable in variables:
            moved = moved.with_number(variable.path, variable.value + h * sizes[variable.name])
        for name, value in values_of(moved, kind).items():
            slope = sum(base.gradients[name][variable.name] * sizes[variable.name] for variable in variables)
            remainders[name].append(abs(value - base.values[name] - h * slope))
    return {name: _rate(steps, values, abs(base.values[name])) for name, values in remainders.items()}


def _rate(steps: Sequence[float], remainders: list[float], value: float) -> float:
    if max(remainders) <= UNSEEN * value or min(remainders) == 0:
        return np.inf
    return float(np.polyfit(np.log(steps), np.log(remainders), 1)[0])


def step_study(
    scene: Scene,
    design: list[str],
    kind: Kind,
    steps: Sequence[float] = tuple(10.0 ** np.arange(-2, -11, -1.0)),
    exact: Result | None = None,
) -> list[tuple[float, float]]:
    """Central differences against direct differentiation over relative steps: the V of truncation and round-off.

    `exact` as for `taylor_rates`.

    Returns
    -------
    study : list of pairs
        Relative step and largest relative difference; a step so large that its runs fail is left out.
    """
    exact, study = exact or direct(scene, design, kind), []
    for step in steps:
        try:
            found = numerical(scene, design, kind, "central-difference", None, step).gradients
        except (ConvergenceError, InputError):
            continue
        differences = _differences(scene, exact, found)
        study.append((step, max((value for slopes in differences.values() for value in slopes.values()), default=0.0)))
    return study
