"""One equilibrium on a path: where it is, where the path goes from there, and how stable it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolkit.solvers.static.stability.softness import Softness


@dataclass(frozen=True)
class PathPoint:
    """An equilibrium z = [q; lam; factor] (n + 1,) on a path, with its direction and its stability.

    direction : dz along the path, of any length (n + 1,)
    negative : number of negative stiffnesses against motions that the joints allow
    soft : the stiffnesses nearest to zero
    softening : their change along the direction
    """

    z: np.ndarray
    direction: np.ndarray
    negative: int
    soft: Softness
    softening: np.ndarray

    @property
    def factor(self) -> float:
        """Load factor of the point."""
        return float(self.z[-1])

    @property
    def rate(self) -> float:
        """Change d factor along the direction, whose sign changes at a limit point."""
        return float(self.direction[-1])
