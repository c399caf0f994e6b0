"""By how much shapes that were left out change vibrations, and make frequencies too high.

A vibration u exp(s t) of the reduced scene, and its left vector w, leave r = P(s) u and l = P(s)^T w in the full one, where
P = s^2 M + s C + K. To first order the full one's root is s + ds, with delta of the stiffness K + s C,

    ds = - l^T delta(r) / w^T (2 s M + C) u

or, of a mode y without dampers, omega^2 - omega_full^2 = - r^T delta(r) / y^T M y.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.foundation.verdict import Caution
from toolkit.solvers.static.equilibrium import LEVELS
from toolkit.solvers.static.stability.static_array import as_dense
from toolkit.system.solution import Solution
from toolkit.validity.bodies.reduced.full_scene import ReducedPart, full_scene

TOLD, DOUBTFUL = 0.01, 0.05
"""Parts of a frequency by which it may be too high without a word, and without a doubt."""


def root_changes(solution: Solution, s: np.ndarray, u: np.ndarray, w: np.ndarray, damped: np.ndarray) -> np.ndarray:
    """What roots s (n,) about a state at rest, with vectors u and w (n_q, n), lack to those of the full scene, ds (n,).

    Parameters
    ----------
    damped
        Factors (n,) of C.
    """
    full, found = full_scene(solution.system.scene), np.zeros(len(s), complex)
    if full is None:
        return found
    system, n_q = full.system, full.system.n_q
    q, acc = np.zeros((2, system.n))
    q[:n_q], acc[n_q:] = full.expanded @ solution.q[-1], solution.multipliers[-1]
    terms = system.evaluate(system.inputs(solution.times[-1], LEVELS), q, np.zeros(system.n), acc)
    K, C, M = (system.matrix(each)[:n_q, :n_q] for each in (terms.I_q + terms.A_q, terms.A_v, terms.I_acc))
    u, w = full.expanded @ u, full.expanded @ w
    right = K @ u + (C @ u) * (s * damped) + (M @ u) * s**2
    left = K.T @ w + (C.T @ w) * (s * damped) + (M.T @ w) * s**2
    for part in (each for own in full.parts.values() for each in own.values()):
        moved = _moved(part, as_dense(C[part.rows, part.rows]), s * damped, right[part.rows].T)
        found += np.einsum("fm,mf->m", left[part.rows], moved)
    return found / np.einsum("im,im->m", w, (C @ u) * damped + (M @ u) * (2 * s))


def _moved(part: ReducedPart, C: np.ndarray, rates: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """- delta (n, n_f) under forces r (n, n_f), with the stiffness K + C rate of each."""
    if not rates.any():
        found: np.ndarray = part.moved(forces.real) + 1j * part.moved(forces.imag)
        return found
    K = part.part.invariants.stiffness
    return np.concatenate([part.moved(force[None], K + C * rate) for force, rate in zip(forces, rates, strict=True)])


def raised_frequencies(solution: Solution, squares: np.ndarray, shapes: np.ndarray) -> np.ndarray:
    """Parts (n_modes,) by which frequencies about a state at rest are too high, from omega^2 (n_modes,) and y (n_q, n_modes)."""
    found, vibrating = np.zeros(len(squares)), squares > 0
    omega, y = np.sqrt(squares[vibrating]), shapes[:, vibrating]
    found[vibrating] = -root_changes(solution, 1j * omega, y, y, np.zeros(len(omega))).imag / omega
    return found


def cautions_of_raised(solution: Solution, squares: np.ndarray, shapes: np.ndarray) -> Iterator[Caution]:
    """The first of the frequencies that are too high, and the one that is so most."""
    parts = raised_frequencies(solution, squares, shapes)
    high = np.flatnonzero(parts > TOLD)
    if not high.size:
        return
    first, most = int(high[0]), int(np.argmax(parts))
    yield Caution(
        "left-out-shapes",
        "the parts of cut bodies keep some of their modes (modes_per_frame), so that frequencies are too high, or missing: number "
        f"{first + 1} by about {parts[first]:.1%}, {'which is the most' if most == first else f'number {most + 1} by {parts[most]:.0%}'}. "
        f"Those before number {first + 1} are so by less than {TOLD:.0%}. Write larger numbers, or leave them out.",
        doubt=bool(parts[most] > DOUBTFUL),
    )
