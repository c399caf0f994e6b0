"""Craig-Bampton shapes of a part: constraint modes where it is tied and gripped, and some shapes with these places held.

With the elastic coordinates of the part sorted into kept ones b and inner ones i,

    [b]   [      1         0  ] [b]
    [i] = [-K_ii^-1 K_ib   Phi] [p]

so that forces at kept coordinates, and what inner ones hand on to these at rest, are exact with any number of modes (R. R. Craig,
M. C. C. Bampton, AIAA J. 6 (1968) 1313). Phi are the lowest modes with b held, and then what these leave out of K_ii^-1 times the inertia
under uniform accelerations along and across the chord, by which weight bends and stretches the part as it does with all coordinates
(modal truncation augmentation: J. M. Dickens, J. M. Nakagawa, M. J. Wittbrodt, Comput. Struct. 62 (1997) 985).

The constraint modes follow the design, complex steps too. Phi is that of the nominal design of the reduced model, whatever the design:
shapes, of which the derivative is none.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from toolkit.foundation.near_ties import clusters, told_apart

NONE = 1e-9
"""Part of the strongest motion of a mode below which that of a coordinate is round-off: beams that bend do not stretch."""


@dataclass(frozen=True, eq=False)
class PartShapes:
    """Craig-Bampton shapes of a part: the elastic coordinates that are kept, and fixed-interface modes on the others."""

    kept: np.ndarray  # (n_b,) numbers of elastic coordinates, in their order
    modes: np.ndarray  # Phi (n_i, n_p), real
    weights: int = 0  # how many of its last columns are shapes under uniform acceleration

    @property
    def count(self) -> int:
        """Number of coordinates of the reduced part."""
        return len(self.kept) + self.modes.shape[1]

    @property
    def names(self) -> list[str]:
        """Names of the mode coordinates, the columns of Phi."""
        modes = [f"fixed-interface mode {k + 1}" for k in range(self.modes.shape[1] - self.weights)]
        return [*modes, *(f"shape {k + 1} under uniform acceleration" for k in range(self.weights))]

    def columns(self, stiffness: np.ndarray) -> np.ndarray:
        """Elastic coordinates per kept and mode coordinate, (n_f, n_b + n_p), at the stiffness (n_f, n_f) of a design."""
        inner = np.delete(np.arange(len(stiffness)), self.kept)
        found = np.zeros((len(stiffness), self.count), stiffness.dtype)
        found[self.kept, np.arange(len(self.kept))] = 1
        if inner.size:
            found[inner, : len(self.kept)] = -_solved(stiffness[np.ix_(inner, inner)], stiffness[np.ix_(inner, self.kept)])
            found[inner, len(self.kept) :] = self.modes
        return found


def part_shapes(stiffness: np.ndarray, inertia: np.ndarray, weights: np.ndarray, kept: np.ndarray, count: int) -> PartShapes:
    """Craig-Bampton shapes with the lowest fixed-interface modes; all coordinates if these are no more than the shapes.

    Modes of equal frequency are taken together, so that there may be some more than `count`.

    Parameters
    ----------
    stiffness, inertia : (n_f, n_f)
        Of the part at the nominal design; the inertia in parts of its mass, so that a mode coordinate is the RMS displacement of the part.
    weights : (n_f, d)
        Forces of inertia under uniform accelerations.
    kept : (n_b,)
        Numbers of the coordinates that are kept.
    """
    inner = np.delete(np.arange(len(stiffness)), kept)
    if len(inner) <= count + weights.shape[1]:
        return PartShapes(np.arange(len(stiffness)), np.zeros((0, 0)))
    own = np.ix_(inner, inner)
    return PartShapes(kept, *_inner_shapes(stiffness[own], inertia[own], weights[inner], count))


def _inner_shapes(stiffness: np.ndarray, mass: np.ndarray, weights: np.ndarray, count: int) -> tuple[np.ndarray, int]:
    """Shapes Phi (n_i, n_p) at unit inertia, and how many of its last columns are shapes under uniform acceleration.

    Such shapes are left out where the modes contain them but for round-off.
    """
    shapes, sizes = _modes(stiffness, mass, count), np.sqrt(np.diag(mass))
    n_modes = shapes.shape[1]
    for bent in _solved(stiffness, weights).T:
        known = NONE**2 * (bent @ mass @ bent)
        for _ in range(2):  # once leaves round-off of the part that is taken out
            bent = bent - shapes @ (shapes.T @ (mass @ bent))
        if (square := bent @ mass @ bent) > known:
            shapes = np.column_stack([shapes, bent / np.sqrt(square)])
    moves = sizes[:, None] * np.abs(shapes)
    return np.where(moves > NONE * moves.max(axis=0, initial=0.0), shapes, 0.0), shapes.shape[1] - n_modes


def _modes(stiffness: np.ndarray, mass: np.ndarray, count: int) -> np.ndarray:
    """Lowest normal modes (n_i, m), as eigenvectors of the flexibility, so that they have the most digits."""
    if not count:
        return np.zeros((len(mass), 0))
    factor = np.linalg.cholesky(mass)
    moved = _solved(stiffness, factor)
    flexibility = factor.T @ moved
    values, turned = np.linalg.eigh(-(flexibility + flexibility.T) / 2)
    squares = -1 / values
    behind = next(behind for _, behind in clusters(squares) if behind >= count)
    return told_apart(squares[:behind], moved @ turned[:, :behind] * squares[:behind], np.sqrt(np.diag(mass)))


def _solved(matrix: np.ndarray, sides: np.ndarray) -> Any:
    """Solution of a linear system with a narrow band, matrix^-1 sides, both real or complex."""
    return scipy.sparse.linalg.splu(scipy.sparse.csc_array(matrix)).solve(sides.astype(matrix.dtype))
