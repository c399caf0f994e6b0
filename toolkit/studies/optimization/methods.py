"""Optimisation methods of SciPy and NLopt by the names that a study writes, and the functions that they are given."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import BFGS, Bounds, NonlinearConstraint, minimize

from toolkit.foundation.errors import InputError
from toolkit.studies.optimization.program import Values, promised


class DesignFailedError(Exception):
    """A design could not be solved: z, (n,)."""

    def __init__(self, z: np.ndarray) -> None:
        super().__init__("a design could not be solved")
        self.z = z


Functions = Callable[[np.ndarray], Values]
"""Objective and constraints at z with their derivatives; raises where a design fails."""
Visited = Callable[[np.ndarray], None]
"""Is told every z that a method has accepted; raises where the search is to end."""
Run = Callable[[Functions, np.ndarray, np.ndarray, np.ndarray, Visited, int], None]
"""Searches from z between low and high, with at most so many designs."""


class Method(NamedTuple):
    """A method, and when it begins anew in variables by the curvature where it stands.

    Attributes
    ----------
    run
        Searches.
    learned, told
        Designs after which it does: where only the designs that were solved tell the curvature, and where the responses do; None, if it
        stays as it is.
    inside
        How far within the bounds it begins, in parts of the variables' ranges.
    near
        Length of steps, in parts of the variables' ranges, whose promise says where it begins anew; zero for where the objective is least.
    """

    run: Run
    learned: int | None = None
    told: int | None = None
    inside: float = 0.0
    near: float = 0.0


CONSTRAINT_CURVATURE_SHARE, SMALLEST_CONSTRAINT = 0.1, 1e-6
"""Constraints are told in such units that the curvature of one, with which both methods begin for all functions, takes this part of them
along the first step, which is as long as the slope; they are at least so far, in parts of their sizes."""
CONSTRAINT_TOLERANCE = 1e-7
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
        merit = [max(0.0, -float(np.min(values.c, initial=0.0)) - CONSTRAINT_TOLERANCE), values.f]
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
    sizes = first.df @ first.df / (2 * CONSTRAINT_CURVATURE_SHARE * np.maximum(np.abs(first.c), SMALLEST_CONSTRAINT))
    if len(sizes):
        method.add_inequality_mconstraint(constraints, CONSTRAINT_TOLERANCE * sizes)
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


BOUND_DISTANCE, KEPT_CONSTRAINT = 1e-5, 1e-6
"""How far within its bounds the interior-point method begins, and above which a constraint counts as kept at its first design."""
RESTART_STEP = 0.05
"""Longest steps, in parts of the variables' ranges, by whose promise the interior-point method begins anew."""
LEAST_CHANGE = 1e-12
"""Derivatives and changes of variables below which the interior-point method gives up: others decide earlier whether it has arrived."""
LEAST_OBJECTIVE_CHANGE = 1e-20
"""Change of the objective below which SLSQP gives up: in units of the slopes at a wild first design there is still something to find by
changes of 1e-12."""


def slsqp(functions: Functions, z: np.ndarray, low: np.ndarray, high: np.ndarray, visited: Visited, most: int) -> None:
    """Sequential quadratic programming (Kraft, 1988); `visited` is told every design that it has accepted."""
    constraint = {"type": "ineq", "fun": lambda z: functions(z).c, "jac": lambda z: functions(z).dc}
    minimize(
        lambda z: functions(z).f,
        z,
        jac=lambda z: functions(z).df,
        method="SLSQP",
        bounds=Bounds(low, high),
        constraints=[constraint] if len(functions(z).c) else [],
        callback=lambda z: visited(np.array(z)),
        options={"ftol": LEAST_OBJECTIVE_CHANGE, "maxiter": most},
    )


def trust_constr(functions: Functions, z: np.ndarray, low: np.ndarray, high: np.ndarray, visited: Visited, most: int) -> None:
    """An interior-point method with a trust region (Byrd, Hribar and Nocedal, 1999), with the curvature of the objective where it is told,
    and none of the constraints then: what is learned of these begins with the identity, which in variables where the objective is round
    is as much as all of it. Arguments as of `slsqp`, but that z lies inside of its bounds."""
    first, bounded = functions(z), bool(np.all(np.isfinite([low, high])))
    constraint = NonlinearConstraint(
        lambda z: functions(z).c,
        0.0,
        np.inf,
        jac=lambda z: functions(z).dc,
        hess=BFGS() if first.curvature is None else lambda z, _: np.zeros((len(z), len(z))),
        keep_feasible=first.c > KEPT_CONSTRAINT,
    )

    def callback(z: np.ndarray, _: object) -> bool:
        visited(np.array(z))
        return False

    barrier = _barrier(first, z, low, high)
    minimize(
        lambda z: functions(z).f,
        z,
        jac=lambda z: functions(z).df,
        method="trust-constr",
        hess=BFGS() if first.curvature is None else lambda z: functions(z).curvature,
        bounds=Bounds(low, high, keep_feasible=True) if bounded else None,
        constraints=[constraint] if len(first.c) else [],
        callback=callback,
        options={
            "gtol": LEAST_CHANGE,
            "xtol": LEAST_CHANGE,
            "maxiter": 10 * most,
            "initial_tr_radius": FIRST_STEP,
            "initial_barrier_parameter": barrier,
            "initial_barrier_tolerance": barrier,
            "initial_constr_penalty": FIRST_PENALTY,
        },
    )


def _barrier(first: Values, z: np.ndarray, low: np.ndarray, high: np.ndarray) -> float:
    """The barrier mu to begin with. Where curvature tells what there is to gain, m mu, which m constraints leave of the objective, is that;
    else it is less than the one whose minimum z is nearest to: df = mu sum of dc_i / c_i in the least squares."""
    n, bounded = len(z), np.isfinite(low)
    c = np.concatenate([first.c, (z - low)[bounded], (high - z)[bounded]])
    if first.curvature is not None:
        return float(np.clip(promised(z - low, high - z, first) / max(1, len(c)), *BARRIERS))
    dc = np.vstack([first.dc.reshape(-1, n), np.eye(n)[bounded], -np.eye(n)[bounded]])
    kept = c > KEPT_CONSTRAINT
    push = np.sum(dc[kept] / c[kept, None], axis=0)
    return float(np.clip(BARRIER_DECAY * (first.df @ push) / max(push @ push, np.finfo(float).tiny), *BARRIERS))


FIRST_STEP, FIRST_PENALTY = 0.3, 1e-4
"""Radius of the first step, in which a constraint that changes by all of itself counts as one; and what a violation costs at first: at 1,
SciPy's default, changes of constraints that are not active outweigh those of the objective, and steps become small."""
BARRIER_DECAY, BARRIERS = 0.2, (1e-7, 1e-3)
"""Part of the barrier that is left, as of the method's own steps; and the least and the largest to begin with, in units of the
objective."""


METHODS = {
    "slsqp": Method(slsqp, learned=10, told=5),
    "trust-constr": Method(trust_constr, told=5, inside=BOUND_DISTANCE, near=RESTART_STEP),
    "mma": Method(mma, told=1),
    "ccsa": Method(ccsa, told=1),
}
"""SLSQP learns the curvature anew each time. MMA and CCSA never do, and begin anew with every step where it is told; the interior-point
method takes it as it is told, in variables in which that is round."""
