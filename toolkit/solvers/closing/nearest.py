"""Positions in which joints are open by as little as possible, by Newton's method with a trust region on the sum of their squared gaps.

Second derivatives tell a position from which no move closes the joints from one that is the furthest from closing, such as a stretched
linkage: its gradient vanishes too, and it is left along its negative curvature.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.equations.equations import Inputs
from toolkit.foundation.near_ties import first_largest
from toolkit.solvers.closing.rigid_bodies import RigidBodies

CLOSED = 1e-9
"""Gap, a part of the model size (or rad), that is none."""
MOST = 100
LONGEST, SHORTEST = 0.3, 1e-12
"""First and last radius within which a model of second order is believed, in parts of the model size (or rad)."""
FLAT = 1e-9
"""Part of the largest curvature below which one is round-off."""
GAINS = 1e-13
"""Part of the sum of squares by which a step has to lessen it, to be worth taking."""
HARD = 1e3
"""Factor by which a gap that is to stay closed counts more than others; each time when the search begins anew."""


class Nearest(NamedTuple):
    """Coordinates (n,), and gaps of all constraints there (n_c,), in parts of the model size (or rad)."""

    q: np.ndarray
    gaps: np.ndarray

    @property
    def closes(self) -> bool:
        """Whether every joint is closed."""
        return bool(np.abs(self.gaps).max() <= CLOSED)


def nearest(bodies: RigidBodies, inputs: Inputs, q: np.ndarray, soft: np.ndarray | None = None) -> Nearest:
    """Position where all gaps are smallest, or those of `soft` constraints (n_c,) while the others stay closed; from q on."""
    hard = bodies.inner if soft is None else ~soft
    found = Nearest(q, bodies.gaps(inputs, q))
    for factor in (HARD**0.5, HARD, HARD**1.5):
        found = _descended(bodies, inputs, found.q, np.where(hard, factor**2, 1.0))
        if found.closes or not np.any(hard):
            break
    return found


def _descended(bodies: RigidBodies, inputs: Inputs, q: np.ndarray, stiff: np.ndarray) -> Nearest:
    """Position where the sum of squared gaps is smallest, for weights `stiff` of the squares (n_c,)."""
    radius, gaps = LONGEST, bodies.gaps(inputs, q)
    for _ in range(MOST):
        gaps, slopes, bent = bodies.linearised(inputs, q, stiff)
        move, foreseen = _step(slopes.T @ (stiff * gaps), slopes.T @ (stiff[:, None] * slopes) + bent, radius)
        before = stiff @ gaps**2 / 2
        if np.abs(gaps).max() <= CLOSED or radius < SHORTEST or foreseen <= GAINS * before:
            break
        trial = bodies.moved(q, move)
        after = stiff @ bodies.gaps(inputs, trial) ** 2 / 2
        good = (before - after) / foreseen
        radius = min(2 * radius, LONGEST) if good > 0.7 else radius / 4 if not good > 0.2 else radius
        q = trial if after < before else q
    return Nearest(q, bodies.gaps(inputs, q))


def _step(gradient: np.ndarray, curvature: np.ndarray, radius: float) -> tuple[np.ndarray, float]:
    """Newton's step downhill, no longer than the radius, and the predicted decrease of the sum."""
    sizes, motions = np.linalg.eigh(curvature)
    least = FLAT * np.abs(sizes).max()
    pull = motions.T @ gradient
    step = -pull / np.maximum(np.abs(sizes), least)
    if sizes[0] < -least and abs(step[0]) < radius / 2:
        side = motions[first_largest(np.abs(motions[:, 0])), 0]
        step[0] = radius / 2 * (-np.sign(pull[0]) if abs(pull[0]) > least * radius else np.sign(side))
    step *= min(1.0, radius / max(float(np.abs(step).max()), radius))
    return motions @ step, float(-pull @ step - sizes @ step**2 / 2)
