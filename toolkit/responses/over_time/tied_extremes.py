"""Largest and least values, over time or over a body, that occur more than once with other derivatives: there the derivative jumps.

A swing that comes back to the same height, or a load that repeats, has peaks of one height, and a bent bar the same stress on both sides.
The largest value is the same by each; by a variable it follows the one that rises fastest, to the other side the one that falls slowest.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise

import numpy as np

from toolkit.foundation.spread import spread
from toolkit.foundation.verdict import Caution
from toolkit.responses.instant import slope_at
from toolkit.responses.over_time.extremes import TimeMax, TimeMin
from toolkit.responses.response import total_derivative
from toolkit.responses.stress.stress import MaxStress
from toolkit.system.solution import Solution

TIED = 1e-6
"""Part of the largest magnitude by which peaks may differ and still be one value: what steps leave of peaks that are equal, about."""
PLACES = 64
"""So many places at most are looked at of a body that has one stress at many."""
UNIMPORTANT, NOTHING = 0.02, 1e-6
"""A derivative that changes its stress by less than these parts of it is worth a remark, or no word."""
JUMP = 0.1
"""Part of the larger derivative by which derivatives of tied peaks may differ without a word, as of other errors of gradients."""


def tied_extremes(solution: Solution, sizes: Mapping[str, float]) -> Iterator[Caution]:
    """A doubt for every derivative of a largest or least value that jumps, where the solution holds derivatives.

    Parameters
    ----------
    sizes
        Variable -> by how much it is thought to change at most.
    """
    if solution.run_times is not None or not solution.dq.shape[2]:
        return
    for name, response in solution.system.scene.responses.items():
        if isinstance(response, MaxStress):
            yield from _of_places(name, response, solution, sizes)
        elif isinstance(response, TimeMax | TimeMin) and solution.steps:
            yield from _of(name, response, solution)


def _of_places(name: str, response: MaxStress, solution: Solution, sizes: Mapping[str, float]) -> Iterator[Caution]:
    """Of the stress of a body; of a bar that is stressed alike everywhere some places stand for all."""
    stress = np.real(response.considered(solution)).ravel()
    most = float(stress.max(initial=0.0))
    tied = np.flatnonzero(stress >= (1 - TIED) * most) if most > 0 else np.zeros(0, int)
    if len(tied) < 2:
        return
    slopes = np.array(
        [total_derivative(response.of_place(solution, int(tied[k])), solution) for k in spread(len(tied) - 1, PLACES)]
    )
    for x, variable in enumerate(solution.system.design.names):
        low, high = float(slopes[:, x].min()), float(slopes[:, x].max())
        largest = max(abs(low), abs(high))
        effect = largest * sizes.get(variable, 0.0) / most
        if high - low > JUMP * largest and effect > NOTHING:
            yield Caution(
                "tied-extreme",
                f"the derivative of {name} by {variable} jumps here, as {response.body} has this stress at {len(tied)} places or times: it "
                f"is {high:.4g} to one side, where {variable} grows, and {low:.4g} to the other. Ask for the stress at one of these places "
                "(stress-at-point), or for a smooth maximum (ks-stress).",
                doubt=effect > UNIMPORTANT,
            )


def _of(name: str, response: TimeMax | TimeMin, solution: Solution) -> Iterator[Caution]:
    look = response.source.instants(solution)
    values = np.array([float(np.real(look(step).value)) for step in range(len(solution.times))])
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
