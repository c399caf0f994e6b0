"""Planes that cut off designs which could not be solved, as further constraints: a search may go on along them.

    BACK |d| - (z - z_0) . d / |d| >= 0,    d = z_failed - z_0

from the last design z_0 that could. A box about z_0 would stop the search in all other directions too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.studies.optimization.methods.functions import Functions
from toolkit.studies.optimization.program import Values

BACK = 0.5
"""Part of the way to a failed design up to which a search may go."""
STANDS = 0.05
"""Distance to a plane, in parts of that way, below which a search stands at it."""
NEAREST = 1e-5
"""Length of that way, in parts of the variables' ranges, below which nothing is left of it."""


class Plane(NamedTuple):
    """normal . z <= limit, half-way along a way of some length."""

    normal: np.ndarray
    limit: float
    length: float


class Cuts:
    """Planes, none at first."""

    def __init__(self) -> None:
        self._planes: list[Plane] = []
        self._patience, self._waited, self._released = 1, 0, False

    def add(self, good: np.ndarray, failed: np.ndarray) -> bool:
        """Cut off a failed design, which was sought from a good one; whether they are far enough from each other."""
        if self._released:
            self._patience *= 2
        self._released, self._waited = False, 0
        way = failed - good
        length = float(np.sqrt(way @ way))
        if length < NEAREST:
            return False
        self._planes.append(Plane(way / length, BACK * length + float(good @ way) / length, length))
        return True

    def release(self, z: np.ndarray) -> None:
        """Forget the planes at which a search stands: what failed once, far behind them, is no reason to stay there. Where the next design
        fails again, it waits twice as long the next time."""
        self._waited += 1
        if self._waited >= self._patience:
            kept = [each for each in self._planes if each.limit - each.normal @ z > STANDS * each.length]
            self._released = self._released or len(kept) < len(self._planes)
            self._planes = kept

    def around(self, functions: Functions) -> Functions:
        """The functions with the planes as further constraints."""
        if not self._planes:
            return functions
        normals, limits = np.array([each.normal for each in self._planes]), np.array([each.limit for each in self._planes])

        def within(z: np.ndarray) -> Values:
            found = functions(z)
            slopes = np.vstack([found.dc.reshape(-1, len(z)), -normals])
            return found._replace(c=np.concatenate([found.c, limits - normals @ z]), dc=slopes)

        return within
