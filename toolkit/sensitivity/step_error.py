"""How far responses and gradients are off because of the length of the steps: the same run with other steps, and Richardson's rule.

With f of steps h, g of steps r h, k of steps s h, and the order p of the scheme,

    f - f_exact = (g - f) / (r^p - 1) = (k - g) / (s^p - r^p),

where all are near the limit. The larger of both is taken: f and g may be equally wrong where a vibration is damped away in both, or agree
by chance, which k seldom does too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from toolkit.errors import ToolkitError
from toolkit.run_options import RunOptions
from toolkit.solution import Solution

Values = Mapping[str, Any]
Gradients = Mapping[str, Mapping[str, float]]
Repeat = Callable[[RunOptions], tuple[Values, Gradients]]
"""The same analysis with other options: values and gradients of its responses."""

LONGER = (2, 4)
"""Steps that tell are so many times as long; half as long where those do not work."""
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


class Run(NamedTuple):
    """A run with other steps: how many times as long they are, in words, and what it found."""

    ratio: float
    how: str
    values: Values
    gradients: Gradients


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
    runs = other_runs(options, solution.whole_run, repeat)
    if not runs:
        return None
    order = 1 if options.quasi_static or (options.scheme == "paper" and options.rho_inf < 1) else 2

    def estimated(number: float, others: list[float], scale: float) -> float:
        """The larger estimate of a number that is `others` in the other runs, a part of its scale."""
        chain, ratios = [float(np.real(each)) for each in (number, *others)], [1.0, *(run.ratio for run in runs)]
        parts = [abs((b - a) / (s**order - r**order)) for (a, b), (r, s) in zip(pairwise(chain), pairwise(ratios), strict=True)]
        return _relative(max(parts), scale)

    found = {f: estimated(value, [run.values[f] for run in runs], scales[f]) for f, value in values.items()}
    slopes = {
        f: {
            x: estimated(slope, [run.gradients[f][x] for run in runs], max(abs(slope), UNIMPORTANT * scales[f] / sizes[x]))
            for x, slope in each.items()
        }
        for f, each in gradients.items()
    }
    return StepError(runs[0].how, found, slopes, runs[0].values, runs[0].gradients, order)


def _relative(error: float, scale: float) -> float:
    """A part of the scale; nan where the numbers themselves do not exist."""
    return error / scale if scale > 0 else (0.0 if error == 0 else np.inf)


def other_runs(options: RunOptions, times: np.ndarray, repeat: Repeat) -> list[Run]:
    """Runs with steps twice and four times as long, as far as they work; half as long if none does."""
    found = []
    for ratio, how, other in filter(None, (_longer(options, times, each) for each in LONGER)):
        try:
            found.append(Run(ratio, how, *repeat(other)))
        except ToolkitError:
            break
    if found:
        return found
    try:
        return [Run(0.5, "with steps half as long", *repeat(_shorter(options, times)))]
    except ToolkitError:
        return []


def _longer(options: RunOptions, times: np.ndarray, ratio: int) -> tuple[float, str, RunOptions] | None:
    """The run with longer steps; none for too few of them."""
    steps = len(times) - 1
    fewer = -(-steps // ratio)
    if fewer == -(-steps // (ratio // 2)):
        return None
    if options.local_error is not None:
        return ratio, f"with chosen steps about {ratio} times as long", _looser(options, ratio)
    if options.times is not None:
        kept = tuple(map(float, (*times[:-1:ratio], times[-1])))
        return ratio, f"with every {ratio}. of its times", options.model_copy(update={"times": kept})
    longer = options.model_copy(update={"step": options.end_time / fewer})
    return steps / fewer, f"with steps {steps / fewer:.3g} times as long", longer


def _shorter(options: RunOptions, times: np.ndarray) -> RunOptions:
    """The run with steps half as long."""
    if options.local_error is not None:
        return _looser(options, 0.5)
    if options.times is not None:
        between = [float(a + b) / 2 for a, b in pairwise(times)]
        return options.model_copy(update={"times": tuple(sorted([*map(float, times), *between]))})
    return options.model_copy(update={"step": options.end_time / (2 * (len(times) - 1))})


def _looser(options: RunOptions, ratio: float) -> RunOptions:
    """Chosen steps grow with the third root of the error that is allowed (the second without inertia)."""
    allowed = float(options.local_error or 0) * ratio ** (2 if options.quasi_static else 3)
    return options.model_copy(update={"local_error": allowed, "step": min(options.end_time, options.step * max(ratio, 1.0))})
