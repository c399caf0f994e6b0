"""How far responses and gradients are off because of the length of the steps: the same run with other steps, and Richardson's rule.

With f of steps h and g of steps r h, and the order p of the scheme,

    f - f_exact = (g - f) / (r^p - 1),

which is an estimate where both are near the limit; where they are not, they differ by so much that the estimate is large as well.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from toolkit.errors import ToolkitError
from toolkit.run_options import RunOptions
from toolkit.solution import Solution

Values = Mapping[str, Any]
Gradients = Mapping[str, Mapping[str, float]]
Repeat = Callable[[RunOptions], tuple[Values, Gradients]]
"""The same analysis with other options: values and gradients of its responses."""

RATIO = 2.0
"""Steps that tell are so much longer, or shorter where longer ones do not work."""
UNIMPORTANT = 0.01
"""A derivative that changes its response by less than this part of its magnitude, where the variable changes by all of its size, is
compared with such a change instead of with itself."""


@dataclass(frozen=True)
class StepError:
    """Estimated errors of one run by the length of its steps.

    Attributes
    ----------
    how
        What was compared, in words.
    values
        Response -> error, a part of the largest magnitude that it has in the motion.
    gradients
        Response -> variable -> error, a part of the derivative.
    other_values, other_gradients
        What the run with the other steps found.
    order
        Order of the scheme that the estimate supposes.
    """

    how: str
    values: dict[str, float]
    gradients: dict[str, dict[str, float]]
    other_values: Values
    other_gradients: Gradients
    order: int


def step_error(
    solution: Solution,
    values: Values,
    gradients: Gradients,
    scales: Mapping[str, float],
    sizes: Mapping[str, float],
    repeat: Repeat,
) -> StepError | None:
    """The estimate for a motion; None if no other steps work.

    Parameters
    ----------
    scales : dict
        Response -> its largest magnitude in the motion.
    sizes : dict
        Variable -> its size, what its derivative is to be multiplied with; infinite if it has none.
    """
    options = solution.options or solution.system.scene.solver
    for how, other, ratio in (*_longer(options, solution.whole_run), *_shorter(options, solution.whole_run)):
        try:
            found, slopes = repeat(other)
        except ToolkitError:
            continue
        order = _order(options)
        part = 1 / abs(ratio**order - 1)
        return StepError(
            how,
            {f: _relative(part * (float(np.real(found[f])) - float(np.real(values[f]))), scales[f]) for f in values},
            {
                f: {
                    x: _relative(part * (slopes[f][x] - slope), max(abs(slope), UNIMPORTANT * scales[f] / sizes[x]))
                    for x, slope in each.items()
                }
                for f, each in gradients.items()
            },
            found,
            slopes,
            order,
        )
    return None


def _relative(error: float, scale: float) -> float:
    """A part of the scale; nan where the numbers themselves do not exist."""
    return abs(error) / scale if scale > 0 else (0.0 if error == 0 else np.inf)


def _order(options: RunOptions) -> int:
    first = options.quasi_static or (options.scheme == "paper" and options.rho_inf < 1)
    return 1 if first else 2


def _longer(options: RunOptions, times: np.ndarray) -> list[tuple[str, RunOptions, float]]:
    """The run with steps about twice as long, and how much longer they are; none for a single step."""
    steps = len(times) - 1
    fewer = (steps + 1) // 2
    if fewer == steps:
        return []
    if options.local_error is not None:
        return [_looser(options, RATIO, "with chosen steps about twice as long")]
    if options.times is not None:
        kept = tuple(map(float, (*times[:-1:2], times[-1])))
        return [("with every second of its times", options.model_copy(update={"times": kept}), RATIO)]
    longer = options.model_copy(update={"step": options.end_time / fewer})
    return [(f"with steps {steps / fewer:g} times as long", longer, steps / fewer)]


def _shorter(options: RunOptions, times: np.ndarray) -> list[tuple[str, RunOptions, float]]:
    """The run with steps half as long."""
    if options.local_error is not None:
        return [_looser(options, 1 / RATIO, "with chosen steps about half as long")]
    if options.times is not None:
        between = [(a + b) / 2 for a, b in pairwise(times)]
        return [("with steps half as long", options.model_copy(update={"times": tuple(sorted([*times, *between]))}), 1 / RATIO)]
    return [
        ("with steps half as long", options.model_copy(update={"step": options.end_time / (2 * (len(times) - 1))}), 1 / RATIO)
    ]


def _looser(options: RunOptions, ratio: float, how: str) -> tuple[str, RunOptions, float]:
    """Chosen steps grow with the third root of the error that is allowed (the second without inertia)."""
    growth = ratio ** (2 if options.quasi_static else 3)
    allowed = float(options.local_error or 0) * growth
    return how, options.model_copy(update={"local_error": allowed, "step": options.step * max(ratio, 1.0)}), ratio
