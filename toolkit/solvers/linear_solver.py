"""The linear solver of the step loop: static sparse factors first, dense ones with pivoting where those are not good enough."""

from typing import NamedTuple

import numpy as np

from toolkit.kernel import kernel
from toolkit.solvers.dense_lu import dense_factor, dense_solve, dense_solve_block, to_dense
from toolkit.solvers.sparse_lu import LUPlan, analyse, backward_error, factor, multiply, solve, solve_block

SPARSE_TOLERANCE, DENSE_TOLERANCE = 1e-12, 1e-14
"""Smallest pivots, relative to the terms they are made of; recommended where they are tested."""
ACCEPTED_ERROR = 1e-9
"""Backward error after one refinement above which sparse factors are given up; Newton needs few digits, gradients many."""
REFINED_ERROR = 1e-14
"""Backward error that needs no refinement: some tens of round-off."""


class LinearSolver(NamedTuple):
    """Symbolic analysis and all memory; `mode[0]` is 1 while the factors are dense."""

    plan: LUPlan
    lu: np.ndarray
    work: np.ndarray  # (n,)
    residual: np.ndarray  # (n,)
    work_block: np.ndarray  # (n, n_x)
    dense: np.ndarray  # (n, n), not touched unless needed
    pivots: np.ndarray
    scale: np.ndarray
    mode: np.ndarray


def linear_solver(indptr: np.ndarray, indices: np.ndarray, n_q: int, n_x: int, dtype: type) -> LinearSolver:
    """Analyse a pattern and reserve memory."""
    n = len(indptr) - 1
    plan = analyse(indptr, indices, n_q)
    return LinearSolver(
        plan,
        np.zeros(int(plan.row_start[-1]), dtype),
        np.zeros(n, dtype),
        np.zeros(n, dtype),
        np.zeros((n, n_x), dtype),
        np.empty((n, n), dtype),
        np.zeros(n, np.int64),
        np.zeros((3, n)),
        np.zeros(1, np.int64),
    )


@kernel
def factorize(solver, indptr, indices, values):
    """Factor a matrix; -1, or the number of the unknown that the equations do not determine."""
    solver.mode[0] = 0
    if factor(solver.plan, values, solver.lu, solver.work, SPARSE_TOLERANCE) < 0:
        return -1
    return factorize_dense(solver, indptr, indices, values)


@kernel
def factorize_dense(solver, indptr, indices, values):
    """Factor with pivoting."""
    solver.mode[0] = 1
    to_dense(indptr, indices, values, solver.dense)
    return dense_factor(solver.dense, solver.pivots, solver.scale, DENSE_TOLERANCE)


@kernel
def apply_inverse(solver, vector):
    """Solve with the present factors, in place; vector (n,)."""
    if solver.mode[0] == 0:
        solve(solver.plan, solver.lu, vector, solver.work)
    else:
        dense_solve(solver.dense, solver.pivots, vector)


@kernel
def apply_inverse_block(solver, block):
    """Solve for many right-hand sides, in place; block (n, n_x)."""
    if solver.mode[0] == 0:
        solve_block(solver.plan, solver.lu, block, solver.work_block)
    else:
        dense_solve_block(solver.dense, solver.pivots, block)


@kernel
def refine(solver, indptr, indices, values, rhs, solution):
    """One step of iterative refinement."""
    multiply(indptr, indices, values, solution, solver.residual)
    for i in range(len(rhs)):
        solver.residual[i] = rhs[i] - solver.residual[i]
    apply_inverse(solver, solver.residual)
    for i in range(len(rhs)):
        solution[i] += solver.residual[i]


@kernel
def solve_checked(solver, indptr, indices, values, rhs, solution):
    """Solve, refine once if needed, fall back to pivoting if that is not enough; as `factorize`, -1 or the unknown."""
    solution[:] = rhs
    apply_inverse(solver, solution)
    if backward_error(indptr, indices, values, solution, rhs) <= REFINED_ERROR:
        return -1
    refine(solver, indptr, indices, values, rhs, solution)
    if solver.mode[0] == 1 or backward_error(indptr, indices, values, solution, rhs) <= ACCEPTED_ERROR:
        return -1
    failed = factorize_dense(solver, indptr, indices, values)
    solution[:] = rhs
    apply_inverse(solver, solution)
    return failed
