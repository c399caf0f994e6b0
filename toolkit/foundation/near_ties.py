"""Which one is the largest, where several are so but for the last digits: the first of them, so that every processor names the
same one."""

from __future__ import annotations

import numpy as np

BAND = 1e-6
"""Part of the largest by which sizes that mean the same may differ: round-off of a mechanism's state is far below, a difference
that a reader would see far above."""
SAME = 1e-9
"""Band for values of which one is the result: what stiff bodies leave of their digits."""


def first_largest(sizes: np.ndarray, band: float = BAND) -> int:
    """Number of the first size (n,) that is the largest but for a part `band` of it.

    Where a size is not a number, it is that of the first such one.
    """
    lost = np.isnan(sizes)
    if lost.any():
        return int(np.argmax(lost))
    largest = sizes.max()
    return int(np.argmax(sizes >= largest - band * abs(largest)))


def first_smallest(sizes: np.ndarray, band: float = BAND) -> int:
    """Number of the first size (n,), not negative, that is the smallest but for a part `band` of the largest."""
    return int(np.argmax(sizes <= sizes.min() + band * sizes.max()))
