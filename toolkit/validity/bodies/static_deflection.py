"""Elastic coordinates of a body under forces at rest, whatever its coordinates measure."""

from __future__ import annotations

import numpy as np


def static_deflection(stiffness: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """K^-1 f of forces f, (n_f,) or (n_f, k); K (n_f, n_f) is scaled to a unit diagonal, as coordinates differ by powers of ten."""
    scale = 1 / np.sqrt(np.diag(stiffness))
    found: np.ndarray = (np.linalg.solve(scale[:, None] * stiffness * scale, (forces.T * scale).T).T * scale).T
    return found
