"""Sums of multiples of rows: what gradients spend most of their time with.

LLVM takes several numbers at once in long loops alone, and rows of a block have as many numbers as there are design variables. So the code
for these sums is written for the compiler, in `rows_code`; as plain Python, and for complex numbers, they are what stands here. Rows are
filled up to whole vectors: a processor waits where it reads several numbers together that were written one by one just before.
"""

from __future__ import annotations

import numpy as np

LANES = 8
"""Numbers of one vector."""


def filled_up(count: int) -> int:
    """Length of a row for so many numbers."""
    return -(-count // LANES) * LANES


def add_rows(
    target: np.ndarray,
    scale: float,
    factor: float,
    entries: np.ndarray,
    numbers: np.ndarray,
    first: int,
    last: int,
    source: np.ndarray,
) -> None:
    """target = scale (target + factor times the sum of entries[p] source[numbers[p]] over p = first ... last - 1).

    Parameters
    ----------
    target : (w,)
        Contiguous, w a multiple of LANES.
    scale, factor : float
    entries, numbers : (n_p,)
        Factors, and the rows that they belong to.
    first, last : int
    source : (n, w)
        Contiguous; row numbers[p] may not be the target.
    """
    target[:] = scale * (target + factor * (entries[first:last] @ source[numbers[first:last]]))
