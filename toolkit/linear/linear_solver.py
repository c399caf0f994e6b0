"""The linear solver of the step loop: static sparse factors first, dense ones with pivoting where those are not good enough."""

from typing import NamedTuple

import numpy as np

from toolkit.foundation.compiled.rows import add_rows, filled_up
from toolkit.foundation.kernel import copy, inner, kernel
from toolkit.linear.dense_lu import dense_factor, dense_solve, dense_solve_block, to_dense
from toolkit.linear.factored_matrix import add_factored_block
from toolkit.linear.sparse_analysis import LUPlan
from toolkit.linear.sparse_lu import StillPivots, factor, multiply, solve, still_pivots


@kernel
def solve_block(plan, lu, rhs, work):
    """Solution of A X = rhs, in place; rhs and work (n, w), the design axis contiguous and filled up as `add_rows` needs it."""
    n = plan.order.size
    for i in range(n):
        copy(rhs[plan.order[i]], work[i])
    for i in range(n):
        add_rows(work[i], 1.0, -1.0, lu, plan.column, plan.row_start[i], plan.diagonal[i], work)
    for i in range(n - 1, -1, -1):
        diagonal = plan.diagonal[i]
        add_rows(work[i], lu[diagonal], -1.0, lu, plan.column, diagonal + 1, plan.row_start[i + 1], work)
    for i in range(n):
        copy(work[i], rhs[plan.order[i]])


SPARSE_TOLERANCE, DENSE_TOLERANCE = 1e-12, 1e-14
"""Smallest pivots, relative to the terms they are made of; recommended where they are tested."""
TRUSTED_REFINEMENT, MENDED = 1e-6, 1e-4
"""Refinement of a solution, relative to it, above which one is not enough, as the square of that is left after it; and above which two are
not, so that sparse factors are given up. Light rods that hold a stiff part of a skin leave 1e-6 to 1e-5."""

UNREFINED = 1e-12
"""Refinement of a vector, relative to it, below which blocks are not refined. Gradients by the thickness of a thin skin lose some 80 times
what a step leaves: the wing's are off by 8e-10 on some processors with ten times this bound and by 7e-11 with it, for 3 % of their time."""


class LinearSolver(NamedTuple):
    """Symbolic analysis of a pattern and all memory of the solver; `mode[0]` is 1 while the factors are dense."""

    plan: LUPlan
    lu: np.ndarray
    kept: StillPivots
    work: np.ndarray  # (n,)
    residual: np.ndarray  # (n,)
    work_block: np.ndarray  # (n, n_x filled up)
    residual_block: np.ndarray
    solution_block: np.ndarray
    weights: np.ndarray  # (n_q,) what makes coordinates comparable, see `numbering.weights`
    dense: np.ndarray  # (n, n), not touched unless needed
    pivots: np.ndarray
    scale: np.ndarray
    mode: np.ndarray
    quality: np.ndarray  # (1,) relative change by the last first refinement
    updates: int  # multiplications of a sparse factorisation


def linear_solver(plan: LUPlan, weights: np.ndarray, n_x: int, dtype: type) -> LinearSolver:
    """Solver with memory for an analysed pattern; `weights` are those of the n_q coordinates."""
    n = len(plan.order)
    return LinearSolver(
        plan,
        np.zeros(int(plan.row_start[-1]), dtype),
        still_pivots(plan, dtype),
        np.zeros(n, dtype),
        np.zeros(n, dtype),
        np.zeros((n, filled_up(n_x)), dtype),
        np.zeros((n, filled_up(n_x)), dtype),
        np.zeros((n, filled_up(n_x)), dtype),
        weights,
        np.empty((n, n), dtype),
        np.zeros(n, np.int64),
        np.zeros((3, n)),
        np.zeros(1, np.int64),
        np.full(1, TRUSTED_REFINEMENT),
        updates_of(plan),
    )


def cleared(solver: LinearSolver, weights: np.ndarray) -> None:
    """Clear used memory to what `linear_solver` reserves; `weights` are copied."""
    for memory in (solver.lu, *solver.kept, solver.work, solver.residual, solver.pivots, solver.scale, solver.mode):
        memory.fill(0)
    for block in (solver.work_block, solver.residual_block, solver.solution_block):
        block.fill(0)
    solver.quality.fill(TRUSTED_REFINEMENT)
    solver.weights[:] = weights


def updates_of(plan: LUPlan) -> int:
    """Number of multiplications of a sparse factorisation.

    Every entry right of a pivot that changes meets all of them in each row below.
    """
    beside = (plan.row_start[1:] - plan.diagonal - 1)[plan.still[0] :]
    return int(beside @ (beside + 1))


@inner
def cheaper_anew(solver, entries, n_x):
    """Whether new sparse factors cost less than the refinement of a block (n, n_x) with old ones; a matrix has `entries`.

    Measured, one multiplication of the factorisation, whose places are looked up, takes as long as 14 numbers of the refinement, which are
    taken eight at a time, and an entry of it as long as 10 besides.
    """
    return 14 * solver.updates < (10 + n_x) * (len(solver.lu) + entries)


