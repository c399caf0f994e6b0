"""One linear system outside of the step loop, and a diagnosis by name if it is singular."""

from __future__ import annotations

import numpy as np
import scipy

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import InputError, SingularSystemError
from toolkit.foundation.memory_sizes import GIGABYTE, in_gigabytes
from toolkit.linear.linear_solver import (
    DENSE_TOLERANCE,
    ONE_REFINEMENT_ENOUGH,
    SCALING_SWEEPS,
    LinearSolver,
    cleared,
    linear_solver,
    solve_once,
)
from toolkit.system.redundant_rows import hint_of_floating, hint_of_grounded
from toolkit.system.system import System

ZERO_SINGULAR_VALUE, SIMILAR_SINGULAR_VALUES = 1e-12, 10.0
"""Singular values, in parts of the largest, that are zero but for round-off; if none is, those that are like the smallest."""
SPARSE_FROM_UNKNOWNS = 400
"""Unknowns from which sparse factors come first: dense ones take as long there, and eight times as long for twice as many."""
LARGE_SHARE = 0.0931
"""Part of the largest from which an unknown takes part in a motion or in forces; no ratio of lengths that people choose."""


def solve_linear(system: System, values: np.ndarray, rhs: np.ndarray, where: str) -> np.ndarray:
    """Solve A X = rhs for values of A on the system's pattern; rhs (n,) or (n, columns).

    Raises
    ------
    SingularSystemError
        The equations do not determine all unknowns; names those that are free, or the joints that repeat each other.
    """
    block: np.ndarray = np.ascontiguousarray(rhs.reshape(system.n, -1), system.dtype)
    values = np.ascontiguousarray(values, system.dtype)
    if (found := _sparse(system, values, block)) is not None:
        return found[:, 0] if rhs.ndim == 1 else found
    out = _compiled(system, values, block, where) if system.compiled else _plain(system, values, block, where)
    return out[:, 0] if rhs.ndim == 1 else out


def _sparse(system: System, values: np.ndarray, block: np.ndarray) -> np.ndarray | None:
    """Solution of a large real system by sparse factors with pivoting, refined once; None where they are not good enough.

    The loop's own solver falls back to dense factors where its fixed order meets a bad pivot, as it does without inertia. Pivots are judged
    as those are: in parts of a matrix that was equilibrated.
    """
    if system.n < SPARSE_FROM_UNKNOWNS or not system.compiled:
        return None
    rows, columns = _scales(system, np.abs(values))
    matrix = scipy.sparse.csc_array(scipy.sparse.diags_array(rows) @ system.matrix(values) @ scipy.sparse.diags_array(columns))
    try:
        factors = scipy.sparse.linalg.splu(matrix, options={"Equil": False})
    except RuntimeError:  # exactly singular
        return None
    if not np.abs(factors.U.diagonal()).min() > DENSE_TOLERANCE:
        return None
    wanted = rows[:, None] * block
    found = factors.solve(wanted)
    change = factors.solve(wanted - matrix @ found)
    found, change = columns[:, None] * (found + change), columns[:, None] * change
    moved, changed = (np.abs(system.weights[: system.n_q, None] * each[: system.n_q]).max(initial=0) for each in (found, change))
    return found if np.isfinite(moved) and changed <= ONE_REFINEMENT_ENOUGH * moved else None


