"""The stiffness of a body that is held, factored once: static shapes, modes and derivatives all use the same factors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse.linalg import splu

from toolkit.errors import InputError

DEPENDENT = 1e-9
"""Smallest eigenvalue of the compliance between averaged rows, scaled to a unit diagonal, that is more than round-off."""


@dataclass(frozen=True, eq=False)
class HeldSystem:
    """Factors of [K B^T; B 0] with K (n, n) sparse and positive definite, and B (m, n) sparse, by K and its Schur complement."""

    stiffness: Any
    rows: Any
    factors: Any  # of K
    carried: np.ndarray  # W = K^-1 B^T, (n, m)
    complement: Any  # Cholesky factor of B K^-1 B^T; None without rows

    def solve(self, above: np.ndarray, below: np.ndarray | float = 0.0) -> np.ndarray:
        """u (n, k) of K u + B^T p = above (n, k), B u = below (m, k)."""
        u = self._free(above)
        if self.complement is None:
            return u
        for _ in range(2):  # the second time takes out the round-off that the first one leaves on the rows
            u = u - self.carried @ cho_solve(self.complement, self.rows @ u - below)
        return u

    def _free(self, above: np.ndarray) -> np.ndarray:
        """K^-1 with one step of iterative refinement."""
        u = self.factors.solve(above)
        return u + self.factors.solve(above - self.stiffness @ u)


def held_system(stiffness: Any, rows: Any) -> HeldSystem:
    """Factor K and the compliance between the rows.

    Parameters
    ----------
    stiffness : (n, n) sparse, positive definite
    rows : (m, n) sparse; m may be zero

    Raises
    ------
    InputError
        The rows depend on each other.
    """
    symmetric = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    factors = splu(sparse.csc_array(stiffness), **symmetric)
    bare = HeldSystem(stiffness, rows, factors, np.zeros((stiffness.shape[0], 0)), None)
    if not rows.shape[0]:
        return bare
    carried = bare.solve(rows.T.toarray())
    compliance = rows @ carried
    compliance = (compliance + compliance.T) / 2
    scale = 1 / np.sqrt(np.diag(compliance))
    if not np.linalg.eigvalsh(scale[:, None] * compliance * scale)[0] > DEPENDENT:
        raise InputError(
            "the averaged interface points cannot move independently of each other. Give every place one name, and more nodes to points "
            "that are close together."
        )
    return HeldSystem(stiffness, rows, factors, carried, cho_factor(compliance))
