"""A look around a stationary start, which may be a maximum or a saddle, as where a mechanism is symmetric."""

from __future__ import annotations

import numpy as np

from toolkit.studies.distributions.sobol_points import plain
from toolkit.studies.optimization.methods.functions import DesignFailedError
from toolkit.studies.optimization.search.explored import Explored

BESIDE, LOOKS = 0.2, 8
"""How wide, in parts of the variables' ranges, and at how many designs a search looks around a start that is stationary."""
ASKEW = 0.07
"""By which these designs are shifted, so that none of them stands at the start or mirrors another."""
LOWER = 1e-9
"""Part of an objective by which another one is lower, and not by round-off."""


def best_beside(explored: Explored, z: np.ndarray) -> np.ndarray:
    """The best feasible one of some designs around z, z itself if none is lower."""
    here, best, top = explored.functions(z), z, explored.program.top
    least = here.f - LOWER * max(1.0, abs(here.f))
    for point in plain(LOOKS, len(z)):
        there = np.clip(z + BESIDE * top * (2 * point - 1 + ASKEW), 0.0, top)
        try:
            values = explored.functions(there)
        except DesignFailedError:
            continue
        if values.f < least and np.min(values.c, initial=0.0) >= -explored.options.feasibility:
            least, best = values.f, there
    return best
