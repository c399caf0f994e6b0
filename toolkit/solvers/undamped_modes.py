"""Squares of rates and shapes of motions without dampers, K y = omega^2 M y, where K need not be symmetric.

A pair of complex squares is a pair of modes that flutter, if its imaginary parts are larger than what round-off makes of them,

    e (|w|^T |K| |u| + |omega^2| |w|^T |M| |u|) / |w^T M u|

with the right and left vectors u and w of this pair: the largest square of the scene says nothing about a slow one, and where two real
squares are about to merge w^T M u vanishes and so does what is known of them.
"""

from __future__ import annotations

import numpy as np
import scipy

from toolkit.foundation.errors import SingularSystemError
from toolkit.solvers.free_motions import ROUND_OFF, is_symmetric, is_symmetric_everywhere

SLOW = 1e-11
"""Part of the largest squared frequency below which another may be hidden by its round-off."""


STEPS = 2
"""Steps of Rayleigh's quotient, whose error falls to its third power."""


def undamped_modes(stiffness: np.ndarray, mass: np.ndarray, motions: np.ndarray, terms: float) -> tuple[np.ndarray, np.ndarray]:
    """Squares (n,) and shapes (n_q, n) among motions (n_q, n); complex if some flutter.

    Parameters
    ----------
    terms
        The largest of what entries of the stiffness against the motions are sums of.

    Raises
    ------
    SingularSystemError
        The mass matrix is not positive definite.
    """
    return _slow_ones_again(stiffness, mass, *_eigen(stiffness, mass, motions, terms), terms)


def _eigen(stiffness: np.ndarray, mass: np.ndarray, motions: np.ndarray, terms: float) -> tuple[np.ndarray, np.ndarray]:
    """Squares of rates and their shapes among motions (n_q, n).

    Complex are those pairs alone that flutter by more than round-off.
    """
    K, M = motions.T @ stiffness @ motions, motions.T @ mass @ motions
    if is_symmetric(K, terms) and is_symmetric_everywhere(stiffness):
        try:
            squares, vectors = scipy.linalg.eigh((K + K.T) / 2, (M + M.T) / 2)
        except scipy.linalg.LinAlgError as error:
            raise SingularSystemError(
                f"the mass matrix is not positive definite ({error}), so there are no modes. Give every body a mass that its stiffness "
                "does not dwarf beyond round-off."
            ) from error
        return squares, motions @ vectors
    squares, left, right = scipy.linalg.eig(K, M, left=True, right=True)
    real, vectors, pairs = squares.real.copy(), right.real.copy(), []
    for k in np.flatnonzero(squares.imag > 0):
        square, u, w = _refined(K, M, squares[k], right[:, k], left[:, k].conj())
        if abs(square.imag) > _round_off(stiffness, mass, square, motions @ u, motions @ w):
            pairs.append((k, square, u))
        else:
            vectors[:, k + 1] = right[:, k].imag
    if not pairs:
        return real, motions @ vectors
    squares, vectors = real.astype(complex), vectors.astype(complex)
    for k, square, u in pairs:
        squares[k : k + 2], vectors[:, k], vectors[:, k + 1] = (square, square.conjugate()), u, u.conj()
    return squares, motions @ vectors


def _round_off(stiffness: np.ndarray, mass: np.ndarray, square: complex, u: np.ndarray, w: np.ndarray) -> float:
    """Round-off of a square of a rate, by its own condition.

    Where two are about to merge w^T M u vanishes, and round-off makes them complex.
    """
    u, w, inert = np.abs(u), np.abs(w), abs(w @ mass @ u)
    return (
        10 * ROUND_OFF * float(w @ (np.abs(stiffness) + abs(square) * np.abs(mass)) @ u) / max(float(inert), np.finfo(float).tiny)
    )


def _slow_ones_again(
    stiffness: np.ndarray, mass: np.ndarray, squares: np.ndarray, shapes: np.ndarray, terms: float
) -> tuple[np.ndarray, np.ndarray]:
    """Slowest modes, found anew among themselves (Rayleigh and Ritz), as round-off of the fastest may make free ones unstable."""
    slow = np.flatnonzero(np.abs(squares) < SLOW * np.abs(squares).max())
    if slow.size:
        own = shapes[:, slow]
        below = squares[slow].imag < 0
        found, motions = _eigen(stiffness, mass, np.where(below, own.imag, own.real), terms)
        squares, shapes = (each.astype(np.result_type(each, found)) for each in (squares, shapes))
        squares[slow], shapes[:, slow] = found, motions
    return squares, shapes


def _refined(
    K: np.ndarray, M: np.ndarray, square: complex, u: np.ndarray, w: np.ndarray
) -> tuple[complex, np.ndarray, np.ndarray]:
    """Square omega^2 of K u = omega^2 M u, and its right and left vectors, by Rayleigh's quotient."""
    for _ in range(STEPS):
        square = (w @ K @ u) / (w @ M @ u)
        try:
            u, w = np.linalg.solve(K - square * M, M @ u), np.linalg.solve((K - square * M).T, M.T @ w)
        except np.linalg.LinAlgError:  # it is a root to the last digit
            break
        u, w = u / np.abs(u).max(), w / np.abs(w).max()
    return (w @ K @ u) / (w @ M @ u), u, w
