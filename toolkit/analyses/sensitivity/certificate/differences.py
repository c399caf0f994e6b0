"""Differences along one direction against a gradient: Taylor's remainder, and the V of truncation and round-off.

All variables move at once, x + h d, so that a study takes as many runs for hundreds of variables as for one.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from toolkit.analyses.sensitivity.adjoint import adjoint_gradients, has_adjoint
from toolkit.analyses.sensitivity.direct import direct
from toolkit.analyses.sensitivity.preparation import (
    Kind,
    by_name,
    frozen,
    moving,
    prepare,
    response_scales,
    responses_of,
    solve,
    values_of,
    variable_sizes,
)
from toolkit.analyses.sensitivity.run import Run
from toolkit.foundation.errors import ConvergenceError, InputError, SingularSystemError
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.solvers.start.kept_start import moves_kept_run
from toolkit.system.numbering import number
from toolkit.system.quantities import check_numbers, evaluate_quantities

Gradients = dict[str, dict[str, float]]
EPS = float(np.finfo(float).eps)
TRIAL_STEP = 1e-3
"""Relative step that tells whether a number can be moved at all."""
PERTURBATION = 8 * EPS
"""Relative change of the scene's numbers: enough to round everything anew, too little to change a gradient by itself."""
UNIMPORTANT_EFFECT = 1e-14
"""Part of a response's scale below which the effect of a variable (changed by its own size) cannot be told from none."""
SAMPLES, SPREAD_FACTOR = 4, 10.0
"""Runs with other last digits, and how much further apart than those two methods may be: each is one more such sample, of a
distribution with long tails."""


def round_off(scene: Scene, exact: Run, kind: Kind, unseen: float = UNIMPORTANT_EFFECT) -> Gradients:
    """Estimated round-off of each derivative, as an absolute number.

    The scene is solved with other last digits of its own numbers, and differentiated directly and backwards. All that differs is
    round-off; `SPREAD_FACTOR` times the largest difference seen is what two right methods may differ by, and at least the part
    `unseen` of what the response is or does."""
    design, rng = list(exact.solution.system.design.names), np.random.default_rng(1)
    scene = frozen(scene, exact.solution)
    # parameters of reduced models stay: other last digits of a thin body's matrices would be another body, not other round-off
    given = scene.model_parameters()
    paths = [path for path in scene.available_paths() if path not in given]
    sizes = variable_sizes(scene, exact)
    scales = response_scales(exact, sizes)
    found = {f: {x: unseen * scales[f] / sizes[x] for x in slopes} for f, slopes in exact.gradients.items()}
    for _ in range(SAMPLES):
        for sample in _by_exact_methods(rounded_anew(scene, paths, rng), design, kind):
            for f, slopes in sample.items():
                for x, slope in slopes.items():
                    found[f][x] = max(found[f][x], SPREAD_FACTOR * abs(slope - exact.gradients[f][x]))
    return found


def rounded_anew(scene: Scene, paths: list[str], rng: np.random.Generator) -> Scene:
    """The scene with other last digits of the numbers at these paths."""
    for path in paths:
        scene = scene.with_number(path, np.real(scene.number(path)) * (1 + PERTURBATION * rng.uniform(-1, 1)))
    return scene


def can_move(scene: Scene, path: str) -> bool:
    """Whether the runtime can give a number other values above and below: not if only preprocessing knows what follows from them."""
    value = np.real(scene.number(path))
    if path not in scene.model_parameters():
        return True
    try:
        for step in (-TRIAL_STEP, TRIAL_STEP):
            moved = loaded(scene.with_number(path, value + step * (abs(value) or 1.0)))
            evaluate_quantities(moved, number(moved))
            check_numbers(moved)
    except InputError:
        return False
    return True


