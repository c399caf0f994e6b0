"""NLopt's methods with gradients, which are told of failed designs as SciPy's are; NLopt is imported when one is asked for."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.studies.optimization.methods.functions import Functions, Visited

SHARE, NEAR = 0.1, 1e-6
"""Constraints are told in such units that the curvature of one, with which both methods begin for all functions, takes this part of them
along the first step, which is as long as the slope; they are at least so far, in parts of their sizes."""
SLACK = 1e-7
"""By how much a constraint, in parts of its size, may be off at a design that counts as accepted."""


def mma(functions: Functions, z: np.ndarray, low: np.ndarray, high: np.ndarray, visited: Visited, most: int) -> None:
    """The globally convergent method of moving asymptotes (Svanberg, 2002); arguments as of `slsqp`."""
    _minimized("LD_MMA", functions, z, low, high, visited, most)


def ccsa(functions: Functions, z: np.ndarray, low: np.ndarray, high: np.ndarray, visited: Visited, most: int) -> None:
    """Conservative convex separable approximations by quadratics (Svanberg, 2002); arguments as of `slsqp`."""
    _minimized("LD_CCSAQ", functions, z, low, high, visited, most)


def _minimized(
    name: str, functions: Functions, z: np.ndarray, low: np.ndarray, high: np.ndarray, visited: Visited, most: int
) -> None:
    nlopt = required()
    method = nlopt.opt(getattr(nlopt, name), len(z))
    method.set_lower_bounds(low)
    method.set_upper_bounds(high)
    method.set_maxeval(most)
    best = [np.inf, np.inf]

    def objective(z: np.ndarray, gradient: np.ndarray) -> float:
        values = functions(z)
        if gradient.size:
            gradient[:] = values.df
        merit = [max(0.0, -float(np.min(values.c, initial=0.0)) - SLACK), values.f]
        if merit < best:  # what is nearer to the constraints, or keeps them and is better, is what the method goes on from
            best[:] = merit
            visited(np.array(z))
        return float(values.f)

    def constraints(result: np.ndarray, z: np.ndarray, gradient: np.ndarray) -> None:
        values = functions(z)
        result[:] = -sizes * values.c
        if gradient.size:
            gradient[:] = -sizes[:, None] * values.dc

    method.set_min_objective(objective)
    first = functions(z)
    sizes = first.df @ first.df / (2 * SHARE * np.maximum(np.abs(first.c), NEAR))
    if len(sizes):
        method.add_inequality_mconstraint(constraints, SLACK * sizes)
    try:
        method.optimize(np.clip(z, low, high))
    except nlopt.RoundoffLimited:
        return  # it goes no further; whether that is an optimum is decided elsewhere


def required() -> Any:
    """NLopt.

    Raises
    ------
    InputError
        It is not installed; says how to.
    """
    try:
        import nlopt
    except ImportError as error:
        raise InputError(
            "search.method: mma and ccsa are NLopt's, which is not installed. Install: pip install 'ffrf-toolkit[nlopt]', or write slsqp."
        ) from error
    return nlopt
