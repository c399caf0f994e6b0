"""All nodal coordinates of a body but as many as its chord holds: these follow the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from preprocessing.basis.constrained_pencil import ConstrainedPencil
from preprocessing.basis.reference.chord_axes import most_across
from preprocessing.basis.reference.chord_boundary import ChordBoundary
from toolkit.foundation.errors import InputError
from toolkit.foundation.near_ties import first_largest

REGULAR = 1e-6
"""Reciprocal condition of the rows on the coordinates that follow, below which two points share their nodes."""


@dataclass(frozen=True, eq=False)
class PinnedCoordinates:
    """Coordinates u_p = -R_p^-1 R_f u_f that follow from rows R of the chord, as many as it has."""

    rows: np.ndarray  # (m, n)
    pinned: np.ndarray  # (m,) numbers of coordinates

    follows_matrices: ClassVar[bool] = False

    @cached_property
    def columns(self) -> np.ndarray:
        """Shapes on the nodal coordinates, (n, n - m)."""
        n = self.rows.shape[1]
        free = np.delete(np.arange(n), self.pinned)
        shapes = np.eye(n)[:, free]
        shapes[self.pinned] = -np.linalg.solve(self.rows[:, self.pinned], self.rows[:, free])
        return shapes

    def rates(self, d_pencils: Sequence[ConstrainedPencil]) -> np.ndarray:
        """Derivatives (n, n - m, n_x) of the shapes: R dPsi = -dR Psi, in the coordinates that follow."""
        found = np.zeros((*self.columns.shape, len(d_pencils)))
        for k, each in enumerate(d_pencils):
            found[self.pinned, :, k] = -np.linalg.solve(self.rows[:, self.pinned], each.rows @ self.columns)
        return found


def pinned_coordinates(boundary: ChordBoundary) -> PinnedCoordinates:
    """Coordinates that follow the others: those of the nodes nearest to both points, as far as they lie across the chord.

    Raises
    ------
    InputError
        Both points have the same nearest node, or the rows do not hold the body there.
    """
    m, e = boundary.per_point, boundary.e
    across = most_across(e)
    one, other = (m * _nearest(boundary.interface_rows[name], m) for name in boundary.chord)
    turn = [] if len(e) == 2 else [one + 3 + next(k for k in range(3) if k not in across)]
    pinned = np.array([*(one + np.arange(len(e))), *turn, *(other + across)])
    found = PinnedCoordinates(boundary.rows[:m], pinned)
    if one == other or not 1 / np.linalg.cond(found.rows[:, pinned]) > REGULAR:
        raise InputError(
            f"chord: the points {boundary.chord.first!r} and {boundary.chord.second!r} are nearest to one node, so that the line through "
            "them turns with a single element. Choose points that are apart, or use more elements."
        )
    return found


def _nearest(rows: np.ndarray, m: int) -> int:
    """Number of the node that moves a point most."""
    weight = np.abs(rows[0].reshape(-1, m)[:, 0])
    for axis in range(1, m // 3 + 1):
        weight = weight + np.abs(rows[axis].reshape(-1, m)[:, axis])
    return first_largest(weight)
