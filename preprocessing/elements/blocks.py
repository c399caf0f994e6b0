"""Matrices that elements make, before they are one of the body: dense blocks of many elements at once, and where each of them stands."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy import sparse

CANCELLED = 1e-13
"""Part of the sum of the absolute values, below which a sum of some hundred numbers is round-off."""


@dataclass(frozen=True, eq=False)
class Places:
    """Rows and columns of the body's matrix, element by element."""

    elements: np.ndarray  # (n_e,) their numbers
    rows: np.ndarray  # (n_e, k)
    columns: np.ndarray  # (n_e, p)
    shape: tuple[int, int]  # of the body's matrix

    @cached_property
    def entries(self) -> tuple[np.ndarray, np.ndarray]:
        """Row and column of every number of the blocks, after each other."""
        row, column = np.broadcast_arrays(self.rows[:, :, None], self.columns[:, None, :])
        return row.ravel(), column.ravel()


@dataclass(frozen=True, eq=False)
class Blocks:
    """Blocks of some elements; sums and multiples of them make no sparse matrix, which costs more than their numbers."""

    places: Places
    values: np.ndarray  # (n_e, k, p)

    __array_ufunc__ = None  # a number of numpy leaves products to this class

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of the body's matrix."""
        return self.places.shape

    @cached_property
    def sparse(self) -> Any:
        """Body's matrix as a sparse one, by rows."""
        return sparse.coo_array((self.values.ravel(), self.places.entries), shape=self.shape).tocsr()

    def __add__(self, other: Blocks) -> Blocks:
        if self.places is not other.places:
            raise ValueError("blocks of different elements have no sum; make matrices of them first.")
        return Blocks(self.places, self.values + other.values)

    def __rmul__(self, factor: Any) -> Blocks:
        return Blocks(self.places, factor * self.values)

    def __matmul__(self, shapes: Any) -> Any:
        return self.sparse @ shapes

    def squared(self) -> Blocks:
        """Products F^T F of rows F, no two elements of which share a row."""
        at, n = self.places, self.shape[1]
        return Blocks(Places(at.elements, at.columns, at.columns, (n, n)), np.swapaxes(self.values, 1, 2) @ self.values)


def without_cancelled(sums: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Real sums with zeros where all but round-off of their summands cancels; `sizes` are the sums of their absolute values."""
    return np.where(np.abs(sums) > CANCELLED * sizes, sums, 0.0)


def sparse_of(matrix: Any) -> Any:
    """Sparse matrix of the body, by rows."""
    return matrix.sparse if isinstance(matrix, Blocks) else matrix.tocsr()


def weighted_sum(terms: list[tuple[Any, Any]], shape: tuple[int, int]) -> Any:
    """Sum of weights times matrices as one sparse matrix by rows; all blocks come into it by one conversion."""
    blocks = [(weight, each) for weight, each in terms if isinstance(each, Blocks)]
    whole = [weight * each for weight, each in terms if not isinstance(each, Blocks)]
    if blocks:
        row, column = (np.concatenate([each.places.entries[k] for _, each in blocks]) for k in (0, 1))
        value = np.concatenate([weight * each.values.ravel() for weight, each in blocks])
        whole.append(sparse.coo_array((value, (row, column)), shape=shape))
    return sum(whole[1:], whole[0]).tocsr() if whole else sparse.csr_array(shape)
