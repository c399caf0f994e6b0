"""The stiffness of a body that nothing holds, factored once under loads that its own inertia keeps in balance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from preprocessing.basis.solids.basis_change import BasisChange
from preprocessing.basis.solids.held_system import HeldSystem, held_system


@dataclass(frozen=True, eq=False)
class FreeSystem:
    """Static solver P K^+ P^T of a free body: displacements without rigid motion under f - M T T^T f.

    P = I - T T^T M, for rigid motions T with T^T M T = I.
    """

    stiffness: Any  # (n, n) sparse
    mass: Any  # M (n, n) sparse
    rows: Any  # (0, n)
    held: HeldSystem  # of the coordinates `kept`
    kept: np.ndarray
    rigid: np.ndarray  # T (n, m), m = 3 in the plane and 6 in space
    inertia: np.ndarray  # M T (n, m)
    triangle: np.ndarray  # L of T = R L^-T, for the unit rigid motions R

    @property
    def writers(self) -> dict[str, str]:
        """Name of the solver and its version."""
        return self.held.writers

    def solve(self, above: np.ndarray, _: np.ndarray | float = 0.0) -> np.ndarray:
        """Displacements (n, k) under loads (n, k)."""
        return self._balanced(self.held.solve, above)

    def nearly(self, above: np.ndarray) -> np.ndarray:
        """Displacements (n, k) under loads (n, k), without iterative refinement."""
        return self._balanced(self.held.nearly, above)

    def _balanced(self, solve: Callable[[np.ndarray], np.ndarray], above: np.ndarray) -> np.ndarray:
        balanced = above - self.inertia @ (self.rigid.T @ above)
        u = np.zeros_like(balanced)
        u[self.kept] = solve(balanced[self.kept])
        return u - self.rigid @ (self.inertia.T @ u)

    def following(self, shapes: np.ndarray, change: BasisChange) -> np.ndarray:
        """Rigid motions u (n, k) with T^T M u = -d(T^T M) shapes, so that shapes (n, k) stay without rigid motion."""
        if change.mass is None or change.motions is None:
            return np.zeros_like(shapes)
        moved = np.linalg.solve(self.triangle, change.motions.T @ (self.mass @ shapes))
        return -self.rigid @ (moved + self.rigid.T @ (change.mass @ shapes))

    def loads_of(self, forces: np.ndarray, _: BasisChange) -> np.ndarray:
        """Zeros (n, k): no forces hold a free body."""
        return np.zeros_like(forces)


def free_system(stiffness: Any, mass: Any, motions: np.ndarray, places: np.ndarray | None = None) -> FreeSystem:
    """Factor the stiffness with a support that carries no force under balanced loads.

    Parameters
    ----------
    stiffness, mass : sparse (n, n)
    motions : (n, m) the body's rigid motions
    places : (n, d), where the node of every coordinate is
    """
    triangle = np.linalg.cholesky(motions.T @ (mass @ motions))
    rigid = np.linalg.solve(triangle, motions.T).T
    kept = np.setdiff1d(np.arange(len(motions)), _support(motions / np.linalg.norm(motions, axis=0)))
    where = None if places is None else places[kept]
    held = held_system(stiffness[kept][:, kept].tocsr(), sparse.csr_array((0, len(kept))), where)
    return FreeSystem(stiffness, mass, sparse.csr_array((0, len(motions))), held, kept, rigid, mass @ rigid, triangle)


def _support(motions: np.ndarray) -> list[int]:
    """Numbers of as many coordinates as rigid motions, so that none leaves all of them at rest.

    Each is the coordinate that moves most in what the ones before have left.
    """
    left, chosen = motions.copy(), []
    for _ in range(motions.shape[1]):
        place = int(np.argmax((left**2).sum(axis=1)))
        chosen.append(place)
        along = left[place] / np.linalg.norm(left[place])
        left = left - np.outer(left @ along, along)
    return chosen
