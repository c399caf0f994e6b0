"""Roots of small motions about an equilibrium, with their vectors of coordinates and multipliers."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from toolkit.foundation.errors import InputError, SingularSystemError
from toolkit.responses.vibrations.pencil import Pencil
from toolkit.solvers.free_motions import free_motions
from toolkit.solvers.roots import all_roots, refined
from toolkit.system.system import System

SAME = 1e-6
"""Part of the largest by which two vibrations that are one differ: then neither has a derivative of its own."""


class Vibration(NamedTuple):
    """s, its right and left vectors u and w (n,), and w^T (2 s M + C) u; if another has the same s it is not `alone`, and
    u and w (n_q,) are some of its vectors."""

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
    values, left, right = all_roots(*reduced)
    known = [k for k in range(len(values)) if np.isfinite(slowness(complex(values[k])))]
    order = sorted(known, key=lambda k: slowness(complex(values[k])))
    if len(order) < number:
        raise InputError(f"there are {len(order)} vibrations about this equilibrium; number = {number} is none of them.")
    k = order[number - 1]
    others = [abs(values[other] - values[k]) for other in order if other != k]
    if values[k] == 0 or min(others, default=np.inf) <= SAME * abs(values[k]):
        return Vibration(values[k], Z @ right[:, k], Z @ left[:, k], 0.0, alone=False)
    s, u, w = refined(*reduced, values[k], right[:, k], left[:, k])
    u, w = Z @ u, Z @ w
    whole = s * s * pencil.mass + s * pencil.damping + pencil.stiffness
    u, w = (_with_multipliers(J, each, matrix) for each, matrix in ((u, whole), (w, whole.T)))
    return Vibration(s, u, w, w @ (2 * s * pencil.mass + pencil.damping) @ u, alone=True)


def _with_multipliers(J: np.ndarray, motion: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """[u; mu] with A u + J^T mu = 0 for a motion u (n_q,) that joints allow."""
    n_q = len(motion)
    return np.append(motion, np.linalg.lstsq(J.T, -(matrix[:n_q, :n_q] @ motion))[0])
