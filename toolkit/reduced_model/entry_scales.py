"""How large the entries of a body's invariants could be at most: what their round-off, and their symmetry, are judged by.

Mass, stiffness and damping are sums of squares, so that by the inequality of Cauchy and Schwarz

    |G_ij|, |H_ij|, |Q_ab,ij| <= sqrt(G_ii G_jj)       |N_ai| <= sqrt(m G_ii)       |K_ij| <= sqrt(K_ii K_jj)       |D_ij| <=
    sqrt(D_ii D_jj)

with G the sum of the Q_aa in space. A matrix that vanishes, such as H of a straight beam's bending modes, holds nothing but
round-off: compared with itself it would be neither zero nor antisymmetric.
"""

from __future__ import annotations

import numpy as np

from toolkit.reduced_model.model import Invariants
from toolkit.reduced_model.spatial_model import SpatialInvariants


def entry_scales(inv: Invariants | SpatialInvariants) -> dict[str, np.ndarray]:
    """Invariant -> the largest size that each of its entries could have; of the array's shape, or broadcast to it.

    The stress operator is no product of squares: its entries are measured by the largest ones of their columns and rows.
    """
    inertia = inv.inertia_about_origin
    squares = _of_squares(inertia)
    first = np.sqrt(np.abs(inv.mass * np.diag(inertia)))
    return {
        "mass": np.abs(inv.mass),
        "first_moment": np.broadcast_to(first, inv.first_moment.shape),
        **{name: np.broadcast_to(squares, getattr(inv, name).shape) for name in inv.moments},
        "stiffness": _of_squares(inv.stiffness),
        "damping": _of_squares(inv.damping),
        "stress_operator": _of_rows(inv.stress_operator),
    }


def _of_squares(matrix: np.ndarray) -> np.ndarray:
    root = np.sqrt(np.abs(np.diag(matrix)))
    return np.outer(root, root)


def _of_rows(array: np.ndarray) -> np.ndarray:
    """Largest entry of each column times the largest entry of each row in parts of that of its column."""
    rows = np.abs(array.reshape(-1, array.shape[-1]))
    columns = rows.max(axis=0, initial=0)
    parts = np.divide(rows, columns, out=np.zeros_like(rows), where=columns > 0).max(axis=1, initial=0)
    return (parts[:, None] * columns).reshape(array.shape)
