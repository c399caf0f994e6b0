"""Factors of a symmetric positive definite sparse matrix by the Pardiso of Intel's MKL, where it is installed.

pypardiso finds and calls it. Factors of 100 000 unknowns take a quarter of SuperLU's time: see `factors` for when it is asked.
"""

from __future__ import annotations

import weakref
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
from scipy import sparse

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
        """The solver and its version."""
        return {"MKL Pardiso": f"pypardiso {version('pypardiso')}{_mkl()}"}

    def solve(self, above: np.ndarray) -> np.ndarray:
        """u (n, k) under loads (n, k)."""
        if not above.shape[1]:
            return np.zeros_like(above)
        found: np.ndarray = self._solver.solve(self._upper, np.asfortranarray(above))
        return found


def pardiso_factors(stiffness: Any) -> PardisoFactors | None:
    """Factors; None where Pardiso is not installed, or refuses the matrix."""
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
