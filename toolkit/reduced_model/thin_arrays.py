"""Large arrays that are zero nearly everywhere, as those of a full basis are: worked on at the price of what is not zero."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy

LARGE = 1_000_000
"""Numbers of an array that is worth the search for those that are not zero."""
SPARSE = 0.05
"""Part of them that is not zero, below which an array is thin."""


def is_thin(array: np.ndarray, large: int | None = None) -> bool:
    """Whether an array is large, with at least `large` numbers, and zero nearly everywhere."""
    return array.size >= (LARGE if large is None else large) and bool(np.count_nonzero(array) < SPARSE * array.size)


def sparing(array: np.ndarray, large: int | None = None) -> Any:
    """Array as a matrix with all axes but the last one in one; sparse if it is thin."""
    rows = array.reshape(-1, array.shape[-1])
    return scipy.sparse.csr_array(rows) if is_thin(array, large) else rows


def is_sparse(array: Any) -> bool:
    """Whether an array is one of SciPy's sparse arrays.

    Importing those takes a tenth of a second, which a run without any need not pay.
    """
    return hasattr(array, "tocsr")


def listed(array: Any) -> tuple[np.ndarray, np.ndarray]:
    """Places in the flattened array in their order, and the values there: of a sparse array the stored ones, of others all."""
    if not is_sparse(array):
        return np.arange(np.size(array)), np.ravel(array)
    every = array.tocsr().tocoo()
    entry = np.ravel_multi_index(every.coords, every.shape)
    order = np.argsort(entry)
    return entry[order], every.data[order]


def places(array: np.ndarray, *others: np.ndarray) -> np.ndarray:
    """Places of the flattened array that are not zero or are named, in their order; all of an array that is not thin."""
    if not is_thin(array):
        return np.arange(array.size)
    return np.unique(np.concatenate([np.flatnonzero(array), *others]))
