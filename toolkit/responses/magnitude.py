"""The magnitude of a response in a motion: what an error of it is to be compared with."""

from __future__ import annotations

from functools import singledispatch
from typing import Any

import numpy as np

from toolkit.responses.instant import Instant, TimeIntegral
from toolkit.responses.response import Response
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
    return max(
        abs(float(np.real(value))), *(abs(float(np.real(response.at(solution, step).value))) for step in _instants(solution))
    )


@largest_magnitude.register
def _(response: TimeIntegral, solution: Solution, value: Any) -> float:
    return largest_magnitude(response.of, solution, 0.0) * float(solution.whole_run[-1] - solution.whole_run[0])


@singledispatch
def largest_slopes(response: Response, solution: Solution) -> np.ndarray:
    """Largest magnitudes (n_x,) that the response's derivatives have in the motion, as far as the solution holds derivatives; else zero."""
    return np.zeros(solution.system.n_x)


@largest_slopes.register
def _(response: Instant, solution: Solution) -> np.ndarray:
    if not solution.system.n_x:
        return np.zeros(0)
    return np.nan_to_num(np.max([np.abs(_slope(response, solution, step)) for step in _instants(solution)], axis=0))


@largest_slopes.register
def _(response: TimeIntegral, solution: Solution) -> np.ndarray:
    return largest_slopes(response.of, solution) * float(solution.whole_run[-1] - solution.whole_run[0])


def _instants(solution: Solution) -> list[int]:
    return [int(step) for step in np.unique(np.linspace(0, len(solution.times) - 1, INSTANTS).round())]


def _slope(response: Instant, solution: Solution, step: int) -> np.ndarray:
    """Total derivative of the quantity at one step, (n_x,)."""
    found = response.at(solution, step)
    total = np.zeros(solution.system.n_x) if found.design is None else np.real(found.design).astype(float)
    pairs = ((found.q, solution.dq), (found.v, solution.dv), (found.multipliers, solution.dmultipliers))
    return total + sum(np.real(partial) @ derivative[step] for partial, derivative in pairs if partial is not None)
