"""Compliance of a whole scene to small forces at one of its states: of bodies, joints and what else is stiff."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy

from toolkit.solvers.static.equilibrium import LEVELS
from toolkit.solvers.static.static_matrix import StaticArray, balance, balanced, static_array, whole_array
from toolkit.system.solution import Solution

LONGER = 30.0
"""Period, relative to the duration, of the vibration whose inertia holds free motions: a thousandth of the stiffness at one."""
Solver = Callable[[np.ndarray], np.ndarray]


class Yielding(NamedTuple):
    """Compliance of a scene at one state: maps forces (n_q,) to motions (n_q,) that joints allow."""

    solved: Solver  # of all unknowns, balanced
    scale: np.ndarray  # (n,) what balances them
    n_q: int

    def __call__(self, forces: np.ndarray) -> np.ndarray:
        return self._solution(forces)[: self.n_q]

    def multipliers(self, forces: np.ndarray) -> np.ndarray:
        """Multipliers by which joints hold these forces."""
        return self._solution(forces)[self.n_q :]

    def _solution(self, forces: np.ndarray) -> np.ndarray:
        whole = np.append(forces, np.zeros(len(self.scale) - self.n_q))
        found: np.ndarray = self.scale * self.solved(self.scale * whole)
        return found


def yielding(solution: Solution, n: int) -> Yielding | None:
    """Compliance of the scene at state `n`; None where it is not unique.

    What nothing holds in a motion has its inertia, of a vibration that takes much longer than the motion.
    """
    system, n_q = solution.system, solution.system.n_q
    pad = np.zeros(system.n - n_q)
    q, v = (np.append(np.real(state[n]), pad) for state in (solution.q, solution.v))
    acc = np.real(np.append(solution.a[n], solution.multipliers[n]))
    terms = system.evaluate(system.inputs(float(solution.times[n]), LEVELS), q, v, acc)
    matrix = static_array(system, terms)
    duration = float(solution.times[-1] - solution.times[0])
    if solution.steps and duration > 0:
        rate = (2 * np.pi / (LONGER * duration)) ** 2
        matrix = matrix + rate * _of_coordinates(whole_array(system, np.real(terms.I_acc)), n_q)
    scale = balance(system, matrix)
    solved = _solver(balanced(system, matrix, scale))
    return None if solved is None else Yielding(solved, scale, n_q)


def _of_coordinates(mass: StaticArray, n_q: int) -> StaticArray:
    """A mass matrix with zero rows and columns at the multipliers."""
    kept = np.arange(mass.shape[0]) < n_q
    if isinstance(mass, np.ndarray):
        found: np.ndarray = mass * kept * kept[:, None]
        return found
    only = scipy.sparse.diags_array(kept.astype(float))
    return scipy.sparse.csr_array(only @ mass @ only)


def _solver(matrix: StaticArray) -> Solver | None:
    """Solver of A x = f; None where A is singular."""
    if not isinstance(matrix, np.ndarray):
        try:
            return scipy.sparse.linalg.splu(scipy.sparse.csc_array(matrix)).solve  # type: ignore[no-any-return]
        except RuntimeError:  # exactly singular
            return None
    factors, pivots, info = scipy.linalg.lapack.dgetrf(matrix)
    if info:
        return None
    return lambda forces: scipy.linalg.lapack.dgetrs(factors, pivots, forces)[0]  # type: ignore[no-any-return]
