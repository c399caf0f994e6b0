"""The magnitude of a response in a motion: what an error of it is to be compared with."""

from __future__ import annotations

from functools import singledispatch
from typing import Any, NamedTuple

import numpy as np

from toolkit.foundation.spread import spread
from toolkit.responses.energy import StrainEnergy
from toolkit.responses.instant import Instant, slope_at
from toolkit.responses.over_time.over_time import OverTime
from toolkit.responses.response import Response
from toolkit.system.flexible_bodies import deforming
from toolkit.system.solution import Solution

INSTANTS, FEW = 40, 3
"""A quantity is looked at in so many instants, evenly spread over the motion; forces of what is deformed in few."""


class Largest(NamedTuple):
    """Largest magnitude of a quantity in a motion, and of its derivatives (n_x,), as far as the solution holds any."""

    magnitude: float
    slopes: np.ndarray


def magnitude_that_counts(response: Response, solution: Solution, largest: Largest) -> float:
    """Magnitude that a response's error is compared with.

    It is the largest magnitude in the motion; but at least what Newton leaves undecided of it, so that a place, a force or a power that is
    zero by symmetry is not wrong by its own round-off.
    """
    options = solution.options or solution.system.scene.solver
    return max(largest.magnitude, options.tolerance * _size_of_kind(response, solution))


def _size_of_kind(response: Response, solution: Solution) -> float:
    """The size of quantities of a response's kind in a motion: of lengths S the scene's, of angles 1 rad, and of what measures
    mass^m length^k time^t, with the largest rate R and the largest force F of a joint or of what is deformed,

        F^m S^(k - m) R^(-t - 2 m)
    """
    system, (m, k, t) = solution.system, response.physical_dimension
    if not (m or k or t):
        return float(response.unit_quantity == "angle")
    lengths, (speeds, changes, forces) = system.scene.size, _largest(solution)
    forces = max(forces, _elastic(solution)) if m else forces
    rate = max(speeds, np.sqrt(changes), 1 / solution.whole_run[-1])
    return float((forces / lengths) ** m * lengths ** (k - m) * rate ** (-t - 2 * m))


def _elastic(solution: Solution) -> float:
    """Largest elastic force in a motion: a joint that holds nothing has a force of the round-off of the rest in balance."""
    if not deforming(solution.system.scene):
        return 0.0
    if _elastic not in solution.known:
        law, weights = StrainEnergy(), solution.system.weights[: solution.system.n_q]
        found = [law.at(solution, step).q for step in spread(len(solution.times) - 1, FEW)]
        forces = [np.real(each) / weights for each in found if each is not None]
        solution.known[_elastic] = float(np.abs(forces).max(initial=0.0))
    largest: float = solution.known[_elastic]
    return largest


def _largest(solution: Solution) -> tuple[float, float, float]:
    """Largest rate, acceleration and joint force in a motion, in parts of the model size."""
    if _largest not in solution.known:
        n_q, weights = solution.system.n_q, solution.system.weights
        pairs = (solution.v, weights[:n_q]), (solution.a, weights[:n_q]), (solution.multipliers, 1 / weights[n_q:])
        solution.known[_largest] = tuple(float((np.abs(np.real(each)).max(axis=0) * by).max(initial=0.0)) for each, by in pairs)
    found: tuple[float, float, float] = solution.known[_largest]
    return found


@singledispatch
def largest_in(response: Response, solution: Solution, value: Any) -> Largest:
    """Largest magnitude of the response's quantity in the motion: a value that just passes zero has a finite relative error."""
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
