"""How much of a gradient is round-off: the spread of both exact methods under the scene's own last digits."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from toolkit.compilation.checks import check_numbers
from toolkit.compilation.numbering import number
from toolkit.compilation.quantities import evaluate_quantities
from toolkit.foundation.errors import InputError
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.sensitivity.adjoint.adjoint import adjoint_gradients, has_adjoint
from toolkit.sensitivity.evaluation import by_name
from toolkit.sensitivity.preparation import Kind, frozen, prepare, responses_of, solve
from toolkit.sensitivity.run import Run
from toolkit.sensitivity.sizes import response_scales, variable_sizes

Gradients = dict[str, dict[str, float]]
EPS = float(np.finfo(float).eps)
TRIAL = 1e-3
"""Relative step that tells whether a number can be moved at all."""
LAST_DIGITS = 8 * EPS
"""Relative change of the scene's numbers: enough to round everything anew, too little to change a gradient by itself."""
UNSEEN = 1e-14
"""Part of a response's scale below which the effect of a variable (changed by its own size) cannot be told from none."""
SAMPLES, SAFETY = 4, 10.0
"""Runs with other last digits, and how much further apart than those two methods may be: each is one more such sample, of a
distribution with long tails."""


def round_off(scene: Scene, exact: Run, kind: Kind, unseen: float = UNSEEN) -> Gradients:
    """Estimated round-off of each derivative, as an absolute number.

    The scene is solved with other last digits of its own numbers, and differentiated directly and backwards. All that differs is
    round-off; `SAFETY` times the largest difference seen is what two right methods may differ by, and at least the part `unseen` of what
    the response is or does.
    """
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
                    found[f][x] = max(found[f][x], SAFETY * abs(slope - exact.gradients[f][x]))
    return found


def rounded_anew(scene: Scene, paths: list[str], rng: np.random.Generator) -> Scene:
    """The scene with other last digits of the numbers at these paths."""
    for path in paths:
        scene = scene.with_number(path, np.real(scene.number(path)) * (1 + LAST_DIGITS * rng.uniform(-1, 1)))
    return scene


def can_move(scene: Scene, path: str) -> bool:
    """Whether the runtime can give a number other values above and below: not if only preprocessing knows what follows from them."""
    value = np.real(scene.number(path))
    if path not in scene.model_parameters():
        return True
    try:
        for step in (-TRIAL, TRIAL):
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
