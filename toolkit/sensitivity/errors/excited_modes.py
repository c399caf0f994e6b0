"""Vibrations that a jump of the accelerations excites: modes of the linearised motion, from vectors that begin with what the jump moves.

Of a large system few modes matter. Ritz vectors that start from the static answer to the load find them (Wilson, Yuan and Dickens, Dynamic
analysis by direct superposition of Ritz vectors, 1982):

    (K + s^2 M) x_1 = K a,   (K + s^2 M) x_(k+1) = M x_k,   all x in the motions that the joints allow

The jump a of the accelerations comes in as K a, so that what moves without a deformation counts as none. The shift s^2 keeps the matrix
regular where something is free to move, and leaves to slow motions what is theirs.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from toolkit.equations.equations import Terms
from toolkit.solvers.static.stability.saddle import Saddle, factorised
from toolkit.solvers.static.stability.static_array import whole_array
from toolkit.system.system import System

VECTORS = 24
"""Most Ritz vectors: some twenty modes of a load."""
NOTHING = 1e-6
"""Part of a vector that earlier ones leave of it, below which it is their sum."""


class ExcitedModes(NamedTuple):
    """Modes of unit modal mass, how they are damped, and how jumps push them.

    Attributes
    ----------
    rates
        Angular frequencies, (m,), in 1/time.
    damping
        Damping ratios, (m,).
    shapes
        Of coordinates, (n_q, m).
    resisted
        Stiffness times shapes, (n_q, m).
    forces
        Of multipliers, (n_lam, m), while the mode is at its largest.
    pushes
        Modal accelerations by each jump, (jumps, m).
    """

    rates: np.ndarray
    damping: np.ndarray
    shapes: np.ndarray
    resisted: np.ndarray
    forces: np.ndarray
    pushes: np.ndarray


def excited_modes(system: System, terms: Terms, jumps: np.ndarray, shift: float) -> ExcitedModes:
    """The modes that jumps of accelerations (n, jumps) excite, of a state whose terms are linearised.

    Parameters
    ----------
    shift : float
        Angular frequency in 1/time below which motions are none of these.

    Raises
    ------
    SingularSystemError
        The joints repeat each other, or something has neither mass nor stiffness.
    """
    stiffness, mass = _of_coordinates(system, terms.I_q + terms.A_q), _of_coordinates(system, terms.I_acc)
    of_multiplier = system.plan.indices >= system.n_q
    shifted = stiffness + shift**2 * (mass + system.unit_of_states)
    saddle = factorised(system, whole_array(system, np.where(of_multiplier, terms.I_acc, shifted)))
    basis = _ritz_vectors(system, saddle, mass, _forces(system, stiffness, jumps))
    reduced = basis.T @ _forces(system, stiffness, basis)
    squares, turned = scipy.linalg.eigh((reduced + reduced.T) / 2)
    kept = squares > (NOTHING * shift) ** 2
    rates, shapes = np.sqrt(squares[kept]), basis @ turned[:, kept]
    damped = np.einsum("im,im->m", shapes, system.times(_of_coordinates(system, terms.A_v), shapes))
    held = saddle.solve(_forces(system, mass, shapes))[system.n_q :] * (rates**2 + shift**2)
    n_q, resisted = system.n_q, _forces(system, stiffness, shapes)
    pushes = jumps.T @ resisted / rates**2
    return ExcitedModes(rates, damped / (2 * rates), shapes[:n_q], resisted[:n_q], held, pushes)


def _of_coordinates(system: System, values: np.ndarray) -> np.ndarray:
    """Values on the pattern without the columns of multipliers."""
    return np.where(system.plan.indices < system.n_q, values, 0.0)


def _forces(system: System, values: np.ndarray, motions: np.ndarray) -> np.ndarray:
    """What a matrix of coordinates makes of motions (n, k), on bodies alone."""
    found = system.times(values, motions)
    found[system.n_b :] = 0
    return found


def _ritz_vectors(system: System, saddle: Saddle, mass: np.ndarray, pushed: np.ndarray) -> np.ndarray:
    """Vectors (n, m) with X^T M X = 1, zero for multipliers."""
    basis, masses = np.zeros((system.n, 0)), np.zeros((system.n, 0))
    block = pushed
    while basis.shape[1] < VECTORS and block.shape[1]:
        found = saddle.solve(block)
        found[system.n_b :] = 0
        block = np.zeros((system.n, 0))
        for each in found.T:
            before = np.sqrt(max(each @ _forces(system, mass, each[:, None])[:, 0], 0.0))
            for _ in range(2):
                each = each - basis @ (masses.T @ each)
            moved = _forces(system, mass, each[:, None])
            size = np.sqrt(max(each @ moved[:, 0], 0.0))
            if size > NOTHING * before:
                basis, masses = np.column_stack([basis, each / size]), np.column_stack([masses, moved / size])
                block = np.column_stack([block, moved / size])
    return basis
