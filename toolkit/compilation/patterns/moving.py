"""Changing entries of the loop's matrices: all that joints, loads and turning frames touch; the rest is constant."""

from __future__ import annotations

import numpy as np

from toolkit.compilation.numbering import Numbering
from toolkit.compilation.quantities import Quantities


def moving_unknowns(numbering: Numbering, values: Quantities, felt: np.ndarray) -> np.ndarray:
    """Unknowns (n,) that joints, loads or the frame of a body act on, so that entries between two of them may change.

    `felt` are the coordinates that markers feel.
    """
    moving = np.ones(numbering.n, bool)
    edges = [*numbering.first.values(), numbering.n_q]
    for b in values.constant:
        if b not in values.floating:
            moving[edges[b] : edges[b + 1]] = False
    moving[felt] = True
    return moving
