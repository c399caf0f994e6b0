"""Factors of a symmetric positive definite sparse matrix by SuperLU, which is a part of SciPy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from scipy import sparse
from scipy.sparse.linalg import splu

from preprocessing.basis.solids.nested_dissection import dissected


@dataclass(frozen=True, eq=False)
class SuperLUFactors:
    """Factors of a matrix whose coordinates are taken in another order; None where SuperLU has chosen the order itself."""

    factors: Any
    order: np.ndarray | None

    @property
    def writers(self) -> dict[str, str]:
        """The solver and its version."""
        return {"SuperLU": f"scipy {scipy.__version__}"}

    def solve(self, above: np.ndarray) -> np.ndarray:
        """u (n, k) under loads (n, k)."""
        if self.order is None:
            return self.factors.solve(above)
        found = np.empty_like(above)
        found[self.order] = self.factors.solve(above[self.order])
        return found


def superlu_factors(stiffness: Any, places: np.ndarray | None) -> SuperLUFactors:
    """Factors; in space, where the nodes are given, in an order that leaves fewer entries."""
    symmetric = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    if places is None or places.shape[1] < 3:
        return SuperLUFactors(splu(sparse.csc_array(stiffness), permc_spec="MMD_AT_PLUS_A", **symmetric), None)
    order = dissected(stiffness, places)
    return SuperLUFactors(splu(sparse.csc_array(stiffness[order][:, order]), permc_spec="NATURAL", **symmetric), order)
