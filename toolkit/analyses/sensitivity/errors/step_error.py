"""Estimated time-step errors of responses and gradients: the same run with other steps, and Richardson's rule.

With f of steps h, g of steps r h, k of steps s h, and the order p of the scheme,

    f - f_exact = (g - f) / (r^p - 1) = (k - g) / (s^p - r^p),

where all are near the limit. The larger of both is taken: f and g may be equally wrong where a vibration is damped away in both, or agree
by chance, which k seldom does too. Longer steps cost three quarters of a run and are often too long to tell more than that something may
be wrong; then a run with steps half as long (r = 1/2) says how wrong. If it denies what the longer ones say, one with a quarter decides;
these two are both compared with f, which is farther from the truth than they.

The derivative of an extreme over time is that at the step next to the peak, which may be far or near by chance, in every run. What it
differs by at the peak itself is known without another run, and derivatives of the runs are compared there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from toolkit.analyses.sensitivity.errors.lost_vibrations import LostVibrations, steps_that_keep
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.units import unit
from toolkit.foundation.value_types import Scalar
from toolkit.responses.stress import StressResponse, stress_rows
from toolkit.system.solution import Solution

Values = Mapping[str, Scalar]
Gradients = Mapping[str, Mapping[str, float]]
Repeat = Callable[[RunOptions], tuple[Values, Gradients]]
"""Function that repeats the analysis with other options and returns values and gradients of its responses."""

LONGER = (2, 4)
"""Ratios of the longer steps of comparison runs to the steps of the run."""
CONTRADICTED_ERROR = 0.04
"""Error by longer steps that steps half as long contradict: these may agree by chance, so that shorter ones decide."""
TIMES_AS_SHORT = {2: "with steps half as long", 4: "with steps a quarter as long"}
"""Number of parts of a step in runs with shorter steps -> the phrase for it, in the order in which they are tried."""
DERIVATIVE_FACTOR = 2.0
"""Factor by which errors of derivatives may be larger than those of values."""
ZERO_NUMBER = 1e-6
"""Part of the largest magnitude in the motion below which a number is taken for zero."""
MOST_STEPS, MOST_NUMBERS = 10_000, 2_000_000
"""Steps, and numbers in all their states, up to which a run that keeps vibrations is affordable: about a second."""
VIBRATION_SHARE = 0.5
"""Error of a value half of which vibrations must explain, or half of all that is larger, to be told as theirs."""
STEPS_PER_PERIOD = 20
"""Number of steps in a period of a vibration that is to last."""
CERTAIN_ERROR = 0.01
"""Estimated error by longer steps up to which no shorter ones are asked: it was never too small by more than a factor of four in 200
random scenes (`tests.benchmarks.random_scenes`)."""


@dataclass(frozen=True)
class StepError:
    """Estimated time-step errors of one run.

    Attributes
    ----------
    how
        What was compared, in words.
    values
        Response -> error, a part of the largest magnitude that it has in the motion.
    gradients
        Response -> variable -> error, a part of the largest derivative in the motion.
    own_values, own_gradients
        The same errors as parts of the value and of the derivative themselves, which may be small where the motion ends.
    other_values, other_gradients
        What the run with the other steps found.
    changes, slope_changes
        What the exact numbers differ from those of the run by, as far as the estimate knows.
    order
        Order of the scheme that the estimate supposes.
    vibrations
        Those that the steps take out and the comparison has, in words.
    step
        Length of the steps that keep them.
    at_peaks
        Response and variable of derivatives that are off by the time of a peak above all.
    """

    how: str
    values: dict[str, float]
    gradients: dict[str, dict[str, float]]
    own_values: dict[str, float]
    own_gradients: dict[str, dict[str, float]]
    other_values: Values
    other_gradients: Gradients
    changes: dict[str, float]
    slope_changes: dict[str, dict[str, float]]
    order: int
    vibrations: str = ""
    step: float | None = None
    at_peaks: frozenset[tuple[str, str]] = frozenset()

    @property
    def by_shorter_steps(self) -> bool:
        """Whether shorter steps gave the estimate."""
        return self.how in TIMES_AS_SHORT.values()

    @property
    def largest(self) -> float:
        """Largest error of any value or derivative; those of derivatives are divided by `DERIVATIVE_FACTOR`."""
        slopes = (error / DERIVATIVE_FACTOR for each in self.gradients.values() for error in each.values())
        return max([*self.values.values(), *slopes], default=0.0)


class ComparisonRun(NamedTuple):
    """A run with other steps: the ratio of their lengths, a phrase for it, and the values and gradients."""

    ratio: float
    how: str
    values: Values
    gradients: Gradients


def step_error(
    solution: Solution,
    values: Values,
    gradients: Gradients,
    scales: Mapping[str, float],
    slope_scales: Gradients,
    repeat: Repeat,
    suspicious: bool = False,
    lost: LostVibrations | None = None,
    at_peaks: Gradients | None = None,
) -> StepError | None:
    """Estimated time-step error of a motion; None if no other steps work.

    Parameters
    ----------
    scales : dict
        Response -> its largest magnitude in the motion.
    slope_scales : dict
        Response -> variable -> what an error of the derivative is to be compared with, if that is larger than the derivative.
    lost : LostVibrations
        What the steps have taken out of it, if that counts: then a run with steps that keep it decides, where it is affordable.
    at_peaks : dict
        Response -> variable -> what the derivative of an extreme differs by at its peak between the steps.
    """
    options = solution.options or solution.system.scene.solver
    if solution.halved:  # its steps, which other ones may have to halve again where they are longer
        options = options.model_copy(update={"times": tuple(map(float, solution.whole_run))})
    else:
        options = options.model_copy(update={"halvings": 0})  # other steps are to be what they are called
    known = JudgedNumbers(values, gradients, scales, slope_scales, 1 if first_order(options) else 2, at_peaks or {})
    if lost is not None and (resolved := _resolved(known, lost, solution, repeat)) is not None:
        return resolved
    longer = _tried(repeat, (_longer(options, solution.whole_run, ratio) for ratio in LONGER))
    found = _estimate(known, longer) if longer else None
    if found is None or suspicious or not found.largest <= CERTAIN_ERROR:
        wanted = [
            (1 / parts, words, shorter_steps(options, solution.whole_run, parts)) for parts, words in TIMES_AS_SHORT.items()
        ]
        shorter = _tried(repeat, wanted[:1])
        half = _estimate(known, shorter) if shorter else None
        if found and half and found.largest > CONTRADICTED_ERROR >= half.largest:
            half = _estimate(known, shorter + _tried(repeat, wanted[1:]))
        found = half or found
    return found if lost is None or found is None else _with_lost(found, known, lost, solution)


def _resolved(known: JudgedNumbers, lost: LostVibrations, solution: Solution, repeat: Repeat) -> StepError | None:
    """Time-step error by a run with steps that keep the lost vibrations; None if that takes too many steps."""
    options, variables = solution.options or solution.system.scene.solver, len(next(iter(known.gradients.values()), {}))
    most = min(MOST_STEPS, MOST_NUMBERS // _numbers_of_a_state(solution, variables))
    steps = steps_that_keep(lost, options, 2 * solution.steps, most)
    if steps is None:
        return None
    finer = options.model_copy(update={"step": options.end_time / steps, "local_error": None, "times": None})
    vibrations = lost.told(unit(solution.system.scene.units, "rate"))
    how = f"with {steps} steps, which keep {vibrations}"
    found = _tried(repeat, [(solution.steps / steps, how, finer)])
    if not found:
        return None
    estimate = _estimate(known, found)
    its_doing = max(lost.swings.values()) >= min(VIBRATION_SHARE, max(estimate.values.values())) / 2
    return replace(estimate, vibrations=vibrations, step=options.end_time / steps) if its_doing else estimate


def _numbers_of_a_state(solution: Solution, variables: int) -> int:
    """Count of numbers in a state: coordinates and multipliers with derivatives, and stresses asked for at all times."""
    system = solution.system
    asked = {each.body for each in system.scene.responses.values() if isinstance(each, StressResponse) and each.when == "all"}
    return system.n * (1 + variables) + sum(stress_rows(system.scene, body).shape[0] for body in asked)


def _with_lost(found: StepError, known: JudgedNumbers, lost: LostVibrations, solution: Solution) -> StepError:
    """An estimate completed by the linearised motion of the lost vibrations."""
    more = {f: error for f, error in lost.errors.items() if error > found.values.get(f, 0.0)}
    own = {f: _own(error, known.values[f], known.scales[f]) for f, error in more.items()}
    found = _with_lost_slopes(found, known, lost)
    vibrations = lost.told(unit(solution.system.scene.units, "rate"))
    return replace(
        found,
        how=f"with {vibrations} added",
        values={**found.values, **more},
        own_values={**found.own_values, **own},
        other_values={**found.other_values, **{f: lost.values[f] for f in more}},
        changes={**found.changes, **{f: float(np.real(lost.values[f] - known.values[f])) for f in more}},
        vibrations=vibrations,
        step=2 * np.pi / (lost.vibrations[0].rate * STEPS_PER_PERIOD),
    )


def _with_lost_slopes(found: StepError, known: JudgedNumbers, lost: LostVibrations) -> StepError:
    """An estimate with the changes of derivatives by lost vibrations.

    They are nan, unknown, where the run has no derivatives of its states.
    """
    added = lost.gradients() if known.gradients else {}
    errors, own, others, moved = (
        {f: dict(each) for f, each in of.items()}
        for of in (found.gradients, found.own_gradients, found.other_gradients, found.slope_changes)
    )
    for f, slopes in known.gradients.items():
        for x, slope in slopes.items() if lost.swings.get(f, 0.0) > 0 else ():
            more = np.nan if added is None else added[f][x]
            scale = max(abs(slope), known.slope_scales[f][x])
            error = _relative(abs(more), scale)
            if not error <= errors[f][x]:
                errors[f][x], own[f][x], others[f][x], moved[f][x] = error, _own(error, slope, scale), slope + more, more
    return replace(found, gradients=errors, own_gradients=own, other_gradients=others, slope_changes=moved)


class JudgedNumbers(NamedTuple):
    """Values and gradients of the run that is judged, what their errors are compared with, and the order of its scheme."""

    values: Values
    gradients: Gradients
    scales: Mapping[str, float]
    slope_scales: Gradients
    order: int
    at_peaks: Gradients  # what derivatives of extremes differ by at peaks between the steps


def first_order(options: RunOptions) -> bool:
    """Whether the scheme's errors fall with the step itself, and not with its square."""
    return options.quasi_static or (options.scheme == "paper" and options.rho_inf < 1)


