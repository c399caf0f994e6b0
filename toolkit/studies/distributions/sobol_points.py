"""Points of Sobol's sequence in the unit cube: the same everywhere, and the first ones stay where more are asked for."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from scipy.stats.qmc import Sobol


def scrambled(count: int, dimension: int, seed: int) -> np.ndarray:
    """The first scrambled points, (count, dimension)."""
    power = max(1, math.ceil(math.log2(count)))
    found: np.ndarray = _sequence(dimension, scramble=True, rng=np.random.default_rng(seed)).random_base2(power)[:count]
    return found


def plain(count: int, dimension: int) -> np.ndarray:
    """The first points as they are, (count, dimension), without the very first, which is a corner."""
    power = max(1, math.ceil(math.log2(count + 1)))
    found: np.ndarray = _sequence(dimension, scramble=False).random_base2(power)[1 : count + 1]
    return found


def _sequence(dimension: int, **options: Any) -> Sobol:
    """The sequence; the package is imported here, since it takes as long as a fifth of the program, and designs are solved without it."""
    from scipy.stats.qmc import Sobol

    return Sobol(dimension, **options)
