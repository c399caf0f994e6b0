"""Statics whose drivers lead a mechanism to a limit position: no load snaps through there, and no equilibrium lies behind."""

from __future__ import annotations

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import (
    ConvergenceError,
    CriticalPointError,
    LimitPointError,
    LimitPositionError,
    SingularSystemError,
)
from toolkit.solvers.closing.locked import limit_of_drivers, told_limit
from toolkit.solvers.static.equilibrium import inputs_at
from toolkit.system.system import System

NEARBY = 0.01
"""Part of the way of the drivers within which a limit position is the limit point that the path of equilibria has met."""


def at_limit_position(
    system: System, options: RunOptions, q: np.ndarray, factor: float, error: ConvergenceError | SingularSystemError
) -> ConvergenceError | SingularSystemError:
    """Error of a path from coordinates q (n,) at a factor on, or one that tells of the limit position to which drivers lead."""

    def acting(place: float):
        return inputs_at(system, options, place)

    limit = limit_of_drivers(system, acting, q, (0.0, factor, 1.0))
    met = error.load_factor if isinstance(error, CriticalPointError) else 1.0
    if limit is None or limit.place > met + NEARBY:
        return error
    text = told_limit(system, acting, limit, 1.0, f"at {100 * limit.place:.4g} % of the way of its drivers")
    if isinstance(error, CriticalPointError):
        return LimitPointError(text, error.load_factor, error.coordinate)
    return LimitPositionError(text)
