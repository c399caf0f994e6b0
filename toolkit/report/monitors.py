"""Monitors of a motion: where its energy is, and how far its joints are from closed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.equations import allocate_work
from toolkit.solution import Solution
from toolkit.solvers.drift import largest_drift
from toolkit.solvers.elastic_force import elastic_force

REST = np.zeros(3)
"""Levels of the constraint rows that are not asked for."""


class Monitors(NamedTuple):
    """At every time, each (n_t,): energies in the scene's unit, drift relative to the scene's size (or in rad).

    work : what loads and gravity have done since the start, by the trapezoidal rule along the path; drivers and dampers are not in it
    """

    kinetic: np.ndarray
    strain: np.ndarray
    work: np.ndarray
    drift: np.ndarray

    @property
    def gap(self) -> np.ndarray:
        """Energy since the start that the loads did not bring: negative if damping or the time scheme took it, shape (n_t,)."""
        energy = self.kinetic + self.strain
        return energy - energy[0] - self.work


def monitor(solution: Solution) -> Monitors:
    """Energies and drift of a motion.

        T = v^T M(q) v / 2,    U = q^T K q / 2,    W_n+1 = W_n + (f_n + f_n+1)^T (q_n+1 - q_n) / 2

    with the force f of all loads on bodies at rest.
    """
    energies = np.array([_energies(solution, step) for step in range(len(solution.times))])
    forces = np.array([_load_force(solution, step) for step in range(len(solution.times))])
    steps = np.einsum("ti,ti->t", forces[:-1] + forces[1:], np.diff(np.real(solution.q), axis=0)) / 2
    return Monitors(energies[:, 0], energies[:, 1], np.append(0.0, np.cumsum(steps)), drift(solution))


def _padded(solution: Solution, values: np.ndarray) -> np.ndarray:
    return np.concatenate([values, np.zeros(solution.system.n - solution.system.n_q)])


def _energies(solution: Solution, step: int) -> tuple[float, float]:
    """Kinetic and strain energy; M v are the inertial forces at the acceleration v."""
    system = solution.system
    q, v = _padded(solution, solution.q[step]), _padded(solution, solution.v[step])
    terms = system.evaluate(system.inputs(solution.times[step], REST), q, np.zeros_like(q), v)
    return float(v @ terms.inertial) / 2, float(q @ elastic_force(system, q)) / 2


def _load_force(solution: Solution, step: int) -> np.ndarray:
    """Force of loads and gravity on the coordinates of bodies at rest, (n_q,): the applied terms are K q - f."""
    system, q = solution.system, _padded(solution, solution.q[step])
    terms = system.evaluate(system.inputs(solution.times[step], REST), q, np.zeros_like(q), np.zeros_like(q))
    return (elastic_force(system, q) - terms.applied)[: system.n_q]


def drift(solution: Solution) -> np.ndarray:
    """Largest violation of any joint at every time, (n_t,)."""
    system = solution.system
    curves, _ = system.curves(solution.times)
    work, rest, found = allocate_work(system.plan, system.dtype), np.zeros(system.n), np.zeros((len(solution.times), 3))
    for n, q in enumerate(solution.q):
        state = _padded(solution, q)[None]
        system.run(largest_drift, system.plan, system.functions, curves[n : n + 1], system.weights, state, rest, found[n], work)
    return found[:, 0]
