"""By how much shapes that were left out make frequencies too high.

A mode y of the reduced scene leaves r = K y - omega^2 M y in the full one. To first order the full one's square of its frequency is less by

    omega^2 - omega_full^2 = r^T delta(r) / y^T M y
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.foundation.verdict import Caution
from toolkit.solvers.static.equilibrium import LEVELS
from toolkit.system.solution import Solution
from toolkit.validity.bodies.reduced.full_scene import full_scene

TOLD, DOUBTFUL = 0.01, 0.05
"""Parts of a frequency by which it may be too high without a word, and without a doubt."""


def raised_frequencies(solution: Solution, squares: np.ndarray, shapes: np.ndarray) -> np.ndarray:
    """Parts (n_modes,) by which frequencies about a state at rest are too high, from omega^2 (n_modes,) and y (n_q, n_modes)."""
    full, found = full_scene(solution.system.scene), np.zeros(len(squares))
    if full is None:
        return found
    system, n_q = full.system, full.system.n_q
    q, acc = np.zeros((2, system.n))
    q[:n_q], acc[n_q:] = full.expanded @ solution.q[-1], solution.multipliers[-1]
    terms = system.evaluate(system.inputs(solution.times[-1], LEVELS), q, np.zeros(system.n), acc)
    mass, stiffness = (system.matrix(each)[:n_q, :n_q] for each in (terms.I_acc, terms.I_q + terms.A_q))
    y, vibrating = full.expanded @ shapes, squares > 0
    inert = mass @ y
    left = (stiffness @ y - inert * squares).T
    for part in (each for own in full.parts.values() for each in own.values()):
        forces = left[:, part.rows]
        found += np.einsum("mf,mf->m", forces, part.moved(forces))
    size = np.where(vibrating, 2 * squares * np.einsum("im,im->m", y, inert), np.inf)
    return found / size


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
