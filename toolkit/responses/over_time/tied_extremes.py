"""Largest and least values over time that occur at several instants with other derivatives: there the derivative jumps.

A swing that comes back to the same height, or a load that repeats, has peaks of one height. The largest value is the same by each; by a
variable it follows the peak that rises fastest, to the other side the one that falls slowest.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from toolkit.foundation.verdict import Caution
from toolkit.responses.instant import slope_at
from toolkit.responses.over_time.extremes import TimeMax, TimeMin
from toolkit.responses.over_time.over_time import over_all_steps
from toolkit.system.solution import Solution

TIED = 1e-6
"""Part of the largest magnitude by which peaks may differ and still be one value: what steps leave of peaks that are equal, about."""
JUMP = 0.1
"""Part of the larger derivative by which derivatives of tied peaks may differ without a word, as of other errors of gradients."""


def tied_extremes(solution: Solution) -> Iterator[Caution]:
    """Doubt for every derivative of an extreme over time that jumps, where the solution holds derivatives."""
    if solution.run_times is not None or not solution.dq.shape[2] or not solution.steps:
        return
    for name, response in solution.system.scene.responses.items():
        if isinstance(response, TimeMax | TimeMin):
            yield from _of(name, response, solution)


def _of(name: str, response: TimeMax | TimeMin, solution: Solution) -> Iterator[Caution]:
    look, values = response.source.instants(solution), np.real(over_all_steps(response.source, solution))
    absolute = isinstance(response, TimeMax) and response.measure == "absolute"
    height = np.abs(values) if absolute else -values if isinstance(response, TimeMin) else values
    tied = tied_peaks(height)
    if len(tied) < 2:
        return
    signs = np.sign(values[tied]) if absolute else np.ones(len(tied))
    slopes = np.array([sign * slope_at(look(int(step)), solution, int(step)) for sign, step in zip(signs, tied, strict=True)])
    jumps = np.ptp(slopes, axis=0) > JUMP * np.abs(slopes).max(axis=0)
    for x, variable in enumerate(solution.system.design.names):
        if jumps[x]:
            first, other = (int(k) for k in (0, np.argmax(np.abs(slopes[:, x] - slopes[0, x]))))
            yield Caution(
                "tied-extreme",
                f"the derivative of {name} by {variable} jumps here, as {name} has one value at t = {solution.times[tied[first]]:.4g} and "
                f"t = {solution.times[tied[other]]:.4g}: {slopes[first, x]:.4g} by the first, {slopes[other, x]:.4g} by the other one. Ask "
                "for the value at one of these times, or for a smooth maximum (time-ks).",
            )


def tied_peaks(height: np.ndarray) -> np.ndarray:
    """Numbers of the highest values (n_t,), of those that lie beside each other the first."""
    size = np.abs(height).max(initial=0.0)
    tops = np.flatnonzero(height >= height.max(initial=-np.inf) - TIED * size)
    low = height.max() - 10 * TIED * size
    apart = np.array([True, *(height[a : b + 1].min() < low for a, b in pairwise(tops))])
    return tops[apart]
