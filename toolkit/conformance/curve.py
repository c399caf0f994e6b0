"""The check of a time curve: its derivatives by time, and by every number that it has."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from toolkit.conformance.comparison import STEP, compare
from toolkit.curves.curve import Curve
from toolkit.foundation.errors import ConformanceError

WIDTHS = 0.02 / 2.0 ** np.arange(5)
"""Steps of the differences that are extrapolated, as parts of the number, or of the times."""
DOUBT = 1e-6
"""Part of the largest derivative by a number by which a complex step and extrapolated differences may differ: the round-off of
differences is 1e-11, and that of the last extrapolation still smaller; a formula that drops an imaginary part is wrong by all of it."""
CLEAR = 0.05
"""Distance of the times from corners, as a part of the interval: differences look a fraction of it to both sides."""


def check_curve(curve: Curve, interval: tuple[float, float] = (0.0, 1.0), seed: int = 0) -> None:
    """Check every derivative of a time curve at random times: f' and f'' by a complex step in time, those by its numbers by differences.

    Parameters
    ----------
    curve
        The curve.
    interval
        Times to look at; those near its corners are left out.
    seed
        Another one gives other times.

    Raises
    ------
    ConformanceError
        f' or f'' differs from a complex step of f or f' by more than 1e-10 of the largest, or a complex step in a number from
        differences; names the derivative, the time and both values. Or the curve has other than three rates, or they are not finite.
    """
    times = _times(curve, interval, np.random.default_rng(seed))
    at = [f"t = {time:.4g}" for time in times]
    rates = _finite(curve, times)
    moved = np.imag(curve.evaluate(times + 1j * STEP)) / STEP
    for k, name in enumerate(("f'", "f''")):
        compare(f"{name} of the time curve {curve.kind!r}", rates[:, k + 1], moved[:, k], [at], _least(rates[:, k], interval))
    for path, value in curve.numbers():
        exact = np.imag(curve.with_number(path, value + 1j * STEP).evaluate(times)) / STEP
        _compare_with_differences(curve, path, float(value), exact, times, interval)


def _times(curve: Curve, interval: tuple[float, float], rng: np.random.Generator) -> np.ndarray:
    """Random times of the interval that are clear of corners."""
    low, high = interval
    corners = np.real(np.array(curve.corners(), complex))
    times = np.sort(rng.uniform(low, high, 60))
    near = np.abs(times[:, None] - corners).min(axis=1, initial=np.inf) < CLEAR * (high - low)
    if near.all():
        raise ConformanceError(
            f"the time curve {curve.kind!r} has a corner near every time from {low:g} to {high:g}: give another `interval`."
        )
    return times[~near]


def _finite(curve: Curve, times: np.ndarray) -> np.ndarray:
    """Rates f, f', f'' of a curve at the times, (n_t, 3), refused if they are not finite."""
    if (count := len(curve.rates(times))) != 3:
        raise ConformanceError(f"`rates` of the time curve {curve.kind!r} gives {count} arrays; three are needed: f, f', f''.")
    found = curve.evaluate(times)
    if np.iscomplexobj(found) or not np.isfinite(found).all():
        raise ConformanceError(f"the time curve {curve.kind!r} is not finite and real at all times of the interval.")
    return found


def _least(values: np.ndarray, interval: tuple[float, float]) -> float:
    """Least scale of derivatives: the slope of a curve that changes by its largest value within the interval."""
    return float(np.abs(values).max() / (interval[1] - interval[0]))


def _compare_with_differences(
    curve: Curve, path: str, value: float, exact: np.ndarray, times: np.ndarray, interval: tuple[float, float]
) -> None:
    size = abs(value) or 1.0
    by_time = CLEAR * (interval[1] - interval[0])
    step = min(size, by_time) if size > by_time else size
    differences = extrapolated(lambda h: np.real(curve.with_number(path, value + h).evaluate(times)), step * WIDTHS)
    for k, name in enumerate(("f", "f'", "f''")):
        largest = max(float(np.abs(differences[:, k]).max()), float(np.abs(curve.evaluate(times)[:, k]).max()) / size)
        wrong = np.abs(exact[:, k] - differences[:, k])
        if wrong.max() > DOUBT * largest:
            n = int(np.argmax(wrong))
            raise ConformanceError(
                f"the derivative of {name} of the time curve {curve.kind!r} by {path} is wrong at t = {times[n]:.4g}: a complex step "
                f"gives {exact[n, k]:.10g}, differences {differences[n, k]:.10g}. The formulas of `rates` must hold for complex "
                "numbers: no abs, no real part, no float()."
            )


def extrapolated(function: Callable[[float], Any], steps: Sequence[float] | np.ndarray) -> np.ndarray:
    """Central differences with halved steps, extrapolated by Richardson to a step of zero."""
    table = [(function(h) - function(-h)) / (2 * h) for h in map(float, steps)]
    for order in range(1, len(table)):
        table = [fine + (fine - coarse) / (4**order - 1) for coarse, fine in pairwise(table)]
    return np.asarray(table[0])
