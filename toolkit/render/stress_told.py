"""The stress that pictures tell of bodies over time, and below which size it is round-off."""

from __future__ import annotations

import numpy as np

from toolkit.bodies.model_body import ModelBody
from toolkit.responses.stress.stress import stress_components
from toolkit.responses.stress.von_mises import point_stress
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.flexible_bodies import elastic_coordinates, flexible_body
from toolkit.system.solution import Solution

STRAIN = 1e-11
"""A strain that is round-off: displacements have 16 digits, of which differences of neighbours lose some."""
_AT_ONCE = 256
"""Instants whose stress is in memory together."""


def stress_range(solution: Solution, body: str, steps: slice = slice(None)) -> np.ndarray:
    """Smallest and largest stress of a flexible body at every time, (n_t, 2); zero where it is round-off."""
    scene, states = solution.system.scene, np.real(solution.q[steps, elastic_coordinates(solution, body)])
    found = np.zeros((len(states), 2))
    for first in range(0, len(states), _AT_ONCE):
        some = slice(first, first + _AT_ONCE)
        stress = point_stress(np.real(stress_components(scene, body, states[some])))
        found[some] = np.column_stack([stress.min(axis=1, initial=0), stress.max(axis=1, initial=0)])
    found[np.abs(found).max(axis=1, initial=0) <= round_off(scene, body)] = 0
    return found


def largest_stress(solution: Solution) -> np.ndarray:
    """Largest magnitude of the stress of any flexible body at every time, (n_t,)."""
    flexible = [name for name, body in solution.system.scene.bodies.items() if isinstance(body, ModelBody)]
    every = [np.zeros(len(solution.times)), *(np.abs(stress_range(solution, body)).max(axis=1) for body in flexible)]
    return np.asarray(np.max(every, axis=0))


def round_off(scene: ResolvedScene, body: str) -> float:
    """Stress below which it counts as zero: of a strain that is round-off in the stiffest material that the model names."""
    nominal = scene.model(flexible_body(scene, body).model).nominal
    return STRAIN * max((float(value) for name, value in nominal.items() if "youngs_modulus" in name), default=0.0)


def told(stress: np.ndarray, limit: float) -> float:
    """Largest finite magnitude of stresses, zero if that is not above a limit."""
    largest = float(np.abs(stress[np.isfinite(stress)]).max(initial=0.0))
    return largest if largest > limit else 0.0