def _by_exact_methods(scene: Scene, design: list[str], kind: Kind) -> list[Gradients]:
    """Gradients by direct differentiation and, where the run has one, by the adjoint."""
    system = prepare(scene, design)
    solution = solve(system, kind)
    responses = responses_of(scene, kind == "transient")
    slopes: list[Iterable[np.ndarray]] = [(response.evaluate(solution)[1] for response in responses.values())]
    if has_adjoint(scene, kind):
        slopes.append(adjoint_gradients(system, solution)[1].T)
    return [by_name(system.design, responses, each) for each in slopes]


FAILURES = (ConvergenceError, InputError, SingularSystemError)
REMAINDER_ROUND_OFF = 1e-11
"""Part of a response's scale below which a remainder is round-off of the run that computed it."""
GOLDEN = 0.6180339887498949
NEGLIGIBLE_DERIVATIVE = 1e-6
"""Part of a response's scale below which a directional derivative is compared with that instead of with itself."""


def direction(scene: Scene, exact: Run) -> dict[str, float]:
    """Variable -> its part of the direction: half to all of its size, evenly spread so that changes do not cancel by symmetry.

    Numbers that only preprocessing can change (or that are zero and cannot be negative) stay, and so do those that a kept start follows.
    """

    def free(path: str) -> bool:
        return can_move(scene, path) and not (moving(exact.solution) and moves_kept_run(scene, path))

    sizes, variables = variable_sizes(scene, exact), scene.design_variables(list(next(iter(exact.gradients.values()), {})))
    parts = {variable.name: 1 - 0.5 * (k * GOLDEN % 1) for k, variable in enumerate(variables)}
    return {v.name: parts[v.name] * sizes[v.name] for v in variables if all(map(free, v.paths))}


def moved(scene: Scene, along: dict[str, float], step: float) -> Scene:
    """The scene at x + step d."""
    for variable in scene.design_variables(list(along)):
        scene = scene.moved(variable, step * along[variable.name])
    return scene


def slopes_along(exact: Run, along: dict[str, float]) -> dict[str, float]:
    """Response -> its derivative along the direction."""
    return {f: sum(slopes[x] * part for x, part in along.items()) for f, slopes in exact.gradients.items()}


def taylor_rates(
    scene: Scene, design: list[str], kind: Kind, steps: Sequence[float] = (2e-3, 1e-3, 5e-4), exact: Run | None = None
) -> dict[str, float]:
    """Rate at which |f(x + h d) - f(x) - h g . d| vanishes along `direction`: 2 if g is the gradient.

    `exact` is the result of direct differentiation, computed here if there is none.

    Returns
    -------
    rates : dict
        Response -> fitted rate; infinite where every remainder is round-off, so that nothing is left to vanish; nan where the run fails at
        all but one of the steps.
    """
    base = exact or direct(scene, design, kind)
    scene = frozen(scene, base.solution)
    along = direction(scene, base)
    slopes, scales = slopes_along(base, along), response_scales(base, variable_sizes(scene, base))
    remainders: dict[float, dict[str, Any]] = {}
    for h in steps:
        try:
            values = values_of(moved(scene, along, h), kind)
        except FAILURES:
            continue
        remainders[h] = {f: abs(value - base.values[f] - h * slopes[f]) for f, value in values.items()}
    return {f: _rate(list(remainders), [found[f] for found in remainders.values()], scales[f]) for f in base.values}


def _rate(steps: Sequence[float], remainders: list[float], scale: float) -> float:
    if len(steps) < 2:
        return np.nan
    if max(remainders) <= REMAINDER_ROUND_OFF * scale or min(remainders) == 0:
        return np.inf
    return float(np.polyfit(np.log(steps), np.log(remainders), 1)[0])


STEPS = tuple(10.0 ** np.arange(-2, -11, -1.0))
"""Relative steps of central differences along a direction."""


SMALL_STEP, SETTLED_DIFFERENCE = 1e-3, 0.1
"""Relative step from which on differences of a response that is not far from linear are near its derivative, and how near."""


