"""Coordinates of a body in pieces: the six motions of every end, in the order of the chain, but of the clamped one, which is the first."""

from __future__ import annotations

import numpy as np

from preprocessing.recipes.solids.pieces.placed_items import LEFT_OUT
from toolkit.reduced_model.elements import SPATIAL_LOCAL

MOTIONS = SPATIAL_LOCAL // 2
"""Number of motions of an end: along x, y and z, and about them."""
CLAMPED = 0
"""Number of the end that the frame of the body is tied to."""


def columns_of_end(number: int) -> np.ndarray:
    """Columns of [1; q_f] of the body that are the motions of an end, (6,); `LEFT_OUT` at the clamp."""
    return np.full(MOTIONS, LEFT_OUT) if number == CLAMPED else 1 + MOTIONS * (number - 1) + np.arange(MOTIONS)


def columns_of_piece(number: int) -> np.ndarray:
    """Column of [1; q_f] of the body for each of those of a piece, (13,)."""
    return np.concatenate([[0], columns_of_end(number), columns_of_end(number + 1)])
