"""Distance of an equilibrium from a critical state, a limit point or bifurcation, where a stiffness against a motion vanishes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import CriticalStateError, SingularSystemError
from toolkit.solvers.free_motions import ROUND_OFF, free_motions, is_symmetric, made_of
from toolkit.solvers.static.equilibrium import Equilibrium, inputs_at
from toolkit.solvers.static.stability.saddle import factorised, is_positive
from toolkit.solvers.static.stability.static_array import StaticArray, as_dense, static_array
from toolkit.system.system import System

NEAREST = 1e-6
"""Gradients of a state whose softest stiffness vanishes within this part of the load are refused. They grow as 1 / sqrt(distance), and
they hold for changes that are small against the distance: nobody knows a load, or sets it, to so many digits."""
REACH = 1e-4
"""Part of the model size (or rad) over which the change of the stiffness is taken: a thousandth of it is told from
round-off."""
SHIFT = 1e-10
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
        The softest stiffness vanishes within `NEAREST` of the load; names the coordinate that moves most.
    """
    distance, motion = load_to_critical(system, options, state)
    if distance < NEAREST:
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
    step = REACH / max(moved.max(initial=0), REACH)  # at most the whole load
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
        shift = SHIFT * np.abs(matrix.diagonal() / system.weights**2)[: system.n_b].max() * metric
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
