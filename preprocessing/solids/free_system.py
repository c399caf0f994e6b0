"""The stiffness of a body that nothing holds, factored once under loads that its own inertia keeps in balance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from preprocessing.solids.held_system import HeldSystem, held_system


@dataclass(frozen=True, eq=False)
class FreeSystem:
    """P K^+ P^T with P = I - T T^T M: displacements without rigid motion under f - M T T^T f, for rigid motions T with T^T M T = I."""

    stiffness: Any  # (n, n) sparse
    rows: Any  # (0, n)
    held: HeldSystem  # of the coordinates `kept`
    kept: np.ndarray
    rigid: np.ndarray  # T (n, 3)
    inertia: np.ndarray  # M T (n, 3)

    def solve(self, above: np.ndarray, _: np.ndarray | float = 0.0) -> np.ndarray:
        """Displacements (n, k) under loads (n, k)."""
        balanced = above - self.inertia @ (self.rigid.T @ above)
        u = np.zeros_like(balanced)
        u[self.kept] = self.held.solve(balanced[self.kept])
        return u - self.rigid @ (self.inertia.T @ u)


def free_system(stiffness: Any, mass: Any, motions: np.ndarray) -> FreeSystem:
    """Factor the stiffness with a support that carries no force under balanced loads.

    Parameters
    ----------
    stiffness, mass : sparse (n, n)
    motions : (n, 3) the body's rigid motions
    """
    triangle = np.linalg.cholesky(motions.T @ (mass @ motions))
    rigid = np.linalg.solve(triangle, motions.T).T
    kept = np.setdiff1d(np.arange(len(motions)), _support(motions / np.linalg.norm(motions, axis=0)))
    held = held_system(stiffness[kept][:, kept].tocsr(), sparse.csr_array((0, len(kept))))
    return FreeSystem(stiffness, sparse.csr_array((0, len(motions))), held, kept, rigid, mass @ rigid)


def _support(motions: np.ndarray) -> list[int]:
    """Three coordinates that no rigid motion leaves at rest: each time the one that moves most in what is left."""
    left, chosen = motions.copy(), []
    for _ in range(motions.shape[1]):
        place = int(np.argmax((left**2).sum(axis=1)))
        chosen.append(place)
        along = left[place] / np.linalg.norm(left[place])
        left = left - np.outer(left @ along, along)
    return chosen
