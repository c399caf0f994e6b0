"""What is neither slower nor less exact than anything else."""

from __future__ import annotations

import math
from collections.abc import Sequence


def pareto(points: Sequence[tuple[float, float]]) -> list[int]:
    """Numbers of the points (time, error) that no other dominates, by rising time; of equal points the first.

    A point dominates another if it is not larger in either and smaller in one. Points that are not finite belong to no set.
    """
    finite = [k for k, point in enumerate(points) if all(map(math.isfinite, point))]
    found, least = [], math.inf
    for k in sorted(finite, key=lambda k: points[k]):
        if points[k][1] < least:
            found.append(k)
            least = points[k][1]
    return found
