"""Distance of an equilibrium from a limit point or a bifurcation, and a test of many states for it.

Most of a stiffness is that of bodies in their own frames, the same in all states. With the coordinates N among which it is, and which no
joint holds, and all others S, the matrix K + r J^T J, see `static_matrix`, is positive definite if and only if

    K_NN    and    K_SS + r J_S^T J_S - K_SN K_NN^-1 K_NS

are. So every state takes factors of the second one alone, which is small.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import CriticalStateError, SingularSystemError
from toolkit.solvers.free_motions import ROUND_OFF, free_motions, is_symmetric, made_of
from toolkit.solvers.static.equilibrium import Equilibrium, inputs_at
from toolkit.solvers.static.static_matrix import (
    ASYMMETRY_ROUND_OFF,
    JOINT_STIFFNESS,
    StaticArray,
    as_dense,
    factorised,
    is_positive,
    static_array,
)
from toolkit.system.system import System

NEAREST_LIMIT = 1e-6
"""Gradients of a state whose softest stiffness vanishes within this part of the load are refused. They grow as 1 / sqrt(distance), and
they hold for changes that are small against the distance: nobody knows a load, or sets it, to so many digits."""
STIFFNESS_CHANGE_MOVE = 1e-4
"""Part of the model size (or rad) over which the change of the stiffness is taken: a thousandth of it is told from
round-off."""
SINGULAR_SHIFT = 1e-10
"""Part of the largest stiffness that makes a singular matrix regular."""
ITERATIONS = 8
"""Iterations of the inverse iteration: a stiffness that vanishes a million times sooner than others is found in two."""


def is_stable(system: System, options: RunOptions, state: Equilibrium, factor: float) -> bool:
    """Whether the stiffness is positive against all motions that the joints allow (no divergence; following forces may still flutter)."""
    return not has_negative_stiffness(system, _matrix(system, options, state.q, state.acc, factor), state.acc)


def has_negative_stiffness(system: System, matrix: StaticArray, acc: np.ndarray) -> bool:
    """Whether the static matrix (n, n) at [a; lam] has a negative stiffness, by more than round-off, against a motion that joints allow."""
    if isinstance(matrix, np.ndarray) and is_positive(system, matrix):
        return False
    try:
        if factorised(system, matrix).negative == 0:
            return False
    except SingularSystemError:
        pass  # a stiffness that is zero to round-off is not negative
    n_b, forces = system.n_b, np.append(np.zeros(len(system.numbering.states)), acc[system.n_q :])
    matrix = as_dense(matrix)
    weights, phi_q = system.weights[:n_b], matrix[:n_b, n_b:].T
    free = free_motions(phi_q, weights)
    if not free.shape[1]:
        return False
    stiffness, largest = free.T @ matrix[:n_b, :n_b] @ free, made_of(matrix[:n_b, :n_b], phi_q, forces, weights, free).max()
    if is_symmetric(stiffness, largest):
        return bool(scipy.linalg.eigvalsh((stiffness + stiffness.T) / 2)[0] <= -ROUND_OFF * largest)
    values = scipy.linalg.eigvals(stiffness)
    real = values.real[np.abs(values.imag) <= 1e-9 * np.abs(values)]
    return bool(real.min(initial=0) <= -ROUND_OFF * largest)


def refuse_gradients_of_critical(system: System, options: RunOptions, state: Equilibrium) -> None:
    """Refuse derivatives at a limit point or bifurcation under the full load, where they are infinite.

    Raises
    ------
    CriticalStateError
        The softest stiffness vanishes within `NEAREST_LIMIT` of the load; names the coordinate that moves most.
    """
    distance, motion = load_to_critical(system, options, state)
    if distance < NEAREST_LIMIT:
        raise CriticalStateError(
            f"there is no gradient at a limit point or bifurcation: the stiffness against a motion of {system.most_moved(motion)} "
            f"vanishes within {distance:.1e} of the load, and derivatives become infinite. Take a load that is further from the "
            "critical one (ffrf statics finds it if the load is raised), or ask for the values alone."
        )


def load_to_critical(system: System, options: RunOptions, state: Equilibrium) -> tuple[float, np.ndarray]:
    """Part of the load until the softest stiffness k vanishes, by its rate along the path's tangent t, and the soft motion (n,).

        distance = |k / (dk/dfactor)|,   K phi + phi_q^T mu = k W phi,   phi_q phi = 0,   W = diag(w^2)

    Before a limit point k goes as the root of the distance, so that it is half of this; before a bifurcation it is this.
    """
    n_q, n_b = system.n_q, system.n_b
    if 2 * n_b <= system.n:
        return np.inf, np.zeros(system.n)  # the joints leave no motion
    moved = system.weights[:n_b] * np.abs(np.real(state.tangent[:n_b]))
    step = STIFFNESS_CHANGE_MOVE / max(moved.max(initial=0), STIFFNESS_CHANGE_MOVE)  # at most the whole load
    here, motion = softest_motion(system, _matrix(system, options, state.q, state.acc, 1.0))
    of_q = np.arange(system.n) < n_q
    sides = []
    for change in (step, -step):
        q, acc = (part + change * np.where(mask, state.tangent, 0) for part, mask in ((state.q, of_q), (state.acc, ~of_q)))
        sides.append(softest_motion(system, _matrix(system, options, q, acc, 1.0 + change))[0])
    rate = (sides[0] - sides[1]) / (2 * step)
    return (abs(here / rate) if rate else np.inf), motion


def soft_motion(system: System, options: RunOptions, state: Equilibrium, factor: float) -> np.ndarray:
    """Motion (n,) against which the stiffness is nearest to zero."""
    return softest_motion(system, _matrix(system, options, state.q, state.acc, factor))[1]


def softest_motion(system: System, matrix: StaticArray) -> tuple[float, np.ndarray]:
    """Stiffness of a static matrix nearest to zero and its motion, by inverse iteration; zero if it is singular to the last digit.

    Then a shift that no digit of the motion feels makes it regular, unless joints repeat each other.
    """
    metric = np.where(np.arange(system.n) < system.n_b, system.weights**2, 0.0)
    motion = np.random.default_rng(0).normal(size=system.n) / system.weights
    solution, singular = _solution(matrix, metric), False
    if solution is None:
        shift = SINGULAR_SHIFT * np.abs(matrix.diagonal() / system.weights**2)[: system.n_b].max() * metric
        is_dense = isinstance(matrix, np.ndarray)
        solution, singular = _solution(matrix + (np.diag(shift) if is_dense else scipy.sparse.diags_array(shift)), metric), True
    if solution is None:
        return 0.0, motion
    value = 0.0
    for _ in range(ITERATIONS):
        motion = motion / np.sqrt(motion @ (metric * motion))
        solved = solution(motion)
        value = 1.0 / (motion @ (metric * solved))
        motion = solved
    return (0.0 if singular else float(value)), motion


def _solution(matrix: StaticArray, metric: np.ndarray) -> Callable[[np.ndarray], np.ndarray] | None:
    """Function x -> A^-1 (metric x); None if A is singular to the last digit."""
    if isinstance(matrix, np.ndarray):
        try:
            inverse = np.linalg.solve(matrix, np.diag(metric))
        except np.linalg.LinAlgError:
            return None
        return lambda motion: inverse @ motion
    try:
        factors = scipy.sparse.linalg.splu(scipy.sparse.csc_array(matrix))
    except RuntimeError:
        return None
    return lambda motion: factors.solve(metric * motion)


def _matrix(system: System, options: RunOptions, q: np.ndarray, acc: np.ndarray, factor: float) -> StaticArray:
    return static_array(system, system.evaluate(inputs_at(system, options, factor), q, np.zeros_like(q), acc))


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
    if not np.all(scaled.asymmetry() <= ASYMMETRY_ROUND_OFF * largest):
        return False
    differing = _differing(n_b, scaled)
    S, N, ties = np.flatnonzero(differing), np.flatnonzero(~differing), np.arange(n_b, system.n)
    K_NN, K_NS, K_SS, J = scaled.block(N, N, slice(1)), scaled.block(N, S), scaled.block(S, S), scaled.block(ties, S)
    held = K_SS + (JOINT_STIFFNESS / largest)[:, None, None] * (J.transpose(0, 2, 1) @ J)
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
