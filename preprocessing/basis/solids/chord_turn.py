"""Constraint modes of a solid whose frame goes through two of its points: those of all points, less what the chord takes from both."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy import sparse

from preprocessing.basis.reference.chord_axes import along, left
from preprocessing.basis.reference.chord_boundary import refuse_short, refuse_unknown
from preprocessing.basis.solids.ties import Tie
from toolkit.reduced_model.chord_condition import Chord


def chord_turn(chord: Chord, names: Sequence[str], ties: Mapping[str, Tie]) -> np.ndarray:
    """Matrix T (m n_points, m n_points - m) from motions that the chord leaves to those of all points; real or complex.

    Parameters
    ----------
    names : of the points, in the order of their motions

    Raises
    ------
    InputError
        One of the two points does not exist, or both are at one place.
    """
    refuse_unknown(chord, dict.fromkeys(names))
    refuse_short(chord, *(np.real(ties[name].point) for name in chord))
    rows = left(along(*(ties[name].point for name in chord)))
    m, one, other = len(rows), *(names.index(name) for name in chord)
    unit = np.eye(m * len(names))
    ends = np.concatenate([m * one + np.arange(m), m * other + np.arange(m)])
    others = np.delete(unit, ends, axis=1)
    turned: np.ndarray = np.column_stack([unit[:, ends] @ rows.T, others])
    return turned


def supported(stiffness: sparse.csr_array, rows: Sequence[sparse.csr_array]) -> sparse.csr_array:
    """Stiffness K + s B^T B of a free body, supported at the point with the fewest nodes.

    B are the rows of that point, among the `rows` that are held besides.

    Where B u is given, that changes nothing but the forces on B.
    """
    held = min(rows, key=lambda each: each.nnz)
    size = stiffness.diagonal().max()
    weight = sparse.diags_array(size / held.multiply(held).sum(axis=1))
    return (stiffness + held.T @ weight @ held).tocsr()
