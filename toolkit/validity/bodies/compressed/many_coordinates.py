"""The largest ratio of two forms among the motions that joints allow, where there are many coordinates: by Lanczos' iteration.

    A x = mu B x + phi_q^T nu,    phi_q x = 0

with B positive against these motions. Dense eigenvalues of n coordinates cost n^3, these the few products with sparse factors of B.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy

from toolkit.solvers.static.static_matrix import StaticArray, balance, balanced, sparse_factors
from toolkit.system.system import System

ACCURACY = 1e-8
"""Relative accuracy of a ratio: far below the digits of a verdict."""
MOST = 50
"""Largest number of restarts of the iteration with twenty motions: a ratio that is apart from others is found in a few."""
Flexibility = Callable[[np.ndarray], np.ndarray]
"""Function from forces f (n,) to the motion x with B x + phi_q^T nu = f, phi_q x = 0."""


def flexibility(system: System, matrix: StaticArray) -> Flexibility | None:
    """Flexibility of a symmetric static matrix.

    None where the matrix is dense, not known to be stable, or of more than bodies and joints.
    """
    n_q, scale = system.n_q, balance(system, matrix)
    factors = sparse_factors(system, balanced(system, matrix, scale)) if n_q == system.n_b else None
    if factors is None:
        return None

    def motion(forces: np.ndarray) -> np.ndarray:
        found: np.ndarray = scale[:n_q] * factors.solve(np.append(scale[:n_q] * forces.ravel(), np.zeros(system.n - n_q)))[:n_q]
        return found

    return motion


def largest_ratio(matrix: scipy.sparse.sparray, metric: scipy.sparse.sparray, flexible: Flexibility) -> float | None:
    """Largest ratio mu of symmetric forms A and B (n, n); None if the iteration finds none, as where none is positive.

    Most mu are near to zero, and the relative accuracy of such a number is never reached.
    """
    n = metric.shape[0]
    start = flexible(np.random.default_rng(0).normal(size=n))
    solved = scipy.sparse.linalg.LinearOperator((n, n), matvec=flexible, dtype=float)
    try:
        found = scipy.sparse.linalg.eigsh(
            matrix, 1, metric, which="LA", v0=start, tol=ACCURACY, maxiter=MOST, Minv=solved, return_eigenvectors=False
        )
    except scipy.sparse.linalg.ArpackError:
        return None
    return float(found[0])
