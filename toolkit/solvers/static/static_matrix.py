"""The static matrix [K, G; J, 0] of a state: as an array, its factors in coordinates of comparable size, and what they say.

Sparse factors of a large symmetric static matrix [K, J^T; J, 0], where it is stable.

K is positive against all motions that the joints allow if K + r J^T J is positive definite for some r, which its pivots without exchanges
tell: they are all positive. If they are not, nothing is known, and dense factors have to tell.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import scipy

from toolkit.foundation.errors import SingularSystemError
from toolkit.solvers.direct_solve import SPARSE_FROM_UNKNOWNS
from toolkit.solvers.static.equilibrium import static_matrix
from toolkit.system.equations import Terms
from toolkit.system.system import System

StaticArray: TypeAlias = "np.ndarray | scipy.sparse.csr_array"
"""Static matrix as a dense or sparse array of shape (n, n)."""


def static_array(system: System, terms: Terms) -> StaticArray:
    """Real part of the static matrix where terms are known, (n, n)."""
    return whole_array(system, np.real(static_matrix(system, terms)))


def whole_array(system: System, values: np.ndarray) -> StaticArray:
    """Array (n, n) of values on the common pattern."""
    return system.matrix(values) if system.n >= SPARSE_FROM_UNKNOWNS else system.dense(values)


def as_dense(matrix: StaticArray) -> np.ndarray:
    """Dense array of a matrix, with all its zeros."""
    return matrix if isinstance(matrix, np.ndarray) else matrix.toarray()


def scaled_by(matrix: StaticArray, scale: np.ndarray) -> StaticArray:
    """Scaled matrix D A D with D = diag(scale)."""
    if isinstance(matrix, np.ndarray):
        found: np.ndarray = matrix * scale
        found *= scale[:, None]
        return found
    return scipy.sparse.csr_array(scipy.sparse.diags_array(scale) @ matrix @ scipy.sparse.diags_array(scale))


def largest_entry(matrix: StaticArray) -> float:
    """Largest size of an entry; what is not finite is handed on."""
    entries = matrix if isinstance(matrix, np.ndarray) else matrix.data
    return float(np.abs(entries).max(initial=0))


JOINT_STIFFNESS = 10.0
"""Stiffness r of the joints in parts of the largest of the bodies."""
TRUSTED_REFINEMENT = 1e-4
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
    if not _positive(scipy.sparse.csc_array(stiffness + JOINT_STIFFNESS / largest * (ties.T @ ties))):
        return None
    matrix = scipy.sparse.csc_array(scaled)
    try:
        factors = scipy.sparse.linalg.splu(matrix)
    except RuntimeError:  # exactly singular
        return None
    probe = np.ones(system.n)
    found = factors.solve(probe)
    change = factors.solve(probe - matrix @ found)
    return SparseFactors(matrix, factors) if abs(change).max() <= TRUSTED_REFINEMENT * abs(found).max() else None


def _positive(matrix: scipy.sparse.csc_array) -> bool:
    """Whether a symmetric matrix is positive definite."""
    try:
        factors = scipy.sparse.linalg.splu(
            matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
    except RuntimeError:
        return False
    return bool(np.array_equal(factors.perm_r, factors.perm_c) and np.all(factors.U.diagonal() > 0))


ASYMMETRY_ROUND_OFF = 1e-12
"""Asymmetry, a part of the largest entry, that is round-off."""
REAL_EIGENVALUE = 1e-9
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
    symmetric = largest_entry(scaled - scaled.T) <= ASYMMETRY_ROUND_OFF * largest
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
    """Whether a symmetric matrix (n, n) is known to be positive against all motions that the joints allow.

    It takes less time than factors, and NumPy alone.
    """
    scaled, n_b = as_dense(balanced(system, matrix, balance(system, matrix))), system.n_b
    largest = largest_entry(scaled)
    if not largest_entry(scaled - scaled.T) <= ASYMMETRY_ROUND_OFF * largest:
        return False
    J = scaled[n_b:, :n_b]
    try:
        np.linalg.cholesky(scaled[:n_b, :n_b] + JOINT_STIFFNESS / largest * (J.T @ J))
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
    real = values.real[np.abs(values.imag) <= REAL_EIGENVALUE * np.abs(values)]
    return int(np.count_nonzero(real < 0))


WATCHED_MOTIONS = 2
"""Motions that are watched: the softest one may be overtaken by another."""
ITERATIONS, WARM_ITERATIONS = 6, 2
"""Iterations of the inverse iteration, from anywhere and from the motions of a point near by."""


class Softness(NamedTuple):
    """Stiffnesses k (m,) and their motions with the forces of the joints, [phi; mu] (n, m).

        K phi + phi_q^T mu = k W phi,   phi_q phi = 0,   W = diag(w^2),   phi^T W phi = 1

    with the weights w of the system.
    """

    values: np.ndarray
    motions: np.ndarray

    def change(self, difference: np.ndarray) -> np.ndarray:
        """Changes of the stiffnesses (m,) with a difference of the static matrix (n, n)."""
        found: np.ndarray = (self.motions * (difference @ self.motions)).sum(axis=0)
        return found


def softest(saddle: Saddle, n_free: int, n_b: int, known: Softness | None = None) -> Softness:
    """Softest stiffnesses, by inverse iteration of a block with Rayleigh's quotients; none if the matrix is not symmetric.

    The iteration begins with those of a point near by if it has as many.
    """
    n, count = len(saddle.scale), min(WATCHED_MOTIONS, n_free) if saddle.symmetric else 0
    nothing = Softness(np.zeros(0), np.zeros((n, 0)))
    if not count:
        return nothing
    scale, forces = saddle.scale[:n_b, None], np.zeros((n - n_b, count))
    near = None if known is None or len(known.values) != count else known.motions[:n_b] / scale
    block = np.random.default_rng(0).normal(size=(n_b, count)) if near is None else near
    for _ in range(ITERATIONS if near is None else WARM_ITERATIONS):
        block = _orthonormal(block)
        solved = saddle.solve(np.vstack([block / scale, forces]))
        flexibility, turn = np.linalg.eigh(block.T @ (solved[:n_b] / scale))
        if not np.all(flexibility):
            return nothing  # round-off has swallowed a motion of a scene whose sizes differ by too much
        solved = solved @ turn / flexibility
        block = solved[:n_b] / scale
    return Softness(1 / flexibility, solved / np.sqrt((block**2).sum(axis=0)))


def _orthonormal(block: np.ndarray) -> np.ndarray:
    """Columns (n, m) made orthonormal, by LAPACK itself: to prepare its call takes longer than these few columns."""
    factors, scales, _, _ = scipy.linalg.lapack.dgeqrf(block)
    found: np.ndarray = scipy.linalg.lapack.dorgqr(factors, scales)[0]
    return found
