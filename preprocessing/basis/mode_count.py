"""How many modes: from a wanted highest frequency, or from a wanted static error at the interface points."""

from __future__ import annotations

import numpy as np

from preprocessing.basis.normal_modes import NormalModes, cluster
from toolkit.foundation.errors import InputError
from toolkit.foundation.mode_shapes import EQUAL


def count_by_frequency(modes: NormalModes, highest: float, least: int = 1) -> int:
    """Number of modes up to the frequency `highest` in Hz; a cluster of equal eigenvalues is taken whole, and what equals `highest` counts.

    Parameters
    ----------
    modes : all modes of the mesh
    least : smallest number that makes sense: 1 for a basis of modes alone, 0 beside constraint modes

    Raises
    ------
    InputError
        No mode is so low, or the mesh has no mode so high.
    """
    found = modes.frequencies
    if not len(found):
        raise InputError("no mode can be chosen by frequency: the boundary leaves no motion. Name fewer interface points.")
    if not highest <= found[-1] * (1 + EQUAL):
        raise InputError(f"modes up to {highest:g} Hz cannot be told: the mesh ends at {found[-1]:.6g} Hz. Use more elements.")
    count = int(np.count_nonzero(found <= highest * (1 + EQUAL)))
    if count < least:
        raise InputError(f"no mode lies below {highest:g} Hz: the lowest has {found[0]:.6g} Hz. Choose a higher frequency.")
    return cluster(modes.spectrum, count - 1)[1] if count else 0


def count_by_static_error(modes: NormalModes, interface_rows: np.ndarray, largest: float) -> int:
    """Smallest number of modes whose `static_errors` is at most `largest`; a cluster of equal eigenvalues is taken whole.

    Parameters
    ----------
    modes : all modes of the mesh
    interface_rows : (k, n)

    Raises
    ------
    InputError
        The request is invalid, or no interface point can move.
    """
    check_static_error(largest)
    errors = static_errors(modes, interface_rows)
    return cluster(modes.spectrum, int(np.argmax(errors <= largest)) - 1)[1]


def check_static_error(largest: float) -> None:
    """Refuse a wanted static error that no number of modes can have.

    Raises
    ------
    InputError
        It is not between 0 and 1.
    """
    if not 0 < largest < 1:
        raise InputError(f"a static error of {largest:g} is invalid: without modes it is 1, with all it is 0; write 0.01, say.")


def static_errors(modes: NormalModes, interface_rows: np.ndarray) -> np.ndarray:
    """Relative static error at the interface points when only the lowest k modes are kept, for k = 0, 1, ..., all: (1 + m,).

        || C - C_k || / || C ||,     C = R K^-1 R^T = sum_j (R phi_j) (R phi_j)^T / lambda_j,  C_k: the first k terms

    with the largest singular value as the norm. Every row of R is first divided by the square root of its own compliance, so that
    displacements and rotations count alike. Of a free body, C belongs to loads whose inertia forces keep them in balance.

    Raises
    ------
    InputError
        No interface point can move.
    """
    moves = interface_rows @ modes.shapes / np.sqrt(modes.eigenvalues)  # (k, m)
    own = np.sqrt((moves**2).sum(axis=1))
    able = own > 1e-9 * _largest_possible(modes, interface_rows)  # rows on the clamped node move by round-off
    if not able.any():
        raise InputError("a static error needs an interface point that can move: name one away from the clamped node.")
    scaled = moves[able] / own[able, None]
    whole = np.linalg.norm(scaled, 2)  # of moves: the norms of the compliances are the squares
    return np.array([np.linalg.norm(scaled[:, k:], 2) for k in range(modes.count)] + [0.0]) ** 2 / whole**2


def _largest_possible(modes: NormalModes, interface_rows: np.ndarray) -> np.ndarray:
    """Size of sqrt(R K^-1 R^T) if all of a row followed the softest mode, (k,)."""
    return np.linalg.norm(interface_rows / np.sqrt(np.diag(modes.pencil.mass)), axis=1) / np.sqrt(modes.eigenvalues[:1])