class Quotient(NamedTuple):
    """What central differences say about a response's derivative along one direction: the number, and by how much it is uncertain."""

    slope: float
    uncertainty: float


def difference_quotients(
    scene: Scene, design: list[str], kind: Kind, exact: Run, steps: Sequence[float] = STEPS
) -> dict[float, dict[str, float]]:
    """Relative step h -> response -> [f(x + h d) - f(x - h d)] / 2h along `direction`; a step so large that its runs fail is left out."""
    scene = frozen(scene, exact.solution)
    along, found = direction(scene, exact), {}
    for h in steps:
        try:
            up, down = (values_of(moved(scene, along, step), kind) for step in (h, -h))
        except FAILURES:
            continue
        found[h] = {f: float(np.real(up[f] - down[f])) / (2 * h) for f in exact.values}
    return found


def best_quotients(found: Mapping[float, Mapping[str, float]]) -> dict[str, Quotient]:
    """Response -> the quotient at the bottom of the V of truncation and round-off.

    Neighbours there differ by what both leave of it. Two numbers may agree by chance, so the larger difference to the two neighbours of
    the quotient for which that is smallest is taken. A step that moves no digit of the response says nothing; with fewer than three that
    do, nothing is known.
    """
    best = {}
    for f in next(iter(found.values()), {}):
        told = [each[f] for each in found.values() if each[f] != 0]
        known = [Quotient(b, max(abs(b - a), abs(c - b))) for a, b, c in zip(told, told[1:], told[2:], strict=False)]
        if known:
            best[f] = min(known, key=lambda each: each.uncertainty)
    return best


def jumping(
    found: Mapping[float, Mapping[str, float]], along: Mapping[str, float], scales: Mapping[str, float]
) -> tuple[str, ...]:
    """Responses that differ from their derivatives along the direction over a small step, though not over a smaller one.

    Truncation vanishes like h^2 and round-off grows like 1/h, so that a smooth response is right wherever a smaller step is, up to
    `SMALL_STEP`.
    Neither is measured by a slope that is zero, but by the response's scale: truncation leaves h^2 of it, round-off
    `REMAINDER_ROUND_OFF` / h.
    """
    lost = []
    for f, slope in along.items():
        off = {h: abs(each[f] - slope) for h, each in found.items() if h <= SMALL_STEP}
        right = min((h for h, error in off.items() if error <= SETTLED_DIFFERENCE / 10 * abs(slope)), default=np.inf)
        if any(
            h > right and error > SETTLED_DIFFERENCE * abs(slope) + (SMALL_STEP**2 + REMAINDER_ROUND_OFF / h) * scales[f]
            for h, error in off.items()
        ):
            lost.append(f)
    return tuple(lost)


def step_study(
    scene: Scene, design: list[str], kind: Kind, steps: Sequence[float] = STEPS, exact: Run | None = None
) -> list[tuple[float, float]]:
    """Central differences along `direction` against the gradient, over steps h: the V of truncation and round-off.

    `exact` as for `taylor_rates`.

    Returns
    -------
    study : list of pairs
        Relative step and largest relative difference; a step so large that its runs fail is left out.
    """
    base = exact or direct(scene, design, kind)
    return curve_of(scene, base, difference_quotients(scene, design, kind, base, steps))


def curve_of(scene: Scene, base: Run, quotients: Mapping[float, Mapping[str, float]]) -> list[tuple[float, float]]:
    """Step and largest relative difference of difference quotients, as `step_study`."""
    scene = frozen(scene, base.solution)
    slopes, scales = slopes_along(base, direction(scene, base)), response_scales(base, variable_sizes(scene, base))
    sizes = {f: max(abs(slope), NEGLIGIBLE_DERIVATIVE * scales[f], np.finfo(float).tiny) for f, slope in slopes.items()}
    return [
        (h, max((abs(each[f] - slope) / sizes[f] for f, slope in slopes.items()), default=0.0)) for h, each in quotients.items()
    ]
