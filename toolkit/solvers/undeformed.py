"""The scene as it is given, at rest: a state to linearise about where no load can hold it."""

from __future__ import annotations

import numpy as np

from toolkit.solution import Solution
from toolkit.solvers.initial_conditions import consistent_start
from toolkit.system import System
from toolkit.validity.judge import judge


def undeformed(system: System) -> Solution:
    """The given positions without velocity, with the joint forces that the loads at t = 0 call for.

    Raises
    ------
    InputError, SingularSystemError
        As `consistent_start`.
    """
    start = consistent_start(system, np.array([1.0, 0.0, 0.0]), v=np.zeros(system.n_q))
    return Solution.from_padded(system, np.zeros(1), tuple(item[None] for item in start), judge=judge)
