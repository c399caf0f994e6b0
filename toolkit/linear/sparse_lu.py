"""Sparse LU without pivoting on a pattern that is analysed once per model: the linear solver of the step loop.

The matrix has saddle-point form, coordinates first, multipliers last,

    [ M  G ] [ dq   ]   [ r_q   ]        M "mass-like", nonsingular
    [ J  0 ] [ dlam ] = [ r_lam ]        G has the pattern of J^T

with unsymmetric values on a symmetric pattern. A multiplier is eliminated only after all coordinates it couples to, a joint after
the bodies it ties. Every leading block of the permuted matrix is then a saddle-point matrix with complete constraint rows:
nonsingular if M + M^T is definite, G = J^T and no constraint is redundant, so that no zero pivot is met.

Pivot test. A pivot is `p_i = a_ii - sum_k l_ik u_ki`, and rounding leaves in it an error of about eps times

    size_i = |a_ii| + sum_k |l_ik u_ki|

so it is refused unless |p_i| > tolerance * size_i; with tolerance = 1e-12 about four of its digits survive. All terms carry the
units of row i times those of column i, hence no scaling of rows or columns changes the test. Neither does scaling change the
rounding of an elimination without pivoting, so nothing is equilibrated. (A comparison with the largest entry of the row would
refuse a mass of 1e-9 beside a constraint entry of 1.) What the test cannot see is growth: a tiny but honest pivot that swamps
a later row. For that the caller asks `backward_error`, just as free of units, then refines or falls back to `dense_lu`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.errors import InputError
from toolkit.kernel import inner, kernel

SHORTEST_RUN = 4
"""Length from which a run of neighbouring entries is updated as a slice, not entry by entry (measured on a beam)."""


class LUPlan(NamedTuple):
    """Where every entry goes; integer arrays only. "Position" is the place of an unknown in the order of elimination.

    L (its unit diagonal is not stored), the inverse pivots and U share one array `lu` in rows of the permuted matrix. Index lists
    are unsigned because numba then skips the test for indices counted from the end, a quarter of the time.
    """

    order: np.ndarray  # (n,) original index of the unknown at each position
    row_start: np.ndarray  # (n + 1,) rows of `lu`; the last entry is the length of `lu`
    diagonal: np.ndarray  # (n,) place of the inverse pivot in `lu`: L to its left, U to its right
    column: np.ndarray  # (n_lu,) position of the column of each entry of `lu`, ascending in each row
    mirror: np.ndarray  # (n_lu,) place in `lu` of the transposed entry
    place: np.ndarray  # (nnz,) place in `lu` of each CSR value
    run: np.ndarray  # (n,) how many entries of U right behind the diagonal have adjacent columns, 0 if too few
    destination: np.ndarray  # place in `lu` that each update hits, in the order of `factor`; of a run only the first


def analyse(indptr: np.ndarray, indices: np.ndarray, n_q: int) -> LUPlan:
    """Order of elimination, fill and list of updates for a pattern; once per model.

    Parameters
    ----------
    indptr, indices : (n + 1,), (nnz,) ints
        CSR pattern: symmetric, sorted, with a full diagonal (also where the value is zero, at the multipliers).
    n_q : int
        Number of coordinates; the unknowns after them are multipliers.

    Raises
    ------
    InputError
        If the pattern is not symmetric, not sorted, or lacks a diagonal entry.
    """
    indptr, indices = np.asarray(indptr, dtype=np.int64), np.asarray(indices, dtype=np.int64)
    connected = _adjacency(indptr, indices)
    order, below = _minimum_degree(connected, n_q)
    position = np.empty_like(order)
    position[order] = np.arange(len(order))
    row_of_value = np.repeat(position, np.diff(indptr))
    return _plan(order, [np.sort(position[neighbours]) for neighbours in below], row_of_value, position[indices])


def _adjacency(indptr: np.ndarray, indices: np.ndarray) -> np.ndarray:
    """Checked pattern as a boolean matrix (n, n)."""
    n = len(indptr) - 1
    row = np.repeat(np.arange(n), np.diff(indptr))
    if np.any((np.diff(indices) <= 0) & (np.diff(row) == 0)):
        raise InputError("the column indices of a sparse row do not ascend; sort them and add up duplicates before the analysis.")
    connected = np.zeros((n, n), dtype=bool)
    connected[row, indices] = True
    missing = np.flatnonzero(~connected.diagonal())
    if missing.size:
        raise InputError(f"row {missing[0]} of the pattern has no diagonal entry; add it, with value 0 for a multiplier.")
    lonely = np.argwhere(connected & ~connected.T)
    if lonely.size:
        i, j = lonely[0]
        raise InputError(f"the pattern has the entry ({i}, {j}) but not ({j}, {i}); add it with value 0.")
    return connected


def _minimum_degree(connected: np.ndarray, n_q: int) -> tuple[np.ndarray, list[np.ndarray]]:
    """Order by smallest degree, and for each pivot the later unknowns that it couples to.

    Eliminating an unknown connects all its neighbours with each other. A multiplier waits until its last coordinate is gone.
    Ties go to the lower index, which keeps a band a band and a body together.
    """
    n = len(connected)
    ties = connected[:n_q, n_q:]
    fill = connected & ~np.eye(n, dtype=bool)
    degree = fill.sum(axis=1)
    waits_for = np.concatenate([np.zeros(n_q, dtype=np.int64), ties.sum(axis=0)])
    key = np.where(waits_for > 0, 2 * n, degree)
    order, below = [], []
    for _ in range(n):
        pivot = int(np.argmin(key))
        neighbours = np.flatnonzero(fill[pivot])
        fill[neighbours, pivot] = False
        clique = np.ix_(neighbours, neighbours)
        degree[neighbours] += len(neighbours) - 2 - fill[clique].sum(axis=1)
        fill[clique] = True
        fill[neighbours, neighbours] = False
        if pivot < n_q:
            waits_for[n_q:] -= ties[pivot]
        key[neighbours] = np.where(waits_for[neighbours] > 0, 2 * n, degree[neighbours])
        key[pivot] = 3 * n
        order.append(pivot)
        below.append(neighbours)
    return np.array(order, dtype=np.int64), below


def _plan(order: np.ndarray, upper: list[np.ndarray], value_row: np.ndarray, value_column: np.ndarray) -> LUPlan:
    """Storage of L + U and its updates, from the columns of each row of U and the place of each CSR value (all as positions)."""
    n = len(order)
    pivot = np.arange(n)
    row, column = np.repeat(pivot, [len(u) for u in upper]), np.concatenate([*upper, pivot[:0]])
    entry = np.sort(np.concatenate([row * n + column, column * n + row, pivot * n + pivot]))  # row * n + column, ascending
    row, column = np.divmod(entry, max(n, 1))
    run = np.array([_run_length(k, upper[k]) for k in range(n)], dtype=np.int64)
    updated = [np.add.outer(u * n, _first_of_run(u, length)).ravel() for u, length in zip(upper, run, strict=True)]
    return LUPlan(
        order=order,
        row_start=np.searchsorted(row, np.arange(n + 1)),
        diagonal=np.searchsorted(entry, pivot * n + pivot),
        column=column.astype(np.uint32),
        mirror=np.searchsorted(entry, column * n + row).astype(np.uint32),
        place=np.searchsorted(entry, value_row * n + value_column).astype(np.uint32),
        run=run,
        destination=np.searchsorted(entry, np.concatenate([*updated, pivot[:0]])).astype(np.uint32),
    )


def _run_length(pivot: int, columns: np.ndarray) -> int:
    adjacent = int(np.count_nonzero(columns == pivot + 1 + np.arange(len(columns))))
    return adjacent if adjacent >= SHORTEST_RUN else 0


def _first_of_run(columns: np.ndarray, run: int) -> np.ndarray:
    return np.delete(columns, np.s_[1:run])


@kernel
def factor(plan, values, lu, work, tolerance):
    """Factors of a matrix; -1, or the original index of the first unknown whose pivot is refused.

    Parameters
    ----------
    plan : LUPlan
    values : (nnz,)
        CSR values on the analysed pattern.
    lu : (plan.row_start[-1],)
        Overwritten with the factors.
    work : (n,)
        Overwritten with size_i.
    tolerance : float
        Smallest pivot relative to the terms it is made of, see the head of this file.
    """
    _load(plan, values, lu, work)
    update = 0
    for k in range(plan.order.size):
        diagonal, end, run = plan.diagonal[k], plan.row_start[k + 1], plan.run[k]
        if not abs(lu[diagonal].real) > tolerance * work[k].real:  # also true of a NaN; real parts, as they only decide
            return plan.order[k]
        lu[diagonal] = 1.0 / lu[diagonal]
        for p in range(diagonal + 1, end):
            multiple = lu[plan.mirror[p]] * lu[diagonal]
            lu[plan.mirror[p]] = multiple
            work[plan.column[p]] += abs((multiple * lu[p]).real)
            if run > 0:
                first = plan.destination[update]
                update += 1
                target, source = lu[first : first + run], lu[diagonal + 1 : diagonal + 1 + run]
                for s in range(run):
                    target[s] -= multiple * source[s]
            for s in range(diagonal + 1 + run, end):
                lu[plan.destination[update]] -= multiple * lu[s]
                update += 1
    return -1


@inner
def _load(plan, values, lu, size):
    """Matrix entries into `lu`, zero at the fill, and the first term of `size`."""
    for p in range(lu.size):
        lu[p] = 0.0
    for p in range(values.size):
        lu[plan.place[p]] = values[p]
    for k in range(size.size):
        size[k] = abs(lu[plan.diagonal[k]].real)


@kernel
def solve(plan, lu, rhs, work):
    """Solution of A x = rhs, in place; rhs and work (n,)."""
    n = plan.order.size
    for i in range(n):
        total = rhs[plan.order[i]]
        for p in range(plan.row_start[i], plan.diagonal[i]):
            total -= lu[p] * work[plan.column[p]]
        work[i] = total
    for i in range(n - 1, -1, -1):
        total = work[i]
        for p in range(plan.diagonal[i] + 1, plan.row_start[i + 1]):
            total -= lu[p] * work[plan.column[p]]
        work[i] = total * lu[plan.diagonal[i]]
        rhs[plan.order[i]] = work[i]


@kernel
def solve_block(plan, lu, rhs, work):
    """Solution of A X = rhs, in place; rhs and work (n, n_x), the design axis contiguous."""
    n_x = rhs.shape[1]
    for x in range(0, n_x - 3, 4):
        _solve_four(plan, lu, rhs[:, x : x + 4], work[:, x : x + 4])
    for x in range(n_x - n_x % 4, n_x):
        solve(plan, lu, rhs[:, x], work[:, x])


@inner
def _solve_four(plan, lu, rhs, work):
    """As `solve`, four columns at once: their sums stay in registers, and every factor is read once for all four."""
    n = plan.order.size
    for i in range(n):
        x = plan.order[i]
        a, b, c, d = rhs[x, 0], rhs[x, 1], rhs[x, 2], rhs[x, 3]
        for p in range(plan.row_start[i], plan.diagonal[i]):
            entry, k = lu[p], plan.column[p]
            a -= entry * work[k, 0]
            b -= entry * work[k, 1]
            c -= entry * work[k, 2]
            d -= entry * work[k, 3]
        work[i, 0], work[i, 1], work[i, 2], work[i, 3] = a, b, c, d
    for i in range(n - 1, -1, -1):
        a, b, c, d = work[i, 0], work[i, 1], work[i, 2], work[i, 3]
        for p in range(plan.diagonal[i] + 1, plan.row_start[i + 1]):
            entry, k = lu[p], plan.column[p]
            a -= entry * work[k, 0]
            b -= entry * work[k, 1]
            c -= entry * work[k, 2]
            d -= entry * work[k, 3]
        inverse, x = lu[plan.diagonal[i]], plan.order[i]
        a, b, c, d = a * inverse, b * inverse, c * inverse, d * inverse
        work[i, 0], work[i, 1], work[i, 2], work[i, 3] = a, b, c, d
        rhs[x, 0], rhs[x, 1], rhs[x, 2], rhs[x, 3] = a, b, c, d


@kernel
def multiply(indptr, indices, values, x, y):
    """y = A x for a CSR matrix; x and y (n,)."""
    for i in range(y.size):
        total = 0.0 * x[0]
        for p in range(indptr[i], indptr[i + 1]):
            total += values[p] * x[indices[p]]
        y[i] = total


@kernel
def backward_error(indptr, indices, values, x, rhs):
    """How far x is from solving A x = rhs: the largest |rhs - A x|_i / (|A| |x| + |rhs|)_i, by real parts.

    The smallest relative change of the entries of A and rhs for which x is exact (Oettli and Prager 1964): near eps for a good
    solution, and the same in all units of rows and columns.
    """
    largest = 0.0
    for i in range(rhs.size):
        residual, size = rhs[i].real, abs(rhs[i].real)
        for p in range(indptr[i], indptr[i + 1]):
            term = values[p].real * x[indices[p]].real
            residual -= term
            size += abs(term)
        if not size < np.inf:  # also true of a NaN
            return np.inf
        if abs(residual) > largest * size:
            largest = abs(residual) / size
    return largest
