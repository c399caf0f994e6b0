"""The stiffness of a body that is held, factored once: static shapes, modes and derivatives all use the same factors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from preprocessing.basis.solids.basis_change import BasisChange
from preprocessing.basis.solids.factors import Factors, factored
from toolkit.foundation.errors import InputError

DEPENDENT = 1e-9
"""Smallest eigenvalue of the compliance between averaged rows, scaled to a unit diagonal, that is more than round-off."""


@dataclass(frozen=True, eq=False)
class HeldSystem:
    """Factors of [K B^T; B 0] with K (n, n) sparse and positive definite, and B (m, n) sparse, by K and its Schur complement."""

    stiffness: Any
    rows: Any
    factors: Factors  # of K
    carried: np.ndarray  # W = K^-1 B^T, (n, m)
    complement: Any  # Cholesky factor of B K^-1 B^T; None without rows

    @property
    def writers(self) -> dict[str, str]:
        """Name of the solver and its version."""
        return self.factors.writers

    def solve(self, above: np.ndarray, below: np.ndarray | float = 0.0) -> np.ndarray:
        """Displacements u (n, k) of K u + B^T p = above (n, k), B u = below (m, k)."""
        u = self.factors.solve(above)
        return self._on_rows(u + self.factors.solve(above - self.stiffness @ u), below)

    def nearly(self, above: np.ndarray) -> np.ndarray:
        """Displacements for B u = 0 without iterative refinement: of what is not kept, at half the price."""
        return self._on_rows(self.factors.solve(above), 0.0)

    def _on_rows(self, u: np.ndarray, below: np.ndarray | float) -> np.ndarray:
        """Displacements (n, k) moved by forces on the rows until B u is what it should be."""
        if self.complement is None:
            return u
        for _ in range(2):  # the second time takes out the round-off that the first one leaves on the rows
            u = u - self.carried @ cho_solve(self.complement, self.rows @ u - below)
        return u

    def reactions(self, forces: np.ndarray) -> np.ndarray:
        """Reactions p (m, k) of B^T p = forces (n, k), which are such."""
        return np.linalg.solve((self.rows @ self.rows.T).toarray(), self.rows @ forces)

    def following(self, shapes: np.ndarray, change: BasisChange) -> np.ndarray:
        """Displacements u (n, k) with B u = -dB shapes, so that shapes (n, k) with B shapes = 0 go on meeting that."""
        if self.complement is None or change.rows is None:
            return np.zeros_like(shapes)
        return self.solve(np.zeros_like(shapes), -(change.rows @ shapes))

    def loads_of(self, forces: np.ndarray, change: BasisChange) -> np.ndarray:
        """Forces dB^T p (n, k) for the reactions p that carry forces = B^T p."""
        if self.complement is None or change.rows is None:
            return np.zeros_like(forces)
        return change.rows.T @ self.reactions(forces)


def held_system(stiffness: Any, rows: Any, places: np.ndarray | None = None) -> HeldSystem:
    """Factor K and the compliance between the rows.

    Parameters
    ----------
    stiffness : (n, n) sparse, positive definite
    rows : (m, n) sparse; m may be zero
    places : (n, d), where the node of every coordinate is

    Raises
    ------
    InputError
        The rows depend on each other.
    """
    bare = HeldSystem(stiffness, rows, factored(stiffness, places), np.zeros((stiffness.shape[0], 0)), None)
    if not rows.shape[0]:
        return bare
    carried = bare.solve(rows.T.toarray())
    compliance = rows @ carried
    compliance = (compliance + compliance.T) / 2
    own = np.diag(compliance)
    scale = 1 / np.sqrt(np.where(own > 0, own, 1.0))
    if not own.min() > 0 or not np.linalg.eigvalsh(scale[:, None] * compliance * scale)[0] > DEPENDENT:
        raise InputError(
            "the averaged interface points cannot move independently of each other and of what is held. Give every place one name, and "
            "more nodes to points that are close together, to a clamp or to a rigid tie."
        )
    return HeldSystem(stiffness, rows, bare.factors, carried, cho_factor(compliance))
