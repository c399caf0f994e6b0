"""Beginning of the static path: without load, where only the load makes a mechanism rest, or downhill in energy."""

from __future__ import annotations

import numpy as np
import scipy

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ConvergenceError, SingularSystemError
from toolkit.foundation.near_ties import first_largest
from toolkit.solvers.direct_solve import solve_linear
from toolkit.solvers.free_motions import free_motions
from toolkit.solvers.start.initial_conditions import POSITION_TOLERANCE
from toolkit.solvers.start.open_joints import search, told_gap
from toolkit.solvers.start.rigid_bodies import RigidBodies, told
from toolkit.solvers.static.equilibrium import Equilibrium, find_equilibrium, inputs_at, static_matrix, told_loose
from toolkit.solvers.static.static_matrix import (
    SparseFactors,
    factorised,
    free_count,
    largest_entry,
    scaled_by,
    softest,
    static_array,
)
from toolkit.system.equations import Terms
from toolkit.system.redundant_rows import hint_of_floating
from toolkit.system.system import System

LONGEST_STEP, NEWTON_DISTANCE, MOST_STEPS = 0.2, 1e-3, 300
"""Longest step and distance from which Newton is left alone, both in parts of the model size (or rad), and most steps."""
ROUND_OFF = 1e-12
"""Part of the largest stiffness, or of what would hold the loads over the longest step, that cannot be told from none."""
CLEARLY_POSITIVE = 10
"""A stiffness this much above round-off is positive beyond doubt."""
STANDSTILL_STEP = 1e-12
"""A step this short where the energy falls off to some side is the top of a hill, not the bottom of a valley."""


def descend(system: System, options: RunOptions, factor: float, q: np.ndarray, acc: np.ndarray) -> tuple[Equilibrium, int]:
    """Newton with a shifted stiffness, [K + s W] dq + phi_q^T dlam = - residual, phi_q dq = - phi.

    W compares coordinates by their weights, whatever the masses are. The shift s makes K + s W positive definite on the motions that the
    joints allow wherever K is not (twice the lowest eigenvalue, or enough to keep the step short), so that every step goes downhill; long
    steps are shortened. Open joints are closed on the way.

    Raises
    ------
    ConvergenceError
        There is no equilibrium in reach, or only an unstable one.
    SingularSystemError
        Something is free to move, or joints are redundant.
    """
    rest, n_b, inputs = np.zeros_like(q), system.n_b, inputs_at(system, options, factor)
    number = np.arange(system.n)
    for step in range(MOST_STEPS):
        terms = system.evaluate(inputs, q, rest, acc)
        shift = _shift(system, terms, acc)
        matrix = static_matrix(system, terms) + shift * _metric(system)
        try:
            correction = solve_linear(system, matrix, terms.inertial + terms.applied, f"statics at load factor {factor:g}")
        except SingularSystemError as error:
            raise SingularSystemError(f"{error}{told_loose(system, options)}") from None
        size = (system.weights[:n_b] * np.abs(np.real(correction[:n_b]))).max(initial=0)
        if shift == 0 and size <= NEWTON_DISTANCE:
            found, count = find_equilibrium(system, options, factor, q, acc, 2 * NEWTON_DISTANCE)
            return found, count + step
        if not np.isfinite(size) or size <= STANDSTILL_STEP:
            break
        part = np.where(number < n_b, min(1.0, LONGEST_STEP / size), number < system.n_q)
        q, acc = q - part * correction, acc - np.where(number < system.n_q, 0, correction)
    worst = system.most_moved(correction)
    raise ConvergenceError(
        f"the equilibrium is unstable or out of reach: {MOST_STEPS} steps downhill from the given positions end nowhere, last "
        f"moving {worst}. Give positions nearer to the wanted equilibrium, or let a damped transient run find it."
        + told_loose(system, options)
        + hint_of_floating(system.scene, system.numbering.bodies_of(_moving(system, correction)))
    )


def _moving(system: System, correction: np.ndarray) -> np.ndarray:
    """Coordinates that a correction moves about as much as any."""
    moved = system.weights[: system.n_b] * np.abs(np.real(correction[: system.n_b]))
    return np.flatnonzero(moved > 0.1 * moved.max(initial=0))


def _shift(system: System, terms: Terms, acc: np.ndarray) -> float:
    """Shift s of the stiffness.

    It is 0 where K is positive definite on the motions that the joints allow, or where nothing pulls along a motion that is free.
    """
    n_b = system.n_b
    if _plainly_stable(system, terms):
        return 0.0
    matrix = np.real(system.dense(static_matrix(system, terms)))
    stiffness, free = matrix[:n_b, :n_b], free_motions(matrix[:n_b, n_b:].T, system.weights[:n_b])
    if not free.shape[1]:
        return 0.0
    bounds = np.sum(np.abs(free) * (np.abs(stiffness) @ np.abs(free)), axis=0)
    stiffness = free.T @ stiffness @ free
    if not np.all(np.isfinite(stiffness)):
        raise ConvergenceError(
            "the stiffness of the given positions is not finite. Look for a number that is orders of magnitude off."
        )
    lowest = scipy.linalg.eigvalsh((stiffness + stiffness.T) / 2, subset_by_index=[0, 0])[0]
    pull = np.abs(free.T @ np.real(terms.inertial + terms.applied)[:n_b]).max() / LONGEST_STEP
    if lowest > ROUND_OFF * max(np.abs(stiffness).max(), pull):
        return 0.0
    held = float((np.abs(np.real(acc[system.n_q :])) / system.weights[system.n_q :]).max(initial=0.0))
    if lowest > ROUND_OFF * max(held, pull) and _stable_by_itself(stiffness, bounds):
        return 0.0
    return max(-2.0 * lowest, pull)


