"""Roots s of (s^2 M + s C + K) u = 0, and their vectors, down to the round-off of the matrices themselves."""

from __future__ import annotations

import numpy as np
import scipy

from toolkit.solvers.free_motions import ROUND_OFF

VIBRATES = 1e-6
"""Imaginary part of a root, in parts of its size, above which it vibrates."""
REFINED = 2
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
    for _ in range(REFINED):
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
    return not is_zero(s, largest) and bool(s.imag > VIBRATES * abs(s) or (abs(s.imag) <= VIBRATES * abs(s) and s.real > 0))


def frequency_of(s: complex) -> float:
    """Frequency Im s / 2 pi of a root; - Re s / 2 pi of a motion that grows without vibrating."""
    return float((s.imag if s.imag > VIBRATES * abs(s) else -s.real) / (2 * np.pi))


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
