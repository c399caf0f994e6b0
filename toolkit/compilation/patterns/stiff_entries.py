"""Which entries of the stiffness matrix are so large that the round-off of their products with the coordinates would be felt."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.bodies.kernels.constant_kernel import HALVES
from toolkit.compilation.conversions import ints

FELT = 1e-8
"""Part of the largest comparable entry from which an entry is summed in twice the precision. What is smaller leaves a round-off that is
smaller by as much, while the softest motion of a skin of 600 elements is 1e12 times softer than the stiffest. (With 1e-2, which leaves
out what couples displacements with rotations, corrections from 300 elements on never fell below 1e-10.)"""


class StiffEntries(NamedTuple):
    """Arrays of the stiffness entries that are summed in twice the precision, and of all others; fields as in `Constant`."""

    soft: np.ndarray
    stiff_row: np.ndarray
    stiff_start: np.ndarray
    stiff_column: np.ndarray
    stiff_high: np.ndarray
    stiff_low: np.ndarray


def stiff_entries(
    row: np.ndarray, column: np.ndarray, stiffness: np.ndarray, weights: np.ndarray, body: np.ndarray, bodies: int
) -> StiffEntries:
    """Stiff entries row by row, for `constant_kernel`, and before them the stiffness without them.

    Entries of one `body`, whose number each has, are compared as |K_ik| / (w_i w_k): the work of a motion by the model size, free of
    units.
    """
    size = np.abs(np.real(stiffness)) / (weights[row] * weights[column])
    largest = np.zeros(bodies)
    np.maximum.at(largest, body, size)
    chosen = np.flatnonzero((size > 0) & (size >= FELT * largest[body]))
    chosen = chosen[np.argsort(row[chosen], kind="stable")]
    stiff_row, start = np.unique(row[chosen], return_index=True)
    soft, stiff = stiffness.copy(), stiffness[chosen]
    soft[chosen] = 0
    high = HALVES * stiff - (HALVES * stiff - stiff)
    return StiffEntries(soft, stiff_row, ints([start, [len(chosen)]]), column[chosen], high, stiff - high)
