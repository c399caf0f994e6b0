"""The scene as it is given, at rest: a state to linearise about where no load can hold it."""

from __future__ import annotations

import numpy as np

from toolkit.solvers.start.initial_conditions import closed_positions, initial_accelerations
from toolkit.system.solution import Solution
from toolkit.system.system import System
from toolkit.validity.judge import judge


def undeformed(system: System) -> Solution:
    """The given positions without velocity, with the joint forces that the loads at t = 0 call for.

    Raises
    ------
    InputError, SingularSystemError
        As `consistent_start`.
    """
    q, dq = closed_positions(system, None, 0.0)
    rest, drest = np.zeros_like(q), np.zeros_like(dq)
    acc, dacc = initial_accelerations(system, q, rest, dq, drest, np.array([1.0, 0.0, 0.0]), 0.0)
    return Solution.from_padded(system, np.zeros(1), tuple(item[None] for item in (q, rest, acc, dq, drest, dacc)), judge=judge)
