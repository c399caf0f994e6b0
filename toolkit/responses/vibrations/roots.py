"""Roots of small motions about an equilibrium, with their vectors of coordinates and multipliers."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy

from toolkit.foundation.errors import InputError, SingularSystemError
from toolkit.responses.vibrations.pencil import Pencil
from toolkit.solvers.free_motions import free_motions
from toolkit.solvers.roots import all_roots, is_zero, refined

SAME = 1e-6
"""Part of the largest by which two vibrations that are one differ: then neither has a derivative of its own."""


CLOSE = 0.01
"""Part of a slow root by which Rayleigh's quotient moves it at most: the round-off of one of 1e-7 of the fastest is 5e-3 of it, while one
that is round-off goes half the way to zero, or anywhere."""


Idle = Callable[[complex, np.ndarray], bool]


class Vibration(NamedTuple):
    """Root s, right and left vectors u and w (n,), and w^T (2 s M + C) u of a vibration.

    If another root is the same it is not `alone`, and u and w (n_q,) are some of its vectors.
    """

    s: complex
    right: np.ndarray
    left: np.ndarray
    scale: complex
    alone: bool


def find_vibration(
    weights: np.ndarray, pencil: Pencil, number: int, slowness: Callable[[complex], float], idle: Idle | None = None
) -> Vibration:
    """Vibration of a number, counted from 1 in the order of `slowness`, among those whose `slowness` is no nan.

    Parameters
    ----------
    weights : (n_q,)
        What makes coordinates comparable, see `numbering.weights`.
    idle
        Whether a root with its vector (n_q,) is that of a motion that nothing holds, where the state itself leaves it undecided.

    Raises
    ------
    InputError
        There are not so many.
    SingularSystemError
        The joints leave no motion.
    """
    Z, reduced = free_pencil(weights, pencil)
    values, left, right = _without_round_off(reduced, *all_roots(*reduced), _among(Z, idle))
    order = _order(values, slowness)
    if len(order) < number:
        raise InputError(f"there are {len(order)} vibrations about this equilibrium; number = {number} is none of them.")
    k = order[number - 1]
    others = [abs(values[other] - values[k]) for other in order if other != k]
    if values[k] == 0 or min(others, default=np.inf) <= SAME * abs(values[k]):
        return Vibration(values[k], Z @ right[:, k], Z @ left[:, k], 0.0, alone=False)
    return _whole(weights, pencil, Z, refined(*reduced, values[k], right[:, k], left[:, k]))


def softest_vibration(weights: np.ndarray, pencil: Pencil) -> Vibration:
    """Vibration with the least squared frequency, of a pencil without damping: far quicker than finding all."""
    Z, reduced = free_pencil(weights, pencil)
    squares, left, right = scipy.linalg.eig(reduced.stiffness, reduced.mass, left=True, right=True)
    order = np.argsort(squares.real)
    k = order[0]
    s = complex(np.sqrt(-squares[k] + 0j))
    if s == 0 or (len(order) > 1 and abs(squares[order[1]] - squares[k]) <= SAME * abs(squares[k])):
        return Vibration(s, Z @ right[:, k], Z @ left[:, k], 0.0, alone=False)
    return _whole(weights, pencil, Z, refined(*reduced, s, right[:, k].astype(complex), left[:, k].conj().astype(complex)))


def _whole(weights: np.ndarray, pencil: Pencil, Z: np.ndarray, found: tuple[complex, np.ndarray, np.ndarray]) -> Vibration:
    """Vibration that stands alone, with multipliers, from its vectors in the motions that joints leave free."""
    s, u, w = found[0], Z @ found[1], Z @ found[2]
    whole = s * s * pencil.mass + s * pencil.damping + pencil.stiffness
    J = pencil.stiffness[len(weights) :, : len(weights)]
    u, w = (_with_multipliers(J, each, matrix) for each, matrix in ((u, whole), (w, whole.T)))
    return Vibration(s, u, w, w @ (2 * s * pencil.mass + pencil.damping) @ u, alone=True)


def all_vibrations(
    weights: np.ndarray, pencil: Pencil, slowness: Callable[[complex], float], idle: Idle | None = None
) -> np.ndarray:
    """Roots s of all vibrations that count, in the order of their numbers; `idle` as of `find_vibration`."""
    Z, reduced = free_pencil(weights, pencil)
    values = _without_round_off(reduced, *all_roots(*reduced), _among(Z, idle))[0]
    return values[_order(values, slowness)]


def _without_round_off(
    pencil: Pencil, values: np.ndarray, left: np.ndarray, right: np.ndarray, idle: Idle
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Roots with their vectors; every motion that nothing holds has one root s = 0 in place of its two roots of round-off.

    A slow vibration is known from these by Rayleigh's quotient, which leaves it where it is.
    """
    small = np.flatnonzero([is_zero(s, np.abs(values).max(initial=0)) for s in values])
    zero = [int(k) for k in small if not _stays(pencil, values[k], right[:, k], left[:, k])]
    zero += [k for k in range(len(values)) if k not in zero and idle(complex(values[k]), right[:, k])]
    values[zero] = 0.0
    kept = np.delete(np.arange(len(values)), zero[: len(zero) - len(zero) // 2])
    return values[kept], left[:, kept], right[:, kept]


def _among(Z: np.ndarray, idle: Idle | None) -> Idle:
    """Test `idle` for vectors in the basis Z of the motions that joints leave free."""
    return lambda s, u: idle is not None and idle(s, Z @ u)


def _stays(pencil: Pencil, s: complex, u: np.ndarray, w: np.ndarray) -> bool:
    with np.errstate(all="ignore"):
        found = refined(*pencil, s, u, w)[0]
    return bool(abs(found - s) < CLOSE * abs(s))


def free_pencil(weights: np.ndarray, pencil: Pencil) -> tuple[np.ndarray, Pencil]:
    """Motions that the joints allow, (n_q, n_free), and the pencil reduced to these."""
    n_q = len(weights)
    felt = _felt(pencil, n_q)
    motions = free_motions(pencil.stiffness[n_q:, felt], weights[felt])
    Z = np.zeros((n_q, motions.shape[1]))
    Z[felt] = motions
    if not Z.shape[1]:
        raise SingularSystemError("the joints leave no motion, so nothing vibrates. Remove a joint or a driver.")
    return Z, Pencil(*(Z.T @ each[:n_q, :n_q] @ Z for each in pencil))


def _felt(pencil: Pencil, n_q: int) -> np.ndarray:
    """Numbers of the coordinates that have a mass or affect any other one.

    The state of a load that counts turns makes no vibration.
    """
    alone = np.eye(n_q, dtype=bool)
    stiffness = np.where(alone, 0, pencil.stiffness[:n_q, :n_q]).any(axis=0) | pencil.stiffness[n_q:, :n_q].any(axis=0)
    damping = np.where(alone, 0, pencil.damping[:n_q, :n_q]).any(axis=0)
    return np.flatnonzero(stiffness | damping | pencil.mass[:n_q, :n_q].any(axis=0))


def _order(values: np.ndarray, slowness: Callable[[complex], float]) -> list[int]:
    slow = {k: slowness(complex(value)) for k, value in enumerate(values)}
    return sorted((k for k in slow if np.isfinite(slow[k])), key=lambda k: slow[k])


def _with_multipliers(J: np.ndarray, motion: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Vector [u; mu] with A u + J^T mu = 0 for a motion u (n_q,) that joints allow."""
    n_q = len(motion)
    return np.append(motion, np.linalg.lstsq(J.T, -(matrix[:n_q, :n_q] @ motion))[0])
