"""A matrix with a border of one row and one column: a large sparse one by factors of the matrix alone."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from toolkit.solvers.static.stability.static_array import StaticArray

TRUSTED = 1e-10
"""Refinement of a solution, in parts of it, up to which it is believed: near a limit point the matrix alone is singular."""


@dataclass(frozen=True)
class Bordered:
    """A bordered matrix [A, f; b^T, c], which is factored once."""

    matrix: StaticArray  # A (n, n)
    column: np.ndarray  # f (n,)
    row: np.ndarray  # b (n,)
    corner: float  # c

    def solve(self, rhs: np.ndarray) -> np.ndarray | None:
        """Solution for rhs (n + 1,); None if there is none."""
        if isinstance(self.matrix, np.ndarray):
            return self._by_dense_factors(rhs)
        found = self._by_the_matrix_alone(rhs)
        return self._by_sparse_factors(rhs) if found is None else found

    def _by_dense_factors(self, rhs: np.ndarray) -> np.ndarray | None:
        factors, pivots, info = self._dense_factors
        return None if info else scipy.linalg.lapack.dgetrs(factors, pivots, rhs, trans=1)[0]

    @cached_property
    def _dense_factors(self) -> tuple[np.ndarray, np.ndarray, int]:
        """Factors of the whole matrix, transposed as LAPACK wants it, with pivots, and a number not 0 if it is singular."""
        n = len(self.column)
        full = np.empty((n + 1, n + 1))
        full[:n, :n], full[:n, n], full[n, :n], full[n, n] = self.matrix, self.column, self.row, self.corner
        factors, pivots, info = scipy.linalg.lapack.dgetrf(full.T, overwrite_a=1)
        return factors, pivots, info

    @cached_property
    def _sparse_factors(self) -> scipy.sparse.linalg.SuperLU | None:
        """Sparse factors of A alone; None if it is exactly singular."""
        try:
            return scipy.sparse.linalg.splu(scipy.sparse.csc_array(self.matrix))
        except RuntimeError:
            return None

    def _by_the_matrix_alone(self, rhs: np.ndarray) -> np.ndarray | None:
        """Solution by factors of A alone, refined once; None where A alone is too near to singular."""
        n, factors = len(self.column), self._sparse_factors
        if factors is None:
            return None
        along = factors.solve(self.column)
        rest = self.corner - self.row @ along

        def solved(wanted: np.ndarray) -> np.ndarray:
            inside = factors.solve(wanted[:n])
            last = (wanted[n] - self.row @ inside) / rest
            return np.append(inside - last * along, last)

        with np.errstate(all="ignore"):
            found = solved(rhs)
            change = solved(rhs - self._times(found))
        good = np.all(np.isfinite(change)) and np.abs(change).max() <= TRUSTED * np.abs(found).max()
        return found + change if good else None

    def _by_sparse_factors(self, rhs: np.ndarray) -> np.ndarray | None:
        """Solution by sparse factors of the whole matrix, which takes longer; None if it is exactly singular."""
        whole = scipy.sparse.block_array([[self.matrix, self.column[:, None]], [self.row[None], np.array([[self.corner]])]])
        try:
            found: np.ndarray = scipy.sparse.linalg.splu(scipy.sparse.csc_array(whole)).solve(rhs)
        except RuntimeError:
            return None
        return found

    def _times(self, x: np.ndarray) -> np.ndarray:
        inside, last = x[:-1], x[-1]
        return np.append(self.matrix @ inside + self.column * last, self.row @ inside + self.corner * last)
