"""Monitors of a motion: where its energy is, and how far its joints are from closed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.equations.equations import allocate_work
from toolkit.system.solution import Solution
from toolkit.validity.motion.drift import largest_drift
from toolkit.validity.motion.energy_balance import EnergyBalance, energy_balance


class Monitors(NamedTuple):
    """Energies in the scene's unit, and at every time the drift (n_t,), relative to the scene's size (or in rad)."""

    energy: EnergyBalance
    drift: np.ndarray


def monitor(solution: Solution) -> Monitors:
    """Energies and drift of a motion."""
    return Monitors(energy_balance(solution), drift(solution))


def drift(solution: Solution) -> np.ndarray:
    """Largest violation of any joint at every time, (n_t,)."""
    system = solution.system
    curves, _ = system.curves(solution.times)
    work, rest, found = allocate_work(system.plan, system.dtype), np.zeros(system.n), np.zeros((len(solution.times), 4))
    for n, q in enumerate(solution.q):
        state = np.concatenate([q, rest[system.n_q :]])[None]
        system.run(largest_drift, system.plan, system.functions, curves[n : n + 1], system.weights, state, rest, found[n], work)
    return found[:, 0]
