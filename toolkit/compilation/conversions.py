"""Small conversions to the integer arrays of the compiled loop."""

from __future__ import annotations

import numpy as np


def ints(parts: list) -> np.ndarray:
    """Lists of whole numbers, one after the other."""
    return np.concatenate([np.zeros(0, np.int64), *(np.asarray(part, np.int64) for part in parts)])


def starts(lengths: list[int]) -> np.ndarray:
    """Start of each block, and the end of the last, from the lengths of the blocks."""
    return np.concatenate([[0], np.cumsum(np.asarray(lengths, np.int64))]).astype(np.int64)
