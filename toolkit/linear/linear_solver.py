"""The linear solver of the step loop: static sparse factors first, dense ones with pivoting where those are not good enough.

Dense LU with partial pivoting: what the step loop falls back to when the fixed order of `sparse_lu` meets a bad pivot.

Which row holds the largest entry of a column depends on the units of the rows, so pivots are compared as if the matrix had been
equilibrated, every row and column with a largest entry of 1. The factors themselves stay in the units of the matrix.

A symmetric matrix K = B^T D B in its factors: what stiffness is before rounding mixes stretching with bending.

The rows of B are strains, small differences of coordinates. Summed as they are, B^T (D (B x)) has the round-off of these differences;
the products of K's own entries, which a skin of n elements makes n^4 times larger than their sum, have that of the products.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from toolkit.foundation.compiled.rows import add_rows, filled_up
from toolkit.foundation.kernel import copy, inner, kernel
from toolkit.linear.sparse_analysis import LUPlan
from toolkit.linear.sparse_lu import StillPivots, factor, multiply, solve, still_pivots

SCALING_SWEEPS = 5
"""Each sweep takes the square root of what the largest entries differ from 1: five leave a factor 4 of 1e18."""


@kernel
def to_dense(indptr, indices, values, a):
    """CSR values as a dense matrix a (n, n), overwritten."""
    n = a.shape[0]
    for i in range(n):
        for j in range(n):
            a[i, j] = 0.0
        for p in range(indptr[i], indptr[i + 1]):
            a[i, indices[p]] = values[p]


@kernel
def dense_factor(a, pivots, scale, tolerance):
    """Factors of a matrix in its place; -1, or the index of the first unknown that the equations do not determine.

    Parameters
    ----------
    a : (n, n), C-contiguous
        Matrix; becomes L without its unit diagonal, the inverse pivots, and U.
    pivots : (n,) ints
        Overwritten: the row exchanged with row k at step k.
    scale : (3, n) floats
        Overwritten: row scales, column scales, work space. Real even if `a` is complex, as scales only decide.
    tolerance : float
        Smallest pivot of the equilibrated matrix; 1e-14 refuses only what is singular to rounding.
    """
    n = a.shape[0]
    equilibrate(a, scale)
    for k in range(n):
        row = _largest_row(a, scale, k)
        if not abs(a[row, k].real) * scale[0, row] * scale[1, k] > tolerance:  # also true of a NaN
            return k
        pivots[k] = row
        scale[0, row], scale[0, k] = scale[0, k], scale[0, row]
        if row != k:
            for j in range(n):
                a[row, j], a[k, j] = a[k, j], a[row, j]
        a[k, k] = 1.0 / a[k, k]
        source = a[k, k + 1 :]
        for i in range(k + 1, n):
            if a[i, k] == 0.0:  # most of a matrix of bodies and joints
                continue
            multiple = a[i, k] * a[k, k]
            a[i, k] = multiple
            target = a[i, k + 1 :]
            for j in range(n - k - 1):
                target[j] -= multiple * source[j]
    return -1


@kernel
def equilibrate(a, scale):
    """Row and column scales r, c for which all rows and columns of r_i |a_ij| c_j have largest entries near 1 (Ruiz 2001)."""
    n = a.shape[0]
    row_scale, column_scale, column_largest = scale[0], scale[1], scale[2]
    row_scale[:] = 1.0
    column_scale[:] = 1.0
    for _ in range(SCALING_SWEEPS):
        column_largest[:] = 0.0
        for i in range(n):
            largest = 0.0
            for j in range(n):
                if a[i, j] == 0.0:
                    continue
                size = abs(a[i, j].real) * row_scale[i] * column_scale[j]
                largest = max(largest, size)
                column_largest[j] = max(column_largest[j], size)
            if largest > 0.0:
                row_scale[i] /= np.sqrt(largest)
        for j in range(n):
            if column_largest[j] > 0.0:
                column_scale[j] /= np.sqrt(column_largest[j])


@inner
def _largest_row(a, scale, k):
    """Row at or below k with the largest equilibrated entry in column k."""
    row = k
    for i in range(k + 1, a.shape[0]):
        if abs(a[i, k].real) * scale[0, i] > abs(a[row, k].real) * scale[0, row]:
            row = i
    return row


@kernel
def dense_solve(a, pivots, rhs):
    """Solution of A x = rhs from the factors, in place; rhs (n,)."""
    n = rhs.size
    for k in range(n):
        rhs[k], rhs[pivots[k]] = rhs[pivots[k]], rhs[k]
    for i in range(n):
        total = rhs[i]
        for j in range(i):
            total -= a[i, j] * rhs[j]
        rhs[i] = total
    for i in range(n - 1, -1, -1):
        total = rhs[i]
        for j in range(i + 1, n):
            total -= a[i, j] * rhs[j]
        rhs[i] = total * a[i, i]


@kernel
def dense_solve_block(a, pivots, rhs):
    """Solution of A X = rhs from the factors, in place; rhs (n, n_x), the design axis contiguous."""
    n, n_x = rhs.shape
    for k in range(n):
        for x in range(n_x):
            rhs[k, x], rhs[pivots[k], x] = rhs[pivots[k], x], rhs[k, x]
    for i in range(n):
        for j in range(i):
            for x in range(n_x):
                rhs[i, x] -= a[i, j] * rhs[j, x]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            for x in range(n_x):
                rhs[i, x] -= a[i, j] * rhs[j, x]
        for x in range(n_x):
            rhs[i, x] *= a[i, i]


class Factored(NamedTuple):
    """A symmetric matrix K = B^T D B: rows of B, compressed, the diagonal of D, and columns of B, compressed."""

    start: np.ndarray  # (n_rows + 1,) into the next two
    column: np.ndarray
    value: np.ndarray
    weight: np.ndarray  # (n_rows,)
    felt: np.ndarray  # numbers of the columns that are not empty
    felt_start: np.ndarray  # (n_felt + 1,) into the next two
    felt_row: np.ndarray
    felt_value: np.ndarray


def strain_rows(matrix: Factored, count: int) -> scipy.sparse.csr_array:
    """Matrix B on so many coordinates, (n_rows, count)."""
    return scipy.sparse.csr_array((matrix.value, matrix.column.astype(int), matrix.start), shape=(len(matrix.weight), count))


class FactoredChanges(NamedTuple):
    """Derivatives of rows and weights by the design, apart from rows that a variable does not change."""

    row: np.ndarray  # (n_d,)
    variable: np.ndarray
    start: np.ndarray  # (n_d + 1,) into `value`
    value: np.ndarray  # of the row's entries, in their order
    weight: np.ndarray  # (n_d,)


@inner
def row_times(matrix, row, x):
    """Entry number `row` of the product B x."""
    total = 0.0 * x[0]
    for p in range(matrix.start[row], matrix.start[row + 1]):
        total += matrix.value[p] * x[matrix.column[p]]
    return total


@inner
def add_factored(matrix, x, out):
    """Add K x to a vector: out += K x."""
    for row in range(len(matrix.weight)):
        force = matrix.weight[row] * row_times(matrix, row, x)
        for p in range(matrix.start[row], matrix.start[row + 1]):
            out[matrix.column[p]] += matrix.value[p] * force


@inner
def add_factored_block(matrix, factor, block, scratch, out):
    """out += factor K block; blocks and scratch memory (n, w), filled up as `add_rows` needs them, in which the forces find place."""
    for row in range(len(matrix.weight)):
        force = scratch[row]
        force[:] = 0.0
        add_rows(force, matrix.weight[row], 1.0, matrix.value, matrix.column, matrix.start[row], matrix.start[row + 1], block)
    for k in range(len(matrix.felt)):
        first, last = matrix.felt_start[k], matrix.felt_start[k + 1]
        add_rows(out[matrix.felt[k]], 1.0, factor, matrix.felt_value, matrix.felt_row, first, last, scratch)


@inner
def add_factored_changes(matrix, changes, x, out):
    """Add the change of K by every variable, times x, to out (n, n_x)."""
    for d in range(len(changes.row)):
        row, variable, at = changes.row[d], changes.variable[d], changes.start[d] - matrix.start[changes.row[d]]
        strain, change = row_times(matrix, row, x), 0.0 * x[0]
        for p in range(matrix.start[row], matrix.start[row + 1]):
            change += changes.value[at + p] * x[matrix.column[p]]
        force = matrix.weight[row] * strain
        change = changes.weight[d] * strain + matrix.weight[row] * change
        for p in range(matrix.start[row], matrix.start[row + 1]):
            out[matrix.column[p], variable] += matrix.value[p] * change + changes.value[at + p] * force


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
ONE_REFINEMENT_ENOUGH, TWO_REFINEMENTS_ENOUGH = 1e-6, 1e-4
"""Refinement of a solution, relative to it, above which one is not enough, as the square of that is left after it; and above which two are
not, so that sparse factors are given up. Light rods that hold a stiff part of a skin leave 1e-6 to 1e-5."""

NO_REFINEMENT_NEEDED = 1e-12
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
        np.full(1, ONE_REFINEMENT_ENOUGH),
        updates_of(plan),
    )


def cleared(solver: LinearSolver, weights: np.ndarray) -> None:
    """Clear used memory to what `linear_solver` reserves; `weights` are copied."""
    for memory in (solver.lu, *solver.kept, solver.work, solver.residual, solver.pivots, solver.scale, solver.mode):
        memory.fill(0)
    for block in (solver.work_block, solver.residual_block, solver.solution_block):
        block.fill(0)
    solver.quality.fill(ONE_REFINEMENT_ENOUGH)
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
    return change <= ONE_REFINEMENT_ENOUGH * size


@inner
def solve_checked(solver, indptr, indices, values, rhs, solution):
    """Solve and refine, twice if that mends it; with pivoting if the factors are bad; as `factorize`, -1 or the unknown."""
    copy(rhs, solution)
    apply_inverse(solver, solution)
    if refine(solver, indptr, indices, values, rhs, solution) or solver.mode[0] == 1:
        return -1
    first = solver.quality[0]
    if first <= TWO_REFINEMENTS_ENOUGH:
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
    times = 0 if fresh and solver.quality[0] <= NO_REFINEMENT_NEEDED else 1
    if solver.mode[0] == 0 and solver.quality[0] > ONE_REFINEMENT_ENOUGH:
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
