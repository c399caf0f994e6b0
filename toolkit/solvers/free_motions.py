"""Motions that the joints allow, the stiffness against them, and the roots and shapes of their free vibrations.

Squares of rates and shapes of motions without dampers, K y = omega^2 M y, where K need not be symmetric.

A pair of complex squares is a pair of modes that flutter, if its imaginary parts are larger than what round-off makes of them,

    e (|w|^T |K| |u| + |omega^2| |w|^T |M| |u|) / |w^T M u|

with the right and left vectors u and w of this pair: the largest square of the scene says nothing about a slow one, and where two real
squares are about to merge w^T M u vanishes and so does what is known of them.
"""

from __future__ import annotations

import numpy as np
import scipy

from toolkit.foundation.errors import SingularSystemError
from toolkit.system.system import System

ROUND_OFF = 1e-14
"""Part of the largest squared frequency, or of the stiffnesses that a mode's own is the sum of, below which it cannot be told
from zero."""
UNSYMMETRIC_PART = 1e-9
"""Part of the largest stiffness that following forces make unsymmetric at least, if they do so at all."""


def made_of(
    stiffness: np.ndarray, phi_q: np.ndarray, multipliers: np.ndarray, weights: np.ndarray, motions: np.ndarray
) -> np.ndarray:
    """Size of the terms that the stiffness against motions (n_q, m) is the sum of, (m, m), by which its round-off is measured.

    They are entries of the stiffness, and joint forces at levers of the model size: those of a balance, which has no stiffness, cancel in
    each entry already.
    """
    sizes: np.ndarray = np.abs(motions)
    lever = (np.abs(phi_q.T) @ np.abs(np.real(multipliers)) / weights).max(initial=0)
    moves = (weights[:, None] * sizes).max(axis=0)
    return sizes.T @ np.abs(stiffness) @ sizes + lever * np.outer(moves, moves)


