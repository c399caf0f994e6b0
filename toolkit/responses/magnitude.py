"""The magnitude of a response in a motion: what an error of it is to be compared with."""

from __future__ import annotations

from functools import singledispatch
from typing import Any, NamedTuple

import numpy as np

from toolkit.foundation.spread import spread
from toolkit.responses.instant import Instant, slope_at
from toolkit.responses.over_time.over_time import OverTime
from toolkit.responses.response import Response
from toolkit.system.solution import Solution

INSTANTS = 40
"""A quantity is looked at in so many instants, evenly spread over the motion."""


class Largest(NamedTuple):
    """What is largest in a motion: the magnitude of a quantity, and those of its derivatives (n_x,), as far as the solution holds any."""

    magnitude: float
    slopes: np.ndarray


def magnitude_that_counts(response: Response, solution: Solution, largest: Largest) -> float:
    """What an error of a response is compared with.

    It is the largest magnitude in the motion; but of a place or an angle at least what Newton leaves undecided of it, so that one that
    is zero by symmetry is not wrong by its own round-off.
    """
    scene, options = solution.system.scene, solution.options or solution.system.scene.solver
    whole = {"angle": 1.0, "length": scene.size}.get(response.unit_quantity, 0.0)
    return max(largest.magnitude, options.tolerance * whole)


@singledispatch
def largest_in(response: Response, solution: Solution, value: Any) -> Largest:
    """The largest that the response's quantity has in the motion: a value that just passes zero is not wrong by infinitely much."""
    return Largest(float(abs(np.real(value))), np.zeros(solution.system.n_x))


@largest_in.register
def _(response: Instant, solution: Solution, value: Any) -> Largest:
    look, magnitude, slopes = response.instants(solution), abs(float(np.real(value))), np.zeros(solution.system.n_x)
    for step in spread(len(solution.times) - 1, INSTANTS):
        found = look(step)
        magnitude = max(magnitude, abs(float(np.real(found.value))))
        if len(slopes):
            slopes = np.maximum(slopes, np.abs(slope_at(found, solution, step)))
    return Largest(magnitude, np.nan_to_num(slopes))


@largest_in.register
def _(response: OverTime, solution: Solution, value: Any) -> Largest:
    largest, duration = largest_in(response.source, solution, 0.0), _duration(solution)
    return Largest(response.of_size(largest.magnitude, duration), response.of_slopes(*largest, duration))


def _duration(solution: Solution) -> float:
    return float(solution.whole_run[-1] - solution.whole_run[0])
