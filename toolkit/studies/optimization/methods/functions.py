"""What an optimisation method is given: functions of scaled variables, and somebody to tell where it stands."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from toolkit.studies.optimization.program import Values


class DesignFailedError(Exception):
    """A design could not be solved: z, (n,)."""

    def __init__(self, z: np.ndarray) -> None:
        super().__init__("a design could not be solved")
        self.z = z


Functions = Callable[[np.ndarray], Values]
"""Objective and constraints at z with their derivatives; raises where a design fails."""
Visited = Callable[[np.ndarray], None]
"""Is told every z that a method has accepted; raises where the search is to end."""
Method = Callable[[Functions, np.ndarray, np.ndarray, np.ndarray, Visited, int], None]
"""Searches from z between low and high, with at most so many designs."""
