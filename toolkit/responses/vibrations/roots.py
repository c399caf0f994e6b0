"""Roots of small motions about an equilibrium, with their vectors of coordinates and multipliers."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.linalg import eig

from toolkit.foundation.errors import InputError, SingularSystemError
from toolkit.responses.vibrations.pencil import Pencil
from toolkit.solvers.free_motions import free_motions
from toolkit.system.system import System

SAME = 1e-6
"""Part of the largest by which two vibrations that are one differ: then neither has a derivative of its own."""
REFINED = 2
"""Steps of Rayleigh's quotient, whose error falls to its third power."""


class Vibration(NamedTuple):
    """s, its right and left vectors u and w (n,), and w^T (2 s M + C) u; if another has the same s it is not `alone`, and s is all."""

    s: complex
    right: np.ndarray
    left: np.ndarray
    scale: complex
    alone: bool


def find_vibration(system: System, pencil: Pencil, number: int, slowness: Callable[[complex], float]) -> Vibration:
    """The vibration of a number, from 1 on, of those whose `slowness` is no nan, in its order.

    Raises
    ------
    InputError
        There are not so many.
    SingularSystemError
        The joints leave no motion.
    """
    n_q = system.n_q
    J = pencil.stiffness[n_q:, :n_q]
    Z = free_motions(J, system.weights[:n_q])
    if not Z.shape[1]:
        raise SingularSystemError("the joints leave no motion, so nothing vibrates. Remove a joint or a driver.")
    reduced = Pencil(*(Z.T @ each[:n_q, :n_q] @ Z for each in pencil))
    values, left, right = _roots(reduced)
    known = [k for k in range(len(values)) if np.isfinite(slowness(complex(values[k])))]
    order = sorted(known, key=lambda k: slowness(complex(values[k])))
    if len(order) < number:
        raise InputError(f"there are {len(order)} vibrations about this equilibrium; number = {number} is none of them.")
    k = order[number - 1]
    others = [abs(values[other] - values[k]) for other in order if other != k]
    if values[k] == 0 or min(others, default=np.inf) <= SAME * abs(values[k]):
        return Vibration(values[k], right[:, k], left[:, k], 0.0, alone=False)
    s, u, w = _refined(reduced, values[k], right[:, k], left[:, k])
    u, w = Z @ u, Z @ w
    whole = s * s * pencil.mass + s * pencil.damping + pencil.stiffness
    u, w = (_with_multipliers(J, each, matrix) for each, matrix in ((u, whole), (w, whole.T)))
    return Vibration(s, u, w, w @ (2 * s * pencil.mass + pencil.damping) @ u, alone=True)


def _roots(pencil: Pencil) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """All finite s, and their left and right vectors as columns, in units of time in which stiffness and mass are alike.

    States of loads have no mass: each has one s, and another one that is infinite.
    """
    K, C, M = pencil
    unit = np.sqrt(np.abs(K).max() / np.abs(M).max())
    one, none = np.eye(len(K)), np.zeros(K.shape)
    first = np.block([[none, one], [-K / unit**2, -C / unit]])
    values, left, right = eig(first, np.block([[one, none], [none, M]]), left=True, right=True)
    finite = np.isfinite(values)
    return unit * values[finite], left[len(K) :, finite].conj(), right[: len(K), finite]


def _refined(pencil: Pencil, s: complex, u: np.ndarray, w: np.ndarray) -> tuple[complex, np.ndarray, np.ndarray]:
    """s and its vectors by Rayleigh's quotient, down to the round-off of the matrices themselves."""
    K, C, M = pencil
    for _ in range(REFINED):
        s = s - (w @ (s * s * M + s * C + K) @ u) / (w @ (2 * s * M + C) @ u)
        matrix = s * s * M + s * C + K
        try:
            u, w = np.linalg.solve(matrix, M @ u), np.linalg.solve(matrix.T, M.T @ w)
        except np.linalg.LinAlgError:  # s is a root to the last digit
            break
        u, w = u / np.abs(u).max(), w / np.abs(w).max()
    return s, u, w


def _with_multipliers(J: np.ndarray, motion: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """[u; mu] with A u + J^T mu = 0 for a motion u (n_q,) that joints allow."""
    n_q = len(motion)
    return np.append(motion, np.linalg.lstsq(J.T, -(matrix[:n_q, :n_q] @ motion))[0])