def free_motions(phi_q: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Basis of the motions that the joints allow, (n_q, n_free), in coordinates scaled to comparable size."""
    if not len(phi_q):
        return np.diag(1 / weights)
    scaled = phi_q / weights
    _, sizes, rows = np.linalg.svd(scaled)
    rank = np.count_nonzero(sizes > np.finfo(float).eps * max(scaled.shape) * sizes.max(initial=0))
    free: np.ndarray = rows[rank:].T / weights[:, None]
    return free


def felt_state(system: System, stiffness: np.ndarray) -> str:
    """Name of the first state of a load that bodies feel, by a stiffness (n_q, n_q) or larger; empty if there is none.

    One that counts turns they do not feel.
    """
    n_b = system.n_b
    felt = np.flatnonzero(np.any(stiffness[:n_b, n_b : system.n_q], axis=0))
    return system.numbering.names[n_b + felt[0]] if len(felt) else ""


def is_symmetric(stiffness: np.ndarray | scipy.sparse.csr_array, terms: float = 0.0) -> bool:
    """Whether a stiffness is symmetric but for round-off; `terms` is the largest of what its entries are sums of."""
    return bool(abs(stiffness - stiffness.T).max() <= UNSYMMETRIC_PART * abs(stiffness).max() + 10 * ROUND_OFF * terms)


def is_symmetric_everywhere(matrix: np.ndarray | scipy.sparse.csr_array) -> bool:
    """Whether each entry is the same as its mirror, beside the stiffness of its own two coordinates.

    A force that follows a soft body makes it unsymmetric, however stiff others are.
    """
    largest, size = abs(matrix).max(), np.sqrt(np.abs(matrix.diagonal()))
    if isinstance(matrix, np.ndarray):
        off, least = np.abs(matrix - matrix.T), np.outer(size, size)
        return bool(np.all(off <= UNSYMMETRIC_PART * (least + np.abs(matrix)) + ROUND_OFF * largest))
    off = scipy.sparse.coo_array(abs(matrix - matrix.T))
    both = np.asarray(scipy.sparse.csr_array(abs(matrix))[off.row, off.col]).ravel()
    allowed = UNSYMMETRIC_PART * (size[off.row] * size[off.col] + both) + ROUND_OFF * largest
    return bool(np.all(off.data <= allowed))


VIBRATING_PART = 1e-6
"""Imaginary part of a root, in parts of its size, above which it vibrates."""
REFINEMENTS = 2
"""Steps of Rayleigh's quotient, whose error falls to its third power."""


def all_roots(K: np.ndarray, C: np.ndarray, M: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """All finite s, and their left and right vectors as columns, in units of time in which stiffness and mass are alike.

    States of loads have no mass: each has one s, and another one that is infinite.
    """
    unit = np.sqrt(np.abs(K).max() / np.abs(M).max()) or 1.0
    one, none = np.eye(len(K)), np.zeros(K.shape)
    first = np.block([[none, one], [-K / unit**2, -C / unit]])
    values, left, right = scipy.linalg.eig(first, np.block([[one, none], [none, M]]), left=True, right=True)
    finite = np.isfinite(values)
    return unit * values[finite], left[len(K) :, finite].conj(), right[: len(K), finite]


def refined(
    K: np.ndarray, C: np.ndarray, M: np.ndarray, s: complex, u: np.ndarray, w: np.ndarray
) -> tuple[complex, np.ndarray, np.ndarray]:
    """Root s and its right and left vectors, refined by Rayleigh's quotient."""
    for _ in range(REFINEMENTS):
        s = s - (w @ (s * s * M + s * C + K) @ u) / (w @ (2 * s * M + C) @ u)
        matrix = s * s * M + s * C + K
        try:
            u, w = np.linalg.solve(matrix, M @ u), np.linalg.solve(matrix.T, M.T @ w)
        except np.linalg.LinAlgError:  # s is a root to the last digit
            break
        u, w = u / np.abs(u).max(), w / np.abs(w).max()
    return s, u, w


def is_zero(s: complex, largest: float) -> bool:
    """Whether a root is zero beside the largest one, as it is for a motion that nothing holds."""
    return bool(abs(s) ** 2 <= 10 * ROUND_OFF * largest**2)


def counts(s: complex, largest: float) -> bool:
    """Whether a root counts as a mode: one of each pair does, and none that neither vibrates nor grows."""
    return not is_zero(s, largest) and bool(
        s.imag > VIBRATING_PART * abs(s) or (abs(s.imag) <= VIBRATING_PART * abs(s) and s.real > 0)
    )


def frequency_of(s: complex) -> float:
    """Frequency Im s / 2 pi of a root; - Re s / 2 pi of a motion that grows without vibrating."""
    return float((s.imag if s.imag > VIBRATING_PART * abs(s) else -s.real) / (2 * np.pi))


def count_of_zeros(values: np.ndarray, largest: float) -> int:
    """Number of motions that nothing holds, by all roots: each has two."""
    return sum(is_zero(each, largest) for each in values) // 2


def all_frequencies(values: np.ndarray) -> np.ndarray:
    """Frequencies of all roots, ascending, with zero for each motion that nothing holds."""
    largest = float(np.abs(values).max(initial=0))
    zeros = [0.0] * count_of_zeros(values, largest)
    return np.sort([*(frequency_of(each) for each in values if counts(each, largest)), *zeros])


def undamped_rates(K: np.ndarray, M: np.ndarray) -> np.ndarray:
    """Angular frequencies of all vibrations without dampers, in rad/time, ascending.

    They are zero for what does not vibrate, and alike for two that flutter.
    """
    return np.sort(np.abs(np.imag(np.sqrt(-scipy.linalg.eigvals(K, M) + 0j))))


HIDDEN_SQUARED_FREQUENCY = 1e-11
"""Part of the largest squared frequency below which another may be hidden by its round-off."""


RAYLEIGH_STEPS = 2
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
    slow = np.flatnonzero(np.abs(squares) < HIDDEN_SQUARED_FREQUENCY * np.abs(squares).max())
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
    for _ in range(RAYLEIGH_STEPS):
        square = (w @ K @ u) / (w @ M @ u)
        try:
            u, w = np.linalg.solve(K - square * M, M @ u), np.linalg.solve((K - square * M).T, M.T @ w)
        except np.linalg.LinAlgError:  # it is a root to the last digit
            break
        u, w = u / np.abs(u).max(), w / np.abs(w).max()
    return (w @ K @ u) / (w @ M @ u), u, w
