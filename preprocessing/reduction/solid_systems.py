"""The stiffness of a solid that is held or free, factored once for static shapes, modes and their derivatives."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Protocol

import numpy as np
import scipy
from scipy import sparse
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse.linalg import SuperLU, splu

from toolkit.foundation.errors import InputError

if TYPE_CHECKING:
    from pypardiso import PyPardisoSolver


@dataclass(frozen=True, eq=False)
class BasisChange:
    """Derivatives by one variable of what a solid's basis is made of; None is what does not depend on it."""

    stiffness: sparse.csr_array  # dK (n, n)
    mass: sparse.csr_array | None = None  # dM (n, n)
    rows: sparse.csr_array | np.ndarray | None = None  # dB of the averaged interface points (m, n)
    motions: np.ndarray | None = None  # rate of the rigid motions, (n, m)
    turn: np.ndarray | None = None  # rate of what a chord leaves of the points' motions, see `chord_turn`

    def inside(self, n: int) -> BasisChange:
        """Derivatives on the first n coordinates."""
        if n == self.stiffness.shape[0]:
            return self
        return BasisChange(
            self.stiffness[:n, :n],
            None if self.mass is None else self.mass[:n, :n],
            None if self.rows is None else self.rows[:, :n],
            None if self.motions is None else self.motions[:n],
        )


LEAF_COORDINATES = 120
"""Coordinates of parts that are not halved any more."""


def dissected(matrix: sparse.csr_array, places: np.ndarray) -> np.ndarray:
    """Numbers (n,) of the coordinates in the order of elimination.

    Parameters
    ----------
    matrix : (n, n), of which the pattern counts
    places : (n, d), where the node of every coordinate is
    """
    pattern = sparse.csr_array(matrix)
    graph = sparse.csr_array((np.ones(pattern.nnz, np.int8), pattern.indices, pattern.indptr), shape=pattern.shape)
    return _ordered(graph, places, np.arange(len(places)))


def _ordered(graph: sparse.csr_array, places: np.ndarray, members: np.ndarray) -> np.ndarray:
    """The members in order; graph and places are theirs."""
    if len(members) <= LEAF_COORDINATES:
        return members
    axis = np.argmax(np.ptp(places, axis=0))
    left = places[:, axis] < np.median(places[:, axis])
    if not left.any():
        return members
    on_left, on_right = (side & (graph @ ~side > 0) for side in (left, ~left))
    border = on_left if on_left.sum() <= on_right.sum() else on_right
    inner = [np.flatnonzero(side & ~border) for side in (left, ~left)]
    return np.concatenate([*(_ordered(graph[each][:, each], places[each], members[each]) for each in inner), members[border]])


@dataclass(frozen=True, eq=False)
class SuperLUFactors:
    """Factors of a matrix whose coordinates are taken in another order; None where SuperLU has chosen the order itself."""

    factors: SuperLU
    order: np.ndarray | None

    @property
    def writers(self) -> dict[str, str]:
        """Name of the solver and its version."""
        return {"SuperLU": f"scipy {scipy.__version__}"}

    def solve(self, above: np.ndarray) -> np.ndarray:
        """Displacements u (n, k) under loads (n, k)."""
        if self.order is None:
            return self.factors.solve(above)
        found = np.empty_like(above)
        found[self.order] = self.factors.solve(above[self.order])
        return found


def superlu_factors(stiffness: sparse.csr_array, places: np.ndarray | None) -> SuperLUFactors:
    """Factors by SuperLU; in space, where the nodes are given, in an order that leaves fewer entries."""
    symmetric = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    if places is None or places.shape[1] < 3:
        return SuperLUFactors(splu(sparse.csc_array(stiffness), permc_spec="MMD_AT_PLUS_A", **symmetric), None)
    order = dissected(stiffness, places)
    return SuperLUFactors(splu(sparse.csc_array(stiffness[order][:, order]), permc_spec="NATURAL", **symmetric), order)


POSITIVE_DEFINITE = 2
"""Pardiso's number for real symmetric positive definite matrices, of which it takes the upper triangle."""
OWN_PARAMETERS, ORDER, METIS, REFINEMENTS = 1, 2, 2, 8
"""Parameters, counted from 1, by the words of its manual: METIS on one core orders the same whatever the machine."""


