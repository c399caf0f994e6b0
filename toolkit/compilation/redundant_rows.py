"""Constraints that repeat others: which rows of the joints' Jacobian depend on the others in the undeformed configuration."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.foundation.errors import SingularSystemError

REPEATS, ALMOST = 1e-9, 1e-5
"""Part of a row, of length one, that is independent of the rows before it, below which it repeats them, and below which it nearly does:
such a joint jams, because points or axes do not fit."""
FIRST = 1e3
"""Factor by which the lengths of quaternions come first: they are never dropped."""
LONG = 0.63
"""Part of the longest row that is left from which a row is long enough to be taken. Rows of mechanisms are often equally long:
the first of them in the order of the scene is taken, so that a joint repeats those before it, and the same one on every
processor. No ratio of lengths that people choose."""


class Rows(NamedTuple):
    """Numbers of the rows of a Jacobian that are kept, of those that repeat others, and of those that nearly do."""

    kept: np.ndarray
    repeating: np.ndarray
    almost: np.ndarray  # of those that are kept


def independent_rows(jacobian: np.ndarray, weights: np.ndarray, first: np.ndarray) -> Rows:
    """Rows of a Jacobian (n_lam, n_q) that repeat the others, and those that nearly do.

    Orthogonalisation by Gram and Schmidt with pivoting, rows scaled to length one for coordinates divided by their weights
    (n_q,); rows in `first` are taken before all others.
    """
    rows = np.real(jacobian) / weights
    rows = rows / np.sqrt(np.sum(rows * rows, axis=1, keepdims=True)).clip(np.finfo(float).tiny)
    rows[first] *= FIRST
    numbers, kept, almost = np.arange(len(rows)), list[int](), list[int]()
    while len(rows):
        size = np.sqrt(np.sum(rows * rows, axis=1))
        if size.max() <= REPEATS:
            break
        place = int(np.argmax(size >= LONG * size.max()))
        kept.append(int(numbers[place]))
        if size[place] <= ALMOST:
            almost.append(int(numbers[place]))
        unit, others = rows[place] / size[place], np.arange(len(rows)) != place
        numbers, rows = numbers[others], rows[others]
        rows = rows - np.outer(rows @ unit, unit)
    return Rows(np.sort(kept).astype(int), numbers, np.sort(almost).astype(int))


def null_vectors(jacobian: np.ndarray, kept: np.ndarray, repeating: np.ndarray) -> np.ndarray:
    """Null vectors N (n_lam, k) with J^T N = 0, one for every repeating row d.

    N_d = e_d - C_d^T with J_d = C_d J_K for the rows K that are kept.

    Complex-safe: without a conjugate.
    """
    found: np.ndarray = np.zeros((len(jacobian), len(repeating)), jacobian.dtype)
    own = jacobian[kept]
    found[repeating, np.arange(len(repeating))] = 1
    try:
        found[kept] = -np.linalg.solve(own @ own.T, own @ jacobian[repeating].T)
    except np.linalg.LinAlgError as error:
        raise SingularSystemError(
            "the joints cannot be told apart: their lengths differ so much that round-off decides which of them repeat others. "
            "Check the points and their units."
        ) from error
    return found
