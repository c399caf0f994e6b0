"""Factors of the stiffness of a body that is held, by the solver that is installed and suits its size."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from preprocessing.basis.solids.pardiso_factors import pardiso_factors
from preprocessing.basis.solids.superlu_factors import superlu_factors

LARGE = 10_000
"""Coordinates from which Pardiso is asked: SuperLU factors a smaller body within half a second, with the same digits for everybody."""


class Factors(Protocol):
    """What solves with a matrix that was factored."""

    @property
    def writers(self) -> dict[str, str]:
        """The solver and its version, for the reduced model."""

    def solve(self, above: np.ndarray) -> np.ndarray:
        """u (n, k) under loads (n, k)."""


def factored(stiffness: Any, places: np.ndarray | None) -> Factors:
    """Factors of a symmetric positive definite matrix.

    Parameters
    ----------
    stiffness : (n, n) sparse
    places : (n, d), where the node of every coordinate is
    """
    large = stiffness.shape[0] >= LARGE
    return (pardiso_factors(stiffness) if large else None) or superlu_factors(stiffness, places)
