"""Test whether the static matrices of many states are positive, by the little in which they differ.

Most of a stiffness is that of bodies in their own frames, the same in all states. With the coordinates N among which it is, and which no
joint holds, and all others S, the matrix K + r J^T J, see `sparse_saddle`, is positive definite if and only if

    K_NN    and    K_SS + r J_S^T J_S - K_SN K_NN^-1 K_NS

are. So every state takes factors of the second one alone, which is small.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.solvers.static.stability.saddle import SYMMETRIC
from toolkit.solvers.static.stability.sparse_saddle import HOLD
from toolkit.system.system import System


class StaticEntries(NamedTuple):
    """Entries of the static matrices [K, G; J, 0] of k states, each at another place.

    Attributes
    ----------
    rows, columns : (m,)
        Where they are.
    values : (k, m)
        What they are.
    """

    rows: np.ndarray
    columns: np.ndarray
    values: np.ndarray

    @classmethod
    def on_pattern(cls, system: System, values: np.ndarray) -> StaticEntries:
        """Values (k, m) on the common pattern of a system."""
        return cls(np.repeat(np.arange(system.n), np.diff(system.plan.indptr)), system.plan.indices, values)

    def added(self, rows: np.ndarray, columns: np.ndarray, values: np.ndarray) -> StaticEntries:
        """Entries with others (k, l) added, each at another place, that may be at known places or at new ones."""
        at, known = self._at(rows, columns)
        summed = self.values.copy()
        summed[:, at[known]] += values[:, known]
        return StaticEntries(
            np.append(self.rows, rows[~known]), np.append(self.columns, columns[~known]), np.hstack([summed, values[:, ~known]])
        )

    def _at(self, rows: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Numbers (l,) of the entries at some places, and whether these places are known at all."""
        n = int(max(self.columns.max(), self.rows.max(), columns.max(), rows.max())) + 1
        places, wanted = self.rows * n + self.columns, rows * n + columns
        order = np.argsort(places)
        at = order[np.minimum(np.searchsorted(places, wanted, sorter=order), len(places) - 1)]
        return at, places[at] == wanted

    def asymmetry(self) -> np.ndarray:
        """Largest difference (k,) of entries from those across the diagonal."""
        at, known = self._at(self.columns, self.rows)
        found: np.ndarray = np.abs(self.values - np.where(known, self.values[:, at], 0.0)).max(axis=1, initial=0.0)
        return found

    def block(self, rows: np.ndarray, columns: np.ndarray, states: slice = slice(None)) -> np.ndarray:
        """Blocks (k, rows, columns) of the matrices of some states."""
        count = int(max(self.rows.max(), self.columns.max(), rows.max(initial=0), columns.max(initial=0))) + 1
        row, column = np.full((2, count), -1)
        row[rows], column[columns] = np.arange(len(rows)), np.arange(len(columns))
        r, c = row[self.rows], column[self.columns]
        inside = (r >= 0) & (c >= 0)
        given = self.values[states][:, inside]
        found = np.zeros((len(given), len(rows), len(columns)))
        found[:, r[inside], c[inside]] = given
        return found


def are_positive(system: System, static: StaticEntries) -> bool:
    """Whether symmetric matrices are known to be positive against all motions that the joints allow, all of them."""
    if len(system.plan.dropped) or not np.all(np.isfinite(static.values)):
        return False
    n_b = system.n_b
    scaled = _in_comparable_sizes(system, static)
    largest = np.abs(scaled.values).max(axis=1)
    if not np.all(scaled.asymmetry() <= SYMMETRIC * largest):
        return False
    differing = _differing(n_b, scaled)
    S, N, ties = np.flatnonzero(differing), np.flatnonzero(~differing), np.arange(n_b, system.n)
    K_NN, K_NS, K_SS, J = scaled.block(N, N, slice(1)), scaled.block(N, S), scaled.block(S, S), scaled.block(ties, S)
    held = K_SS + (HOLD / largest)[:, None, None] * (J.transpose(0, 2, 1) @ J)
    try:
        np.linalg.cholesky(K_NN)
        K_NS = K_NS[:1] if np.all(K_NS[0] == K_NS) else K_NS
        followed = np.linalg.solve(K_NN[0], np.concatenate([*K_NS], axis=1))  # K_NN^-1 K_NS, of all states at once
        followed = followed.reshape(len(N), len(K_NS), len(S)).transpose(1, 0, 2)
        np.linalg.cholesky(held - K_NS.transpose(0, 2, 1) @ followed)
    except np.linalg.LinAlgError:
        return False
    return True


def _in_comparable_sizes(system: System, static: StaticEntries) -> StaticEntries:
    """Entries of D A D for all matrices, with D as of `saddle.balance`."""
    (rows, columns, values), n_b = static, system.n_b
    scale = np.append(1 / system.weights[:n_b], np.ones(system.n - n_b))
    values = values * (scale[rows] * scale[columns])
    stiffness, ties = (np.abs(values[:, (rows < n_b) & of]).max(axis=1, initial=0.0) for of in (columns < n_b, columns >= n_b))
    both = (stiffness > 0) & (ties > 0)
    size = np.where(both, stiffness / np.where(both, ties, 1.0), 1.0)[:, None]
    values[:, rows >= n_b] *= size
    values[:, columns >= n_b] *= size
    return StaticEntries(rows, columns, values)


def _differing(n_b: int, static: StaticEntries) -> np.ndarray:
    """Which coordinates (n_b,) joints hold, or have a stiffness with others that is not the same in all states.

    They are as few as leave only what is the same, chosen one by one as the one that has most of the other entries.
    """
    rows, columns, values = static
    held = np.zeros(n_b, bool)
    held[rows[(rows < n_b) & (columns >= n_b)]] = True
    held[columns[(rows >= n_b) & (columns < n_b)]] = True
    changed = (rows < n_b) & (columns < n_b) & np.any(values != values[0], axis=0)
    rows, columns = rows[changed], columns[changed]
    left = ~(held[rows] | held[columns])
    while np.any(left):
        most = int(np.argmax(np.bincount(np.append(rows[left], columns[left]), minlength=n_b)))
        held[most] = True
        left &= (rows != most) & (columns != most)
    return held
