"""SciPy's methods, on functions that raise where a design fails: none ever sees a value that is none."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import BFGS, Bounds, NonlinearConstraint, minimize

from toolkit.studies.optimization.methods.functions import Functions, Visited

INSIDE = 1e-9
"""How far within its bounds the interior-point method begins."""
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
    """An interior-point method with a trust region (Byrd, Hribar and Nocedal, 1999); arguments as of `slsqp`."""
    z = np.clip(z, low + INSIDE * (high - low), high - INSIDE * (high - low))
    constraint = NonlinearConstraint(lambda z: functions(z).c, 0.0, np.inf, jac=lambda z: functions(z).dc, hess=BFGS())

    def callback(z: np.ndarray, _: Any) -> bool:
        visited(np.array(z))
        return False

    minimize(
        lambda z: functions(z).f,
        z,
        jac=lambda z: functions(z).df,
        method="trust-constr",
        hess=BFGS(),
        bounds=Bounds(low, high, keep_feasible=True),
        constraints=[constraint] if len(functions(z).c) else [],
        callback=callback,
        options={
            "gtol": FINE,
            "xtol": FINE,
            "maxiter": most,
            "initial_tr_radius": FIRST_STEP * np.sqrt(len(z)),
            "initial_barrier_parameter": BARRIER,
            "initial_barrier_tolerance": BARRIER,
        },
    )


FIRST_STEP, BARRIER = 0.1, 1e-2
"""Radius of the first step in parts of the variables' ranges, and the first barrier in parts of the first slope of the objective."""