class PardisoFactors:
    """Factors that are MKL's own memory, which is given back with this object."""

    def __init__(self, stiffness: sparse.csr_array, solver: PyPardisoSolver) -> None:
        self._upper = sparse.csr_matrix(sparse.triu(stiffness, format="csr"))
        self._solver = solver
        solver.set_iparm(OWN_PARAMETERS, 1)
        solver.set_iparm(ORDER, METIS)
        solver.set_iparm(REFINEMENTS, 0)  # whoever needs it refines by the matrix itself
        solver.factorize(self._upper)
        weakref.finalize(self, solver.free_memory, True)

    @property
    def writers(self) -> dict[str, str]:
        """Name of the solver and its version."""
        return {"MKL Pardiso": f"pypardiso {version('pypardiso')}{_mkl()}"}

    def solve(self, above: np.ndarray) -> np.ndarray:
        """Displacements u (n, k) under loads (n, k)."""
        if not above.shape[1]:
            return np.zeros_like(above)
        found: np.ndarray = self._solver.solve(self._upper, np.asfortranarray(above))
        return found


def pardiso_factors(stiffness: sparse.csr_array) -> PardisoFactors | None:
    """Factors by Pardiso; None where it is not installed, or refuses the matrix."""
    try:
        from pypardiso import PyPardisoSolver
        from pypardiso.pardiso_wrapper import PyPardisoError
    except ImportError:  # of pypardiso, or of MKL by it
        return None
    try:
        return PardisoFactors(stiffness, PyPardisoSolver(mtype=POSITIVE_DEFINITE))
    except (
        PyPardisoError
    ):  # a pivot that round-off made negative: SuperLU goes on, and what follows says what is wrong with the body
        return None


def _mkl() -> str:
    try:
        return f", mkl {version('mkl')}"
    except PackageNotFoundError:  # MKL of another kind than Python's package
        return ""


PARDISO_FROM = 10_000
"""Coordinates from which Pardiso is asked: SuperLU factors a smaller body within half a second, with the same digits for everybody."""


class Factors(Protocol):
    """Factors of a matrix, with which it can be solved."""

    @property
    def writers(self) -> dict[str, str]:
        """Name of the solver and its version, for the reduced model."""

    def solve(self, above: np.ndarray) -> np.ndarray:
        """Displacements u (n, k) under loads (n, k)."""


def factored(stiffness: sparse.csr_array, places: np.ndarray | None) -> Factors:
    """Factors of a symmetric positive definite matrix.

    Parameters
    ----------
    stiffness : (n, n)
    places : (n, d), where the node of every coordinate is
    """
    large = stiffness.shape[0] >= PARDISO_FROM
    return (pardiso_factors(stiffness) if large else None) or superlu_factors(stiffness, places)


DEPENDENT_ROWS = 1e-9
"""Smallest eigenvalue of the compliance between averaged rows, scaled to a unit diagonal, that is more than round-off."""


@dataclass(frozen=True, eq=False)
class HeldSystem:
    """Factors of [K B^T; B 0] with K (n, n) positive definite and B (m, n), by K and its Schur complement."""

    stiffness: sparse.csr_array
    rows: sparse.csr_array
    factors: Factors  # of K
    carried: np.ndarray  # W = K^-1 B^T, (n, m)
    complement: tuple[np.ndarray, bool] | None  # Cholesky factor of B K^-1 B^T; None without rows

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


def held_system(stiffness: sparse.csr_array, rows: sparse.csr_array, places: np.ndarray | None = None) -> HeldSystem:
    """Factor K and the compliance between the rows.

    Parameters
    ----------
    stiffness : (n, n), positive definite
    rows : (m, n); m may be zero
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
    if not own.min() > 0 or not np.linalg.eigvalsh(scale[:, None] * compliance * scale)[0] > DEPENDENT_ROWS:
        raise InputError(
            "the averaged interface points cannot move independently of each other and of what is held. Give every place one name, and "
            "more nodes to points that are close together, to a clamp or to a rigid tie."
        )
    return HeldSystem(stiffness, rows, bare.factors, carried, cho_factor(compliance))


@dataclass(frozen=True, eq=False)
class FreeSystem:
    """Static solver P K^+ P^T of a free body: displacements without rigid motion under f - M T T^T f.

    P = I - T T^T M, for rigid motions T with T^T M T = I.
    """

    stiffness: sparse.csr_array  # (n, n)
    mass: sparse.csr_array  # M (n, n)
    rows: sparse.csr_array  # (0, n)
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


def free_system(
    stiffness: sparse.csr_array, mass: sparse.csr_array, motions: np.ndarray, places: np.ndarray | None = None
) -> FreeSystem:
    """Factor the stiffness with a support that carries no force under balanced loads.

    Parameters
    ----------
    stiffness, mass : (n, n)
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
