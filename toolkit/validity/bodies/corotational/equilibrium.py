"""Equilibrium of a frame of corotational elements under given loads, by Newton's method with steps of the load.

The frame of the body is held by rows C u = 0, as in its reduced model; their forces p take up what the loads do not balance:

    f(u) + C^T p = factor F,    C u = 0,    factor from 0 to 1
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from toolkit.foundation.errors import InputError
from toolkit.validity.bodies.corotational.elements import Corotational

FIRST_STEP, SMALLEST_STEP = 0.1, 1e-3
"""Parts of the load: the steps, halved where Newton fails or finds an unstable state, and where they are not halved any more."""
ITERATIONS = 40
HOLD = 1e3
"""Stiffness of a held direction, in parts of that of the stiffest: its square is far from round-off and from any of the body."""
EXACT, ROUND_OFF = 1e-10, 1e-6
"""Corrections, in parts of the body's size, that Newton is content with: at once; or when they shrink no more."""


def solve_corotational(frame: Corotational, loads: np.ndarray, held: np.ndarray) -> np.ndarray:
    """Displacements (n,) under loads F (n,), reached from zero; their directions stay.

    Parameters
    ----------
    held : (3, n), C

    Raises
    ------
    InputError
        No equilibrium is found up to the full load: the body buckles or snaps through before.
    """
    u, factor, step = np.zeros(len(loads)), 0.0, FIRST_STEP
    while factor < 1 - 1e-12:
        target = min(1.0, factor + step)
        found = _newton(frame, target * loads, held, u)
        if found is None:
            step /= 2
            if step < SMALLEST_STEP:
                raise InputError(
                    f"the corotational body finds no equilibrium beyond {100 * factor:.1f} % of its forces: it buckles or snaps "
                    "through there, which the linear body does not know. Check the scene with smaller loads."
                )
            continue
        u, factor = found, target
    return u


def _newton(frame: Corotational, loads: np.ndarray, held: np.ndarray, u: np.ndarray) -> np.ndarray | None:
    """The equilibrium next to u; None if the iteration does not find it, or it is unstable."""
    size, before = np.ptp(frame.nodes, axis=0).max(), np.inf
    for _ in range(ITERATIONS):
        try:
            correction = Bordered.of(frame.tangent(u), held).solve(loads - frame.force(u))
        except RuntimeError:  # an exactly singular tangent
            return None
        u = u + correction
        change = np.hypot(correction[0::3], correction[1::3]).max()
        if change <= EXACT * size or (change <= ROUND_OFF * size and change > before / 2):
            return u if _stable(frame.tangent(u), held) else None
        if not change < 1e3 * size:
            return None
        before = change
    return None


def _stable(stiffness: Any, held: np.ndarray) -> bool:
    """Whether K is positive definite in all directions that the rows C leave free: K + C^T C is, with C made stiff."""
    scale = _scale(stiffness)
    border = held * scale
    stiff = HOLD * border / np.linalg.norm(border, axis=1)[:, None]
    try:
        np.linalg.cholesky(scale[:, None] * stiffness.toarray() * scale + stiff.T @ stiff)
    except np.linalg.LinAlgError:
        return False
    return True


def _scale(stiffness: Any) -> np.ndarray:
    """Scales of the unknowns that make the diagonal of K one: a skin is far stiffer in tension than in bending."""
    return 1 / np.sqrt(np.abs(stiffness.diagonal()))


@dataclass(frozen=True)
class Bordered:
    """Factors of [K C^T; C 0] in scaled unknowns."""

    factors: Any
    scale: np.ndarray

    @classmethod
    def of(cls, stiffness: Any, held: np.ndarray) -> Bordered:
        """Factor a symmetric K (n, n) held by the rows C (m, n)."""
        scale = _scale(stiffness)
        border = held * scale
        border = sparse.csc_array(border / np.linalg.norm(border, axis=1)[:, None])
        spread = sparse.diags_array(scale)
        return cls(splu(sparse.block_array([[spread @ stiffness @ spread, border.T], [border, None]], format="csc")), scale)

    def solve(self, loads: np.ndarray) -> np.ndarray:
        """Displacements (n,) under loads (n,) with C u = 0."""
        rest = np.zeros(self.factors.shape[0] - len(loads))
        return self.scale * self.factors.solve(np.concatenate([self.scale * loads, rest]))[: len(loads)]
