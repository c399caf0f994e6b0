"""How many modes: from a wanted static error at the interface points, where only the lowest modes are known."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy import sparse

from preprocessing.basis.mode_count import check_static_error
from preprocessing.basis.normal_modes import NormalModes
from toolkit.foundation.errors import InputError


def count_by_static_error(modes: NormalModes, rows: Mapping[str, Any], system: Any, largest: float) -> int | None:
    """Smallest number of the modes with a relative static error of at most `largest`; None if these modes are not enough.

        || C - C_k || / || C ||,     C = R K^-1 R^T,  C_k = sum_{j <= k} (R phi_j) (R phi_j)^T / lambda_j

    with the largest singular value as the norm, and every row of R divided by the square root of its own compliance, see
    `mode_count.static_errors`.

    Raises
    ------
    InputError
        The wish cannot be meant, or no interface point can move.
    """
    check_static_error(largest)
    if not rows:
        raise InputError("a static error needs an interface point that can move: name one away from the clamp.")
    every = sparse.vstack(list(rows.values()), format="csr")
    compliance = every @ system.solve(every.T.toarray())
    scale = 1 / np.sqrt(np.diag(compliance))
    moves = scale[:, None] * (every @ modes.shapes) / np.sqrt(modes.eigenvalues)
    rest = scale[:, None] * compliance * scale
    whole = np.linalg.norm(rest, 2)
    for k, move in enumerate(moves.T, start=1):
        rest = rest - np.outer(move, move)
        if np.linalg.norm(rest, 2) <= largest * whole:
            return k
    return None
