"""Sums of multiples of rows: what gradients, and bodies of many modes in space, spend most of their time with.

LLVM takes several numbers at once in long loops alone, and rows of a block have as many numbers as there are design variables. So the code
for these sums is written for the compiler, in `written_code`; as plain Python, and for complex numbers, they are what stands here. Rows are
filled up to whole vectors: a processor waits where it reads several numbers together that were written one by one just before.
"""

from __future__ import annotations

import numpy as np

LANES = 8
"""Numbers of one vector."""


def filled_up(count: int) -> int:
    """Length of a row for so many numbers, filled up."""
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


def add_to_each(
    targets: tuple[np.ndarray, ...], entries: np.ndarray, count: int, source: np.ndarray, start: int, stride: int
) -> None:
    """Add to each of up to three rows its own sum of multiples of the same rows, which are read once for all.

    targets[k] += the sum of entries[k, p] r_p over p = 0 ... count - 1, with r_p = source[start + p stride : ... + w].

    Parameters
    ----------
    targets : arrays (w,)
        Contiguous, w a multiple of LANES; not part of the source.
    entries : (3, n_p)
        Contiguous.
    count, start, stride : int
    source : (n,)
        Contiguous.
    """
    rows = source[start + stride * np.arange(count)[:, None] + np.arange(len(targets[0]))]
    for target, factors in zip(targets, entries, strict=False):
        target += factors[:count] @ rows


def subtract_multiples(
    values: np.ndarray, rows: tuple[int, ...], factors: tuple[float, ...], sources: tuple[int, ...], length: int
) -> None:
    """Subtract from each of one or more rows of an array its own sum of multiples of other rows.

    values[row : row + length] -= the sum over the sources of factor values[source : source + length].

    Parameters
    ----------
    values : (n,)
        Contiguous.
    rows : (n_r,)
        Where each row begins.
    factors : (n_r n_s,)
        Those of the first row, of the next, and so on.
    sources : (n_s,)
        Where each begins; none overlaps a row.
    length : int
    """
    for r, row in enumerate(rows):
        own = factors[r * len(sources) : (r + 1) * len(sources)]
        values[row : row + length] -= sum(
            factor * values[source : source + length] for factor, source in zip(own, sources, strict=True)
        )
