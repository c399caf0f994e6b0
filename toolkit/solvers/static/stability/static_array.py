"""The static matrix [K, G; J, 0] of a state as an array: of many unknowns a sparse one, and what is done to both kinds alike."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import scipy

from toolkit.equations.equations import Terms
from toolkit.solvers.direct_solve import MANY
from toolkit.solvers.static.equilibrium import static_matrix
from toolkit.system.system import System

StaticArray: TypeAlias = "np.ndarray | scipy.sparse.csr_array"
"""Static matrix as a dense or sparse array of shape (n, n)."""


def static_array(system: System, terms: Terms) -> StaticArray:
    """Real part of the static matrix where terms are known, (n, n)."""
    return whole_array(system, np.real(static_matrix(system, terms)))


def whole_array(system: System, values: np.ndarray) -> StaticArray:
    """Array (n, n) of values on the common pattern."""
    return system.matrix(values) if system.n >= MANY else system.dense(values)


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
