"""SciPy's methods, on functions that raise where a design fails: none ever sees a value that is none."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import BFGS, Bounds, NonlinearConstraint, minimize

from toolkit.studies.optimization.methods.functions import Functions, Visited
from toolkit.studies.optimization.program import Values
from toolkit.studies.optimization.promise import promised

INSIDE, KEPT = 1e-5, 1e-6
"""How far within its bounds the interior-point method begins, and above which a constraint counts as kept at its first design."""
NEAR = 0.05
"""Longest steps, in parts of the variables' ranges, by whose promise the interior-point method begins anew."""
FINE = 1e-12
"""Derivatives and changes of variables below which the interior-point method gives up: others decide earlier whether it has arrived."""
NOTHING = 1e-20
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
        options={"ftol": NOTHING, "maxiter": most},
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
        keep_feasible=first.c > KEPT,
    )

    def callback(z: np.ndarray, _: Any) -> bool:
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
            "gtol": FINE,
            "xtol": FINE,
            "maxiter": 10 * most,
            "initial_tr_radius": FIRST_STEP,
            "initial_barrier_parameter": barrier,
            "initial_barrier_tolerance": barrier,
            "initial_constr_penalty": PENALTY,
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
    kept = c > KEPT
    push = np.sum(dc[kept] / c[kept, None], axis=0)
    return float(np.clip(DECAY * (first.df @ push) / max(push @ push, np.finfo(float).tiny), *BARRIERS))


FIRST_STEP, PENALTY = 0.3, 1e-4
"""Radius of the first step, in which a constraint that changes by all of itself counts as one; and what a violation costs at first: at 1,
SciPy's default, changes of constraints that are not active outweigh those of the objective, and steps become small."""
DECAY, BARRIERS = 0.2, (1e-7, 1e-3)
"""Part of the barrier that is left, as of the method's own steps; and the least and the largest to begin with, in units of the
objective."""
