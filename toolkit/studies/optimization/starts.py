"""Where searches begin: the first where the scene stands, the others at the points of Sobol's sequence within the bounds."""

from __future__ import annotations

import numpy as np
from scipy.stats.qmc import Sobol

from toolkit.studies.study.problem import Problem


def starts_of(problem: Problem, count: int) -> np.ndarray:
    """Designs, (count, n): more starts leave the first ones as they are.

    The sequence is not scrambled, so that it is the same everywhere; its first point, a corner of the bounds, is left out.
    """
    low, high = problem.bounds
    power = max(1, int(np.ceil(np.log2(count + 1))))
    points = Sobol(len(low), scramble=False).random_base2(power)[1:count]
    return np.vstack([problem.start, low + points * (high - low)])