def _estimate(known: JudgedNumbers, runs: list[ComparisonRun]) -> StepError:
    """Time-step error by comparison with other runs, in the order of their steps."""

    def change(number: Scalar, others: Sequence[Scalar]) -> float:
        """The largest estimate of what the exact number differs by from one that is `others` in the other runs."""
        chain, ratios = [float(np.real(each)) for each in (number, *others)], [1.0, *(run.ratio for run in runs)]
        pairs = pairwise if runs[0].ratio > 1 else _with_the_first
        steps = zip(pairs(chain), pairs(ratios), strict=True)
        return max(((a - b) / (s**known.order - r**known.order) for (a, b), (r, s) in steps), key=abs)

    changes = {f: change(value, [run.values[f] for run in runs]) for f, value in known.values.items()}
    peaks = {f: {x: known.at_peaks.get(f, {}).get(x, 0.0) for x in slopes} for f, slopes in known.gradients.items()}
    slope_changes = {
        f: {x: peaks[f][x] + change(slope + peaks[f][x], [run.gradients[f][x] for run in runs]) for x, slope in slopes.items()}
        for f, slopes in known.gradients.items()
    }
    at_peaks = frozenset(
        (f, x) for f, each in slope_changes.items() for x, all_of in each.items() if abs(peaks[f][x]) > abs(all_of) / 2
    )
    values = {f: _relative(abs(each), known.scales[f]) for f, each in changes.items()}
    largest = {
        f: {x: max(abs(slope), known.slope_scales[f][x]) for x, slope in slopes.items()} for f, slopes in known.gradients.items()
    }
    gradients = {f: {x: _relative(abs(each), largest[f][x]) for x, each in slopes.items()} for f, slopes in slope_changes.items()}
    own = {f: _own(error, known.values[f], known.scales[f]) for f, error in values.items()}
    of_slopes = {
        f: {x: _own(error, known.gradients[f][x], largest[f][x]) for x, error in errors.items()}
        for f, errors in gradients.items()
    }
    others = runs[0].values, runs[0].gradients
    own_errors = own, of_slopes
    return StepError(runs[0].how, values, gradients, *own_errors, *others, changes, slope_changes, known.order, at_peaks=at_peaks)


