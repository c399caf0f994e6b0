"""Rigid motions: what a stiffness matrix and its constraints let move without strain."""

from __future__ import annotations

import numpy as np
from scipy.linalg import null_space

from preprocessing.basis.bordered_system import bordered_system
from preprocessing.basis.constrained_pencil import ConstrainedPencil
from toolkit.foundation.errors import InputError

RIGID = 1e-13
"""Largest eigenvalue of a rigid motion, of the stiffness matrix scaled to a unit diagonal: round-off leaves some 1e-16. The first elastic
mode has about (h / L)^2 (t / L)^2 / 12 for elements of length h on a thin skin of length L and thickness t: 1e-7 for 30 elements."""


def rigid_modes(pencil: ConstrainedPencil) -> np.ndarray:
    """Rigid motions T (n, n_rigid), K T = 0, R T = 0, orthonormal in the mass matrix; none of a held body.

    Raises
    ------
    InputError
        The stiffness matrix is that of no body.
    """
    diagonal = np.diag(pencil.stiffness)
    if np.any(diagonal < 0):
        raise InputError(
            f"the stiffness matrix has {np.count_nonzero(diagonal < 0)} negative entries on its diagonal, so that a motion would set "
            "energy free: no body does that. Export it again, or fix its sign."
        )
    scale = 1 / np.sqrt(np.diag(pencil.stiffness).clip(np.finfo(float).tiny))
    held = np.linalg.norm(pencil.rows * scale, axis=1, keepdims=True)
    allowed = null_space(pencil.rows * scale / held) if len(pencil.rows) else np.eye(len(scale))
    try:
        energy, motions = np.linalg.eigh(allowed.T @ (scale[:, None] * pencil.stiffness * scale) @ allowed)
    except np.linalg.LinAlgError as error:
        raise InputError(
            f"the stiffness matrix has no modes ({error}): its entries differ by too many powers of ten. Export it again."
        ) from error
    rigid = scale[:, None] * (allowed @ motions[:, energy < RIGID])
    return _orthonormal(_refined(pencil, rigid), pencil.mass) if rigid.size else rigid


def _refined(pencil: ConstrainedPencil, rigid: np.ndarray) -> np.ndarray:
    """Rigid motions without the strain of the eigenvalue solver's round-off: K u = 0, and M-products as before."""
    border = rigid.T @ pencil.mass
    below = np.vstack([np.zeros((len(pencil.rows), rigid.shape[1])), border @ rigid])
    return bordered_system(pencil.stiffness, np.vstack([pencil.rows, border])).solve(np.zeros_like(rigid), below)[0]


def _orthonormal(shapes: np.ndarray, mass: np.ndarray) -> np.ndarray:
    return np.linalg.solve(np.linalg.cholesky(shapes.T @ mass @ shapes), shapes.T).T
