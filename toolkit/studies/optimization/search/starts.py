"""Where searches begin: the first where the scene stands, the others at the points of Sobol's sequence within the bounds."""

from __future__ import annotations

import numpy as np

from toolkit.studies.distributions.sobol_points import plain
from toolkit.studies.study.problem import Problem


def starts_of(problem: Problem, count: int) -> np.ndarray:
    """Designs, (count, n): more starts leave the first ones as they are.

    The sequence is not scrambled, so that it is the same everywhere; its first point, a corner of the bounds, is left out.
    """
    low, high = problem.bounds
    return np.vstack([problem.start, low + plain(count - 1, len(low)) * (high - low)])
