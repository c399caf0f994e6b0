"""One load step along the path of equilibria, never a jump to another."""

from __future__ import annotations

import numpy as np

from toolkit.errors import ConvergenceError, SingularSystemError
from toolkit.run_options import RunOptions
from toolkit.solvers.equilibrium import Equilibrium, find_equilibrium
from toolkit.system import System

FREE_CORRECTION, TRUSTED_CORRECTION = 1e-3, 0.5
"""Newton may move a predicted state by this part of the scene's size, or by this part of the predictor; more would be a jump."""


def load_step(system: System, options: RunOptions, state: Equilibrium, factor: float, target: float) -> tuple[Equilibrium, int]:
    """Follow the tangent from one load factor to the next, then correct; the equilibrium and its Newton iterations.

    Raises
    ------
    ConvergenceError
        There is no equilibrium near the tangent.
    """
    n_q, step = system.n_q, (target - factor) * state.tangent
    moved = np.where(np.arange(system.n) < n_q, step, 0)
    reach = (system.weights * np.abs(np.real(moved)))[:n_q].max(initial=0)
    allowed = FREE_CORRECTION + TRUSTED_CORRECTION * reach
    try:
        return find_equilibrium(system, options, target, state.q + moved, state.acc + step - moved, allowed)
    except SingularSystemError as error:
        raise ConvergenceError(str(error)) from error
