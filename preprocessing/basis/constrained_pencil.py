"""Stiffness, mass and linear constraints of one body: what modes are computed from, and what their derivatives need."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True, eq=False)
class ConstrainedPencil:
    """Matrices K, M and R of the problem K u = lambda M u on all u with R u = 0, or their derivatives.

    They are on n nodal coordinates; the derivatives are those by one design variable.

    Derivatives may stay sparse, because they are only multiplied with shapes.
    """

    stiffness: Any  # (n, n)
    mass: Any  # (n, n)
    rows: np.ndarray  # (n_r, n); n_r may be zero


def constrained_pencil(stiffness: Any, mass: Any, rows: np.ndarray | None = None) -> ConstrainedPencil:
    """Constrained pencil with dense matrices; without rows the body is free."""
    k, m = _dense(stiffness), _dense(mass)
    return ConstrainedPencil(k, m, np.zeros((0, len(k))) if rows is None else rows)


def _dense(matrix: Any) -> np.ndarray:
    return matrix if isinstance(matrix, np.ndarray) else matrix.toarray()
