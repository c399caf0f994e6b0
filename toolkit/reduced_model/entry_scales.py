"""How large the entries of a body's invariants could be at most: what their round-off, and their symmetry, are judged by.

Mass, stiffness and damping are sums of squares, so that by the inequality of Cauchy and Schwarz

    |G_ij|, |H_ij|, |Q_ab,ij| <= sqrt(G_ii G_jj)       |N_ai| <= sqrt(m G_ii)       |K_ij| <= sqrt(K_ii K_jj)       |D_ij| <=
    sqrt(D_ii D_jj)

with G the sum of the Q_aa in space. A matrix that vanishes, such as H of a straight beam's bending modes, holds nothing but
round-off: compared with itself it would be neither zero nor antisymmetric.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from toolkit.reduced_model.model import Invariants
from toolkit.reduced_model.spatial_model import SpatialInvariants
from toolkit.reduced_model.thin_arrays import is_sparse, sparing


class EntryScale(NamedTuple):
    """Sizes row_i column_j of an array's entries; i counts the places of all axes but the last, j those of the last."""

    row: np.ndarray
    column: np.ndarray

    def at(self, entry: np.ndarray) -> np.ndarray:
        """Sizes at places in the flattened array."""
        row, column = np.divmod(entry, len(self.column))
        return self.row[row] * self.column[column]


def entry_scales(inv: Invariants | SpatialInvariants) -> dict[str, np.ndarray]:
    """Largest size that each entry of every invariant could have, by name, in the shape of the array."""
    found = {name: np.outer(scale.row, scale.column) for name, scale in entry_factors(inv).items()}
    return {name: scale.reshape(getattr(inv, name).shape) for name, scale in found.items()}


def entry_factors(inv: Any) -> dict[str, EntryScale]:
    """Largest sizes as factors, for invariants in arrays, or in sparse matrices with all axes but the last in one.

    The stress operator is no product of squares: its entries are measured by the largest ones of their columns and rows.
    """
    inertia = _diagonal_of_inertia(inv)
    root, first = np.sqrt(np.abs(inertia)), np.sqrt(np.abs(inv.mass * inertia))
    planes = {name: _planes(getattr(inv, name), len(inertia)) for name in inv.moments}
    return {
        "mass": EntryScale(np.abs(np.atleast_1d(inv.mass)), np.ones(1)),
        "first_moment": EntryScale(np.ones(len(inv.first_moment)), first),
        **{name: EntryScale(np.tile(root, count), root) for name, count in planes.items()},
        **{name: _of_squares(getattr(inv, name)) for name in ("stiffness", "damping")},
        "stress_operator": _of_rows(inv.stress_operator),
    }


def _diagonal_of_inertia(inv: Any) -> np.ndarray:
    """Diagonal of the inertia matrix G; in space of the sum of the Q_aa."""
    if isinstance(inv, SpatialInvariants):
        z = inv.second_moment.shape[-1]
        moments = inv.second_moment if inv.second_moment.ndim == 2 else inv.second_moment.reshape(-1, z)
        return sum((moments[k * z : (k + 1) * z].diagonal() for k in range(1, 3)), moments[:z].diagonal())
    return inv.inertia.diagonal()


def _planes(moment: Any, z: int) -> int:
    """Number of matrices (z, z) stacked in an array."""
    return int(np.prod(moment.shape)) // z**2


def _of_squares(matrix: Any) -> EntryScale:
    root = np.sqrt(np.abs(matrix.diagonal()))
    return EntryScale(root, root)


def _of_rows(array: Any) -> EntryScale:
    """Largest entry of each column times the largest entry of each row in parts of that of its column."""
    width = array.shape[-1]
    rows = array.tocsr() if is_sparse(array) else sparing(array)
    if not is_sparse(rows):
        sizes = np.abs(rows)
        return EntryScale(_part(sizes, sizes.max(axis=0, initial=0.0)).max(axis=1, initial=0.0), sizes.max(axis=0, initial=0.0))
    size, column = np.abs(rows.data), rows.indices
    largest = np.zeros(width)
    np.maximum.at(largest, column, size)
    parts = np.zeros(rows.shape[0])
    np.maximum.at(parts, np.repeat(np.arange(rows.shape[0]), np.diff(rows.indptr)), _part(size, largest[column]))
    return EntryScale(parts, largest)


def _part(size: np.ndarray, of: np.ndarray) -> np.ndarray:
    return np.divide(size, of, out=np.zeros_like(size), where=of > 0)
