"""Sparse factors of a large symmetric static matrix [K, J^T; J, 0], where it is stable.

K is positive against all motions that the joints allow if K + r J^T J is positive definite for some r, which its pivots without exchanges
tell: they are all positive. If they are not, nothing is known, and dense factors have to tell.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from toolkit.solvers.static.stability.static_array import StaticArray, largest_entry
from toolkit.system.system import System

HOLD = 10.0
"""Stiffness r of the joints in parts of the largest of the bodies."""
TRUSTED = 1e-4
"""Refinement of a solution, in parts of it, up to which factors are believed: after it the square of that is left, and what is asked of
them are signs and first digits. Skins of 1500 and 2000 elements leave some 1e-5, and dense factors would take ten times as long."""


class SparseFactors(NamedTuple):
    """Sparse factors of a stable symmetric matrix, with the matrix."""

    matrix: scipy.sparse.csc_array
    factors: scipy.sparse.linalg.SuperLU

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        """Solution for rhs (n,) or (n, columns), refined once."""
        found = self.factors.solve(rhs)
        refined: np.ndarray = found + self.factors.solve(rhs - self.matrix @ found)
        return refined


def sparse_factors(system: System, scaled: StaticArray) -> SparseFactors | None:
    """Factors of a symmetric matrix (n, n) in coordinates of comparable size; None if it is dense, or not known to be stable."""
    n_b = system.n_b
    if isinstance(scaled, np.ndarray):
        return None
    stiffness, ties, largest = scaled[:n_b, :n_b], scaled[n_b:, :n_b], largest_entry(scaled[:n_b])
    if not _positive(scipy.sparse.csc_array(stiffness + HOLD / largest * (ties.T @ ties))):
        return None
    matrix = scipy.sparse.csc_array(scaled)
    try:
        factors = scipy.sparse.linalg.splu(matrix)
    except RuntimeError:  # exactly singular
        return None
    probe = np.ones(system.n)
    found = factors.solve(probe)
    change = factors.solve(probe - matrix @ found)
    return SparseFactors(matrix, factors) if abs(change).max() <= TRUSTED * abs(found).max() else None


def _positive(matrix: scipy.sparse.csc_array) -> bool:
    """Whether a symmetric matrix is positive definite."""
    try:
        factors = scipy.sparse.linalg.splu(
            matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
    except RuntimeError:
        return False
    return bool(np.array_equal(factors.perm_r, factors.perm_c) and np.all(factors.U.diagonal() > 0))
