"""What an optimisation method is given: functions of scaled variables, and somebody to tell where it stands."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

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
