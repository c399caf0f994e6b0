"""Whether a cubic table swings beyond its values, as splines do beside steep rows."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.compilation.quantities import curves_of
from toolkit.curves.curve import Curve
from toolkit.curves.table import Table
from toolkit.foundation.verdict import MOTION, Caution, check
from toolkit.system.solution import Solution

BEYOND = 0.1
"""Part of the range of a table's values by which its cubic may leave it: a sine by eight rows in a period leaves it by 4 %."""

DOUBTFUL = 0.5
"""The same that nobody means: a pulse of a few close rows in a long table may swing to a hundred thousand times its height before it."""


@check("curve-overshoot", (MOTION,))
def overshooting_tables(solution: Solution) -> Iterator[Caution]:
    """A cubic table swings beyond its values between its rows.

    Limit: 10 % of the range of its values; a doubt from 50 % on.
    Fix: `interpolation = "monotone"` or `"linear"`, or more rows.
    """
    times = solution.whole_run
    for (group, name), curve in curves_of(solution.system.scene):
        for path, table, start, end in _cubics(f"{group}.{name}.curve", curve, float(times[0]), float(times[-1])):
            time, value = _furthest(table, start, end)
            low, high = np.real(min(table.values, key=np.real)), np.real(max(table.values, key=np.real))
            beyond = max(value - high, low - value)
            if beyond > BEYOND * (high - low) > 0:
                yield overshooting_tables.caution(
                    f"{path} swings beyond its values, which are from {low:g} to {high:g}. It reaches {value:.4g} at t = {time:.4g}, "
                    f"{beyond / (high - low):.3g} times their range outside: it is a cubic through all of them. "
                    f'Fix: {path}.interpolation = "monotone" or "linear", more rows where it is steep, or smooth steps.',
                    doubt=bool(beyond > DOUBTFUL * (high - low)),
                )


def _cubics(path: str, curve: Curve, start: float, end: float) -> Iterator[tuple[str, Table, float, float]]:
    """Cubic tables of a curve, their paths, and when they count, in their own time."""
    for part in curve.parts():
        low, high = max(start, part.begin), min(end, part.end)
        if low < high:
            shift = float(np.real(part.shift))
            yield from _cubics(f"{path}.{part.path}", part.curve, low - shift, high - shift)
    if isinstance(curve, Table) and curve.interpolation == "cubic":
        yield path, curve, start, end


def _furthest(table: Table, start: float, end: float) -> tuple[float, float]:
    """Time of a run, and value there, at which a table is furthest from the middle of its values."""
    times = np.concatenate([[start, end], _turns(np.real(np.array(table.times)), table)])
    times = times[(times >= start) & (times <= end)]
    f, values = np.real(table.evaluate(times)[:, 0]), np.real(np.array(table.values))
    worst = int(np.argmax(np.abs(f - (values.min() + values.max()) / 2)))
    return float(times[worst]), float(f[worst])


def _turns(corners: np.ndarray, table: Table) -> np.ndarray:
    """Times between corners at which the slope, a parabola through its values at both and half way, is zero."""
    low, width = corners[:-1], np.diff(corners)
    left, middle, right = (np.real(table.evaluate(low + part * width)[:, 1]) for part in (0.0, 0.5, 1.0))
    square, linear = 2 * (left - 2 * middle + right), 4 * middle - 3 * left - right
    with np.errstate(divide="ignore", invalid="ignore"):  # a slope without zero has none
        sum_ = -(linear + np.copysign(np.sqrt(linear**2 - 4 * square * left), linear)) / 2
        parts = np.stack([sum_ / square, left / sum_])
    return (low + parts * width)[(parts > 0) & (parts < 1)]