@inner
def factorize(solver, indptr, indices, values):
    """Factor a matrix; -1, or the number of the unknown that the equations do not determine."""
    solver.mode[0] = 0
    if factor(solver.plan, values, solver.lu, solver.work, SPARSE_TOLERANCE, solver.kept) < 0:
        return -1
    return factorize_dense(solver, indptr, indices, values)


@inner
def factorize_dense(solver, indptr, indices, values):
    """Factor a matrix with pivoting; results as those of `factorize`."""
    solver.mode[0] = 1
    to_dense(indptr, indices, values, solver.dense)
    return dense_factor(solver.dense, solver.pivots, solver.scale, DENSE_TOLERANCE)


@inner
def apply_inverse(solver, vector):
    """Solve with the present factors, in place; vector (n,)."""
    if solver.mode[0] == 0:
        solve(solver.plan, solver.lu, vector, solver.work)
    else:
        dense_solve(solver.dense, solver.pivots, vector)


@inner
def apply_inverse_block(solver, block):
    """Solve for many right-hand sides, in place; block (n, n_x filled up)."""
    if solver.mode[0] == 0:
        solve_block(solver.plan, solver.lu, block, solver.work_block)
    else:
        dense_solve_block(solver.dense, solver.pivots, block)


@inner
def refine(solver, indptr, indices, values, rhs, solution):
    """Make one step of iterative refinement; returns whether it changed so little that the factors can be trusted.

    Compared by coordinates alone, in units of the model size: multipliers follow from them. (A comparison row by row fails where
    all terms of a row are zero but for round-off.)
    """
    multiply(indptr, indices, values, solution, solver.residual)
    for i in range(len(rhs)):
        solver.residual[i] = rhs[i] - solver.residual[i]
    apply_inverse(solver, solver.residual)
    size, change = 0.0, 0.0
    for i in range(len(rhs)):
        solution[i] += solver.residual[i]
        if i < len(solver.weights):
            size = max(size, solver.weights[i] * abs(solution[i].real))
            change = max(change, solver.weights[i] * abs(solver.residual[i].real))
    solver.quality[0] = change / size if size > 0 else 1.0
    return change <= TRUSTED_REFINEMENT * size


@inner
def solve_checked(solver, indptr, indices, values, rhs, solution):
    """Solve and refine, twice if that mends it; with pivoting if the factors are bad; as `factorize`, -1 or the unknown."""
    copy(rhs, solution)
    apply_inverse(solver, solution)
    if refine(solver, indptr, indices, values, rhs, solution) or solver.mode[0] == 1:
        return -1
    first = solver.quality[0]
    if first <= MENDED:
        refine(solver, indptr, indices, values, rhs, solution)
        solver.quality[0] = first
        return -1
    failed = factorize_dense(solver, indptr, indices, values)
    copy(rhs, solution)
    apply_inverse(solver, solution)
    refine(solver, indptr, indices, values, rhs, solution)
    return failed


@inner
def solve_refined_block(solver, indptr, indices, values, factored, factor, fresh, block, solution):
    """Solve for many right-hand sides, refined as often as the factors need it; block and solution (n, n_x), or filled up.

    The matrix is that of `values`, to which `factor` times a `factored` one is added unless it is None. `fresh`: the factors are those
    of this matrix, and the last refinement of a vector tells how good they are.
    """
    found, rest = solver.solution_block, solver.residual_block
    copy_columns(block, found)
    apply_inverse_block(solver, found)
    times = 0 if fresh and solver.quality[0] <= UNREFINED else 1
    if solver.mode[0] == 0 and solver.quality[0] > TRUSTED_REFINEMENT:
        times = 2
    for _ in range(times):
        copy_columns(block, rest)
        for i in range(len(rest)):
            add_rows(rest[i], 1.0, -1.0, values, indices, indptr[i], indptr[i + 1], found)
        if factored is not None:
            add_factored_block(factored, -factor, found, solver.work_block, rest)
        apply_inverse_block(solver, rest)
        for i in range(len(rest)):
            for x in range(found.shape[1]):
                found[i, x] += rest[i, x]
    copy_columns(found, solution)


@inner
def copy_columns(block, target):
    """Copy as many columns of a block to a target as both have."""
    columns = min(block.shape[1], target.shape[1])
    for i in range(len(block)):
        source, row = block[i], target[i]
        for x in range(columns):
            row[x] = source[x]


@kernel
def solve_once(solver, indptr, indices, values, vector, solution, block, out):
    """Factor, solve for the first column (vector) with all checks, then for the block; -1, or the unknown as `factorize`."""
    failed = factorize(solver, indptr, indices, values)
    if failed < 0:
        failed = solve_checked(solver, indptr, indices, values, vector, solution)
    if failed < 0:
        solve_refined_block(solver, indptr, indices, values, None, 0.0, False, block, out)
    return failed
