"""Points of Sobol's sequence in the unit cube: the same everywhere, and the first ones stay where more are asked for."""

from __future__ import annotations

import math

import numpy as np
from scipy.stats.qmc import Sobol


def scrambled(count: int, dimension: int, seed: int) -> np.ndarray:
    """The first scrambled points, (count, dimension)."""
    power = max(1, math.ceil(math.log2(count)))
    found: np.ndarray = Sobol(dimension, scramble=True, rng=np.random.default_rng(seed)).random_base2(power)[:count]
    return found


def plain(count: int, dimension: int) -> np.ndarray:
    """The first points as they are, (count, dimension), without the very first, which is a corner."""
    power = max(1, math.ceil(math.log2(count + 1)))
    found: np.ndarray = Sobol(dimension, scramble=False).random_base2(power)[1 : count + 1]
    return found
