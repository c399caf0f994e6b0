"""Factors of the static matrix [K, G; J, 0] in coordinates of comparable size, and what they tell of stability."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from toolkit.foundation.errors import SingularSystemError
from toolkit.solvers.static.stability.sparse_saddle import HOLD, SparseFactors, sparse_factors
from toolkit.solvers.static.stability.static_array import StaticArray, as_dense, largest_entry, scaled_by
from toolkit.system.system import System

SYMMETRIC = 1e-12
"""Asymmetry, a part of the largest entry, that is round-off."""
REAL = 1e-9
"""Imaginary part of an eigenvalue, a part of its size, that is round-off."""


class Saddle(NamedTuple):
    """Factors of S = D A D: L T L^T (symmetric; large and stable ones sparse) or P L U.

    D = diag(1/w) for coordinates; for multipliers it is such that all entries are comparable.

    `negative` is the number of motions that the joints allow against which the stiffness is negative.
    """

    scale: np.ndarray  # (n,) the diagonal of D
    factors: np.ndarray | SparseFactors
    pivots: np.ndarray
    symmetric: bool
    negative: int

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        """Solution A^-1 rhs; rhs (n,) or (n, columns)."""
        scaled = (self.scale * rhs.T).T
        if isinstance(self.factors, SparseFactors):
            found = self.factors.solve(scaled)
        elif self.symmetric:
            found = scipy.linalg.lapack.dsytrs(self.factors, self.pivots, scaled, lower=1)[0]
        else:
            found = scipy.linalg.lapack.dgetrs(self.factors, self.pivots, scaled)[0]
        return (self.scale * found.T).T.reshape(rhs.shape)


def balance(system: System, matrix: StaticArray) -> np.ndarray:
    """Diagonal of the scaling D, (n,)."""
    n_b, scale = system.n_b, np.ones(system.n)
    scale[:n_b] = 1 / system.weights[:n_b]
    scaled = scaled_by(matrix, scale)
    stiffness, ties = largest_entry(scaled[:n_b, :n_b]), largest_entry(scaled[:n_b, n_b:])
    if stiffness > 0 and ties > 0:
        scale[n_b:] = stiffness / ties
    return scale


def balanced(system: System, matrix: StaticArray, scale: np.ndarray) -> StaticArray:
    """Scaled matrix D A D.

    The columns of redundant constraints that were left out, whose forces are zero, are left out too.
    """
    found, dropped = scaled_by(matrix, scale), system.plan.dropped
    if isinstance(found, np.ndarray):
        for row in dropped:
            found[: system.n_b, row], found[row, row] = 0.0, -1.0
        return found
    if not len(dropped):
        return found
    kept = np.ones(system.n)
    kept[dropped] = 0.0
    return scipy.sparse.csr_array(found @ scipy.sparse.diags_array(kept) - scipy.sparse.diags_array(1.0 - kept))


def factorised(system: System, matrix: StaticArray, scale: np.ndarray | None = None, scaled: StaticArray | None = None) -> Saddle:
    """Factors of the matrix (n, n); `scale` is the diagonal of D, where it is known from one near by, `scaled` that matrix, `balanced`.

    Raises
    ------
    SingularSystemError
        Something is free to move, joints repeat each other, or numbers are not finite.
    """
    scale = balance(system, matrix) if scale is None else scale
    scaled = balanced(system, matrix, scale) if scaled is None else scaled
    largest = largest_entry(scaled)
    if not np.isfinite(largest):
        raise SingularSystemError("the static equations hold values that are not finite")
    symmetric = largest_entry(scaled - scaled.T) <= SYMMETRIC * largest
    if symmetric and (sparse := sparse_factors(system, scaled)) is not None:
        return Saddle(scale, sparse, np.zeros(0, int), symmetric, 0)
    scaled = as_dense(scaled)
    if symmetric:
        factors, pivots, info = scipy.linalg.lapack.dsytrf(scaled, lower=1)
        negative = _negative_pivots(factors, pivots) - (system.n - system.n_b)
    else:
        factors, pivots, info = scipy.linalg.lapack.dgetrf(scaled)
        negative = _negative_eigenvalues(system.n_b, scaled)
    if info:
        raise SingularSystemError("the static equations have no unique solution")
    return Saddle(scale, factors, pivots, symmetric, negative)


def is_positive(system: System, matrix: np.ndarray) -> bool:
    """Whether a symmetric matrix (n, n) is known to be positive against all motions that the joints allow, as in `sparse_saddle`.

    It takes less time than factors, and NumPy alone.
    """
    scaled, n_b = as_dense(balanced(system, matrix, balance(system, matrix))), system.n_b
    largest = largest_entry(scaled)
    if not largest_entry(scaled - scaled.T) <= SYMMETRIC * largest:
        return False
    J = scaled[n_b:, :n_b]
    try:
        np.linalg.cholesky(scaled[:n_b, :n_b] + HOLD / largest * (J.T @ J))
    except np.linalg.LinAlgError:
        return False
    return True


def free_count(system: System) -> int:
    """Number of independent motions that the joints allow."""
    return 2 * system.n_b + len(system.plan.dropped) - system.n


def _negative_pivots(factors: np.ndarray, pivots: np.ndarray) -> int:
    """Number of negative eigenvalues of T (Sylvester's law of inertia).

    Its blocks of two, which LAPACK marks by negative numbers, have one negative eigenvalue each.
    """
    single = pivots > 0
    return int(np.count_nonzero(factors.diagonal()[single] < 0) + np.count_nonzero(~single) // 2)


def _negative_eigenvalues(n_b: int, scaled: np.ndarray) -> int:
    """Number of real negative eigenvalues of Z^T K Z with an orthonormal basis Z of the motions that the joints allow.

    There are none where the symmetric part is positive definite. Complex ones (flutter) are no matter of statics.
    """
    ties = scaled[:n_b, n_b:]
    ties = ties[:, np.any(ties != 0, axis=0)]
    free = scipy.linalg.qr(ties)[0][:, ties.shape[1] :] if ties.size else np.eye(n_b)
    stiffness = free.T @ scaled[:n_b, :n_b] @ free
    if scipy.linalg.lapack.dpotrf((stiffness + stiffness.T) / 2)[1] == 0:
        return 0
    values = scipy.linalg.eigvals(stiffness)
    real = values.real[np.abs(values.imag) <= REAL * np.abs(values)]
    return int(np.count_nonzero(real < 0))
