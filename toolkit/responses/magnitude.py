"""The magnitude of a response in a motion: what an error of it is to be compared with."""

from __future__ import annotations

from functools import singledispatch
from typing import Any

import numpy as np

from toolkit.responses.instant import Instant, TimeIntegral
from toolkit.responses.response import Response
from toolkit.solution import Solution

INSTANTS = 40
"""A quantity is looked at in so many instants, evenly spread over the motion."""


@singledispatch
def largest_magnitude(response: Response, solution: Solution, value: Any) -> float:
    """Largest magnitude that the response's quantity has in the motion: a value that just passes zero is not wrong by infinitely much."""
    return float(abs(np.real(value)))


@largest_magnitude.register
def _(response: Instant, solution: Solution, value: Any) -> float:
    steps = np.unique(np.linspace(0, len(solution.times) - 1, INSTANTS).round().astype(int))
    return max(abs(float(np.real(value))), *(abs(float(np.real(response.at(solution, step).value))) for step in steps))


@largest_magnitude.register
def _(response: TimeIntegral, solution: Solution, value: Any) -> float:
    return largest_magnitude(response.of, solution, 0.0) * float(solution.whole_run[-1] - solution.whole_run[0])
