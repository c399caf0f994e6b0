"""Factors of the stiffness of a body that is held, by the solver that is installed and suits its size."""

from __future__ import annotations

import weakref
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Any, Protocol

import numpy as np
import scipy
from scipy import sparse
from scipy.sparse.linalg import splu

LEAF = 120
"""Coordinates of parts that are not halved any more."""


def dissected(matrix: Any, places: np.ndarray) -> np.ndarray:
    """Numbers (n,) of the coordinates in the order of elimination.

    Parameters
    ----------
    matrix : sparse (n, n), of which the pattern counts
    places : (n, d), where the node of every coordinate is
    """
    pattern = sparse.csr_array(matrix)
    graph = sparse.csr_array((np.ones(pattern.nnz, np.int8), pattern.indices, pattern.indptr), shape=pattern.shape)
    return _ordered(graph, places, np.arange(len(places)))


def _ordered(graph: Any, places: np.ndarray, members: np.ndarray) -> np.ndarray:
    """The members in order; graph and places are theirs."""
    if len(members) <= LEAF:
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

    factors: Any
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


def superlu_factors(stiffness: Any, places: np.ndarray | None) -> SuperLUFactors:
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

    def __init__(self, stiffness: Any, solver: Any) -> None:
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


def pardiso_factors(stiffness: Any) -> PardisoFactors | None:
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


LARGE = 10_000
"""Coordinates from which Pardiso is asked: SuperLU factors a smaller body within half a second, with the same digits for everybody."""


class Factors(Protocol):
    """Factors of a matrix, with which it can be solved."""

    @property
    def writers(self) -> dict[str, str]:
        """Name of the solver and its version, for the reduced model."""

    def solve(self, above: np.ndarray) -> np.ndarray:
        """Displacements u (n, k) under loads (n, k)."""


def factored(stiffness: Any, places: np.ndarray | None) -> Factors:
    """Factors of a symmetric positive definite matrix.

    Parameters
    ----------
    stiffness : (n, n) sparse
    places : (n, d), where the node of every coordinate is
    """
    large = stiffness.shape[0] >= LARGE
    return (pardiso_factors(stiffness) if large else None) or superlu_factors(stiffness, places)
