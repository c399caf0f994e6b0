"""The magnitude of a response in a motion: what an error of it is to be compared with."""

from __future__ import annotations

from functools import singledispatch
from typing import Any

import numpy as np

from toolkit.foundation.spread import spread
from toolkit.responses.instant import Instant
from toolkit.responses.over_time.over_time import OverTime
from toolkit.responses.response import STATES, Partials, Response
from toolkit.system.solution import Solution

INSTANTS = 40
"""A quantity is looked at in so many instants, evenly spread over the motion."""


def magnitude_that_counts(response: Response, solution: Solution, value: Any) -> float:
    """What an error of a response is compared with.

    It is the largest magnitude in the motion; but of a place or an angle at least what Newton leaves undecided of it, so that one that
    is zero by symmetry is not wrong by its own round-off.
    """
    scene, options = solution.system.scene, solution.options or solution.system.scene.solver
    whole = {"angle": 1.0, "length": scene.size}.get(response.unit_quantity, 0.0)
    return max(largest_magnitude(response, solution, value), options.tolerance * whole)


@singledispatch
def largest_magnitude(response: Response, solution: Solution, value: Any) -> float:
    """Largest magnitude that the response's quantity has in the motion: a value that just passes zero is not wrong by infinitely much."""
    return float(abs(np.real(value)))


@largest_magnitude.register
def _(response: Instant, solution: Solution, value: Any) -> float:
    look = response.instants(solution)
    return max(
        abs(float(np.real(value))), *(abs(float(np.real(look(step).value))) for step in spread(len(solution.times) - 1, INSTANTS))
    )


@largest_magnitude.register
def _(response: OverTime, solution: Solution, value: Any) -> float:
    return response.of_size(largest_magnitude(response.source, solution, 0.0), _duration(solution))


@singledispatch
def largest_slopes(response: Response, solution: Solution) -> np.ndarray:
    """Largest magnitudes (n_x,) that the response's derivatives have in the motion, as far as the solution holds derivatives; else zero."""
    return np.zeros(solution.system.n_x)


@largest_slopes.register
def _(response: Instant, solution: Solution) -> np.ndarray:
    if not solution.system.n_x:
        return np.zeros(0)
    look = response.instants(solution)
    return np.nan_to_num(
        np.max([np.abs(_slope(look(step), solution, step)) for step in spread(len(solution.times) - 1, INSTANTS)], axis=0)
    )


@largest_slopes.register
def _(response: OverTime, solution: Solution) -> np.ndarray:
    size, slopes = largest_magnitude(response.source, solution, 0.0), largest_slopes(response.source, solution)
    return response.of_slopes(size, slopes, _duration(solution))


def _duration(solution: Solution) -> float:
    return float(solution.whole_run[-1] - solution.whole_run[0])


def _slope(found: Partials, solution: Solution, step: int) -> np.ndarray:
    """Total derivative of the quantity at one step, (n_x,)."""
    total = np.zeros(solution.system.n_x) if found.design is None else np.real(found.design).astype(float)
    pairs = ((getattr(found, state), getattr(solution, f"d{state}")) for state in STATES)
    return total + sum(np.real(partial) @ derivative[step] for partial, derivative in pairs if partial is not None)