def _scales(system: System, sizes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Scales of rows and columns that bring the largest entries near 1, as `linear_solver.equilibrate`; from sizes on the pattern."""
    plan = system.plan
    of_row, scales = np.repeat(np.arange(system.n), np.diff(plan.indptr)), np.ones((2, system.n))
    for _ in range(SCALING_SWEEPS):
        scaled = sizes * scales[0, of_row] * scales[1, plan.indices]
        for scale, place in zip(scales, (of_row, plan.indices), strict=True):
            largest = np.zeros(system.n)
            np.maximum.at(largest, place, scaled)
            scale /= np.sqrt(np.where(largest > 0, largest, 1.0))
    return scales[0], scales[1]


def _compiled(system: System, values: np.ndarray, block: np.ndarray, where: str) -> np.ndarray:
    """Solution of a real system by the step loop's own solver."""
    plan, out, key = system.plan, np.zeros_like(block), (LinearSolver, block.shape[1])
    weights = system.weights[: plan.n_q]
    solver = system.scratch(key, lambda: linear_solver(system.lu_plan, weights.copy(), block.shape[1], system.dtype))
    cleared(solver, weights)
    first, result = block[:, 0].copy(), np.zeros(system.n)
    failed = system.run(solve_once, solver, plan.indptr, plan.indices, values, first, result, block, out)
    if failed >= 0:
        raise SingularSystemError(f"{where}: {diagnosis(system, values, failed)}")
    system.give_back(key, solver)
    return out


def _plain(system: System, values: np.ndarray, block: np.ndarray, where: str) -> np.ndarray:
    """Solution of a complex system by the library's dense solver, because the loop's would be slow as plain Python."""
    try:
        return np.linalg.solve(system.dense(values), block)
    except np.linalg.LinAlgError as error:
        raise SingularSystemError(f"{where}: {diagnosis(system, values, 0)}") from error


def diagnosis(system: System, values: np.ndarray, failed: int) -> str:
    """Unknowns that a singular matrix, by its values (n_entries,), leaves undetermined: the largest entries of its null vectors.

    There may be several of these, and any mixture of them is one too: so unknowns are judged by all together, as long as the rows
    of an orthonormal basis are, which no choice of the basis changes.
    """
    matrix = np.real(system.dense(values))
    if not np.all(np.isfinite(matrix)):
        return f"the equations hold values that are not finite, first met at {system.numbering.names[failed]}."
    moves = np.linalg.norm(_null_space(matrix), axis=1)
    parts = np.flatnonzero(moves > LARGE_SHARE * moves.max())
    names = ", ".join(system.numbering.names[i] for i in parts[:8]) + (" and more" if len(parts) > 8 else "")
    if np.all(parts >= system.n_q):
        hint = hint_of_grounded(system.scene, system.numbering.joints_of(parts))
        return (
            f"the constraints {names} repeat or contradict each other, so their forces are not determined. "
            "Remove one of these joints, replace a rigid joint by a revolute or slider (in space a revolute by a spherical), or let "
            f'solver.redundant = "least-squares" leave out what others imply.{hint}'
        )
    hint = hint_of_floating(system.scene, system.numbering.bodies_of(parts))
    return (
        f"nothing determines {names}: the mechanism is free to move there, or is in a singular position. "
        f"Add a joint, a driver or a spring, or move the points off the singular position.{hint}"
    )


def _null_space(matrix: np.ndarray) -> np.ndarray:
    """Orthonormal null vectors (n, k), at least one, of a matrix that is equilibrated first.

    They are in the units of its columns then.
    """
    rows, columns = np.ones(len(matrix)), np.ones(len(matrix))
    for _ in range(SCALING_SWEEPS):
        size = np.abs(rows[:, None] * matrix * columns)
        rows /= np.sqrt(_largest(size, 1))
        columns /= np.sqrt(_largest(size, 0))
    _, sizes, vectors = np.linalg.svd(rows[:, None] * matrix * columns)
    return vectors[sizes <= max(ZERO_SINGULAR_VALUE * sizes[0], SIMILAR_SINGULAR_VALUES * sizes[-1])].T


def _largest(size: np.ndarray, axis: int) -> np.ndarray:
    largest = size.max(axis=axis)
    return np.where(largest > 0, largest, 1.0)


MATRIX_COPIES = 4
"""Copies of the matrix of an equilibrium: itself, scaled, its factors, and what LAPACK works in."""


def check_dense(system: System, options: RunOptions) -> None:
    """Refuse an equilibrium whose matrices do not fit into memory.

    Raises
    ------
    InputError
        They need more than `solver.memory`.
    """
    needed = 8 * MATRIX_COPIES * system.n**2
    if needed > GIGABYTE * options.memory:
        raise InputError(
            f"the equilibrium of {system.n} unknowns takes dense matrices of {in_gigabytes(needed)}, more than solver.memory = "
            f"{options.memory:g} GB. Describe it by fewer bodies, let a damped transient run find it, whose matrices are sparse, or raise "
            "solver.memory on a larger machine."
        )