def _stable_by_itself(stiffness: np.ndarray, bounds: np.ndarray) -> bool:
    """Whether a stiffness is positive definite where every motion is compared with what it is made of, `bounds` (n,).

    The weight of a hanging beam holds it by 1e-14 of what stretches its short elements; but no stretch is part of its turning, so that
    the round-off of one is none of the other.
    """
    if not np.all(bounds > 0):
        return False
    scaled = stiffness / np.sqrt(bounds[:, None] * bounds)
    return bool(scipy.linalg.eigvalsh((scaled + scaled.T) / 2, subset_by_index=[0, 0])[0] > len(bounds) * ROUND_OFF)


def _plainly_stable(system: System, terms: Terms) -> bool:
    """Whether K is positive definite by so much that no closer look is needed.

    The solutions of sparse factors are known to be right, so that no stiffness of theirs is the round-off of a larger one.
    """
    n_b, residual = system.n_b, np.real(terms.inertial + terms.applied)[: system.n_b]
    matrix = static_array(system, terms)
    try:
        saddle = factorised(system, matrix)
    except SingularSystemError:
        return False
    soft = softest(saddle, free_count(system), n_b).values
    told = isinstance(saddle.factors, SparseFactors)
    largest = 0.0 if told else largest_entry(scaled_by(matrix, saddle.scale)[:n_b, :n_b])
    pull = float(np.linalg.norm(residual * saddle.scale[:n_b])) / LONGEST_STEP
    return saddle.negative == 0 and len(soft) > 0 and bool(soft.min() > CLEARLY_POSITIVE * ROUND_OFF * max(largest, pull))


def _metric(system: System) -> np.ndarray:
    """Metric W on the pattern: weights squared on the diagonal of the bodies' coordinates."""
    rows = np.repeat(np.arange(system.n), np.diff(system.plan.indptr))
    diagonal = (rows == system.plan.indices) & (rows < system.n_b)
    return np.where(diagonal, system.weights[rows] ** 2, 0.0)


def start_of_path(system: System, options: RunOptions) -> tuple[Equilibrium, float, int]:
    """First equilibrium, its load factor, and Newton iterations spent on it.

    Raises
    ------
    ConvergenceError
        The joints cannot be closed from the given positions.
    SingularSystemError
        Something is free to move with and without load, or joints are redundant.
    """
    q = system.undeformed()[0]
    try:
        state, count = descend(system, options, 0.0, q, np.zeros_like(q))
    except (ConvergenceError, SingularSystemError) as error:
        _refuse_open_joints(system, options, q, error)
        first = 1.0 / options.load_steps
        state, count = descend(system, options, first, q, _balancing(system, options, first, q))
        return state, first, count
    return state, 0.0, count


def _refuse_open_joints(system: System, options: RunOptions, q: np.ndarray, error: Exception) -> None:
    zero, n_q = np.zeros_like(q), system.n_q
    open_by = np.real(system.evaluate(inputs_at(system, options, 0.0), q, zero, zero).applied[n_q:])
    size = np.abs(open_by) * system.weights[n_q:]
    if size.max(initial=0) > POSITION_TOLERANCE:
        row = first_largest(size)
        bodies, inputs = RigidBodies(system), inputs_at(system, options, 0.0)
        found = search(bodies, inputs, q)
        if found is not None and not found.closes:
            raise ConvergenceError(told_gap(bodies, inputs, found)) from error
        raise ConvergenceError(
            f"the joints cannot be closed from the given positions: {system.numbering.names[n_q + row]} is open by "
            f"{told(system, n_q + row, open_by[row])} "
            f"({error}). Give positions, a length or a curve that fit together."
        ) from error


def _balancing(system: System, options: RunOptions, factor: float, q: np.ndarray) -> np.ndarray:
    """[0; lam] with the joint forces that come nearest to balancing the loads.

    Their geometric stiffness may be all that there is.
    """
    zero, n_q = np.zeros_like(q), system.n_q
    terms = system.evaluate(inputs_at(system, options, factor), q, zero, zero)
    transposed_phi_q = np.real(system.dense(terms.I_acc)[:n_q, n_q:])
    multipliers = np.linalg.lstsq(transposed_phi_q, -np.real(terms.inertial + terms.applied)[:n_q])[0]
    return np.concatenate([zero[:n_q], multipliers]).astype(system.dtype)