def _with_the_first(numbers: list[float]) -> list[tuple[float, float]]:
    """Pairs of the first number with each other one.

    Shorter steps are nearer to the truth than what they are compared with; the difference of two of them, extrapolated to a run
    that is many times as wrong, would only make more of their own noise.
    """
    return [(numbers[0], each) for each in numbers[1:]]


def _own(error: float, number: Scalar, scale: float) -> float:
    """An error relative to the number itself, from one relative to its scale; unchanged where the number is only round-off."""
    size = abs(float(np.real(number)))
    return error * scale / size if size > ZERO_NUMBER * scale else error


def _relative(error: float, scale: float) -> float:
    """An error relative to a scale; nan where the numbers themselves do not exist."""
    return error / scale if scale > 0 else (0.0 if error == 0 else np.inf)


def _tried(repeat: Repeat, wanted: Iterable[tuple[float, str, RunOptions] | None]) -> list[ComparisonRun]:
    """Runs with other steps, up to the first that fails."""
    found = []
    for each in wanted:
        if each is None:
            break
        try:
            found.append(ComparisonRun(*each[:2], *repeat(each[2])))
        except ToolkitError:
            break
    return found


def _longer(options: RunOptions, times: np.ndarray, ratio: int) -> tuple[float, str, RunOptions] | None:
    """Options of the run with longer steps, with the ratio and a phrase; None for too few steps."""
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


def shorter_steps(options: RunOptions, times: np.ndarray, parts: int) -> RunOptions:
    """Options of the run with every step divided into a number of parts."""
    if options.local_error is not None:
        return _looser(options, 1 / parts)
    if options.times is not None:
        between = [float(a + (b - a) * k / parts) for a, b in pairwise(times) for k in range(1, parts)]
        return options.model_copy(update={"times": tuple(sorted([*map(float, times), *between]))})
    return options.model_copy(update={"step": options.end_time / (parts * (len(times) - 1))})


def _looser(options: RunOptions, ratio: float) -> RunOptions:
    """Options of a run that chooses steps about `ratio` times as long.

    Chosen steps grow with the third root of the error that is allowed (the second without inertia), and so does the longest of
    them: it may be what has chosen them.
    """
    allowed = float(options.local_error or 0) * ratio ** (2 if options.quasi_static else 3)
    return options.model_copy(update={"local_error": allowed, "step": min(options.end_time, options.step * ratio)})
