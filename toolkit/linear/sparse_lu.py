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
refuse a mass of 1e-9 beside a constraint entry of 1.) What the test cannot see is growth: a tiny but honest pivot that swamps a
later row. For that the caller refines a solution once and looks how much that changes (`linear_solver`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.foundation.compiled.rows import subtract_multiples
from toolkit.foundation.kernel import inlined, inner, kernel
from toolkit.linear.sparse_analysis import PIVOTS_AT_ONCE, LUPlan


class StillPivots(NamedTuple):
    """Rows that the pivots which never change have left to the later ones.

    So they are eliminated once for many matrices.
    """

    made: np.ndarray  # (1,) 1 once they have been eliminated
    values: np.ndarray  # of `plan.still_value`, which they belong to
    lu: np.ndarray  # the rows of the later pivots, without values of their own
    size: np.ndarray  # (n - still,) what is known of size_i


def still_pivots(plan: LUPlan, dtype: type) -> StillPivots:
    """Memory for the `StillPivots` of a plan."""
    later = len(plan.own_value)
    rows = int(plan.row_start[-1] - plan.row_start[len(plan.order) - later]) if plan.still[0] else 0
    return StillPivots(
        np.zeros(1, np.int64), np.zeros(len(plan.still_value), dtype), np.zeros(rows, dtype), np.zeros(later, dtype)
    )


@kernel
def factor(plan, values, lu, work, tolerance, kept):
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
    kept : StillPivots
        Of the last matrix, whose factors `lu` holds; overwritten.
    """
    still = plan.still[0]
    nothing = np.int64(0)  # a plain 0 would have what is called compiled for that number, and for others again
    if still == 0:
        _load(plan, values, lu, work)
        return _eliminate(plan, lu, work, tolerance, nothing, plan.order.size, nothing, nothing)
    if not _unchanged(plan, values, kept):
        kept.made[0] = 0
        _load_still(plan, values, lu, work)
        refused = _eliminate(plan, lu, work, tolerance, nothing, still, nothing, nothing)
        if refused >= 0:
            return refused
        _keep(plan, values, lu, work, kept)
    _load_later(plan, values, lu, work, kept)
    return _eliminate(plan, lu, work, tolerance, still, plan.order.size, plan.still[1], plan.still[2])


@inlined
def _unchanged(plan, values, kept):
    """Whether the first pivots meet the same values as last time."""
    changed = kept.made[0] == 0
    for p in range(plan.still_value.size):
        changed |= values[plan.still_value[p]] != kept.values[p]
    return not changed


@inlined
def _load_still(plan, values, lu, work):
    """Load the values of the first pivots into `lu`, and the first term of their `size`.

    This is `_load` without the values of the later pivots.
    """
    for p in range(lu.size):
        lu[p] = 0.0
    for p in range(plan.still_value.size):
        lu[plan.place[plan.still_value[p]]] = values[plan.still_value[p]]
    for k in range(work.size):
        work[k] = abs(lu[plan.diagonal[k]].real)


@inlined
def _keep(plan, values, lu, work, kept):
    """Keep what the first pivots have left."""
    first, still = plan.row_start[plan.still[0]], plan.still[0]
    for p in range(kept.lu.size):
        kept.lu[p] = lu[first + p]
    for k in range(kept.size.size):
        kept.size[k] = work[still + k]
    for p in range(kept.values.size):
        kept.values[p] = values[plan.still_value[p]]
    kept.made[0] = 1


@inlined
def _load_later(plan, values, lu, work, kept):
    """Load the rows of the later pivots: what the first ones have left, and their own values."""
    first, still = plan.row_start[plan.still[0]], plan.still[0]
    for p in range(kept.lu.size):
        lu[first + p] = kept.lu[p]
    for p in range(plan.later_value.size):
        lu[plan.place[plan.later_value[p]]] += values[plan.later_value[p]]
    for k in range(kept.size.size):
        work[still + k] = kept.size[k] + abs(values[plan.own_value[k]].real)


@inner
def _eliminate(plan, lu, work, tolerance, first, last, update, run):
    """Eliminate pivots first ... last - 1, before which others have used so many updates and runs; as `factor`."""
    k = first
    while k < last:
        if plan.together[k] > 0:
            refused = _factor_together(plan, lu, work, tolerance, k)
            if refused >= 0:
                return plan.order[refused]
            _eliminate_together(plan, lu, work, k, update, run)
            end = plan.diagonal[k + PIVOTS_AT_ONCE - 1]
            update += plan.together[k] * (plan.row_start[k + PIVOTS_AT_ONCE] - end - 1)
            run += plan.together[k]
            k += PIVOTS_AT_ONCE
            continue
        diagonal, end, length = plan.diagonal[k], plan.row_start[k + 1], plan.run[k]
        if not abs(lu[diagonal].real) > tolerance * work[k].real:  # also true of a NaN; real parts, as they only decide
            return plan.order[k]
        lu[diagonal] = 1.0 / lu[diagonal]
        for p in range(diagonal + 1, end):
            multiple = lu[plan.mirror[p]] * lu[diagonal]
            lu[plan.mirror[p]] = multiple
            work[plan.column[p]] += abs((multiple * lu[p]).real)
            if length > 0:
                subtract_multiples(lu, (plan.destination[update],), (multiple,), (diagonal + 1,), length)
                update += 1
            for s in range(diagonal + 1 + length, end):
                lu[plan.destination[update]] -= multiple * lu[s]
                update += 1
        k += 1
    return -1


@inlined
def _factor_together(plan, lu, work, tolerance, first):
    """Factor the rows of PIVOTS_AT_ONCE pivots, whose columns are the same; -1, or the pivot that is refused."""
    for k in range(first, first + PIVOTS_AT_ONCE):
        diagonal = plan.diagonal[k]
        if not abs(lu[diagonal].real) > tolerance * work[k].real:
            return k
        lu[diagonal] = 1.0 / lu[diagonal]
        for row in range(k + 1, first + PIVOTS_AT_ONCE):
            at = plan.diagonal[row] - (row - k)
            multiple = lu[at] * lu[diagonal]
            lu[at] = multiple
            work[row] += abs((multiple * lu[diagonal + row - k]).real)
            subtract_multiples(lu, (at + 1,), (multiple,), (diagonal + 1,), plan.row_start[k + 1] - diagonal - 1)
    return -1


@inlined
def _eliminate_together(plan, lu, work, first, update, run):
    """Update all later rows by PIVOTS_AT_ONCE pivots, two rows at a time.

    `update` and `run` count what the pivots before them have used.
    """
    a, b, c, d = plan.diagonal[first], plan.diagonal[first + 1], plan.diagonal[first + 2], plan.diagonal[first + 3]
    behind, count = plan.row_start[first + 4] - d - 1, plan.together[first]
    row_a, row_b, row_c, row_d = lu[a + 4 :], lu[b + 3 :], lu[c + 2 :], lu[d + 1 :]
    mirror, column = plan.mirror[a + 4 : a + 4 + behind], plan.column[a + 4 : a + 4 + behind]
    run_first, run_length = plan.run_first[run : run + count], plan.run_length[run : run + count]
    destination = plan.destination[update : update + count * behind]
    p_a, p_b, p_c, p_d = lu[a], lu[b], lu[c], lu[d]
    ab, ac, ad, bc, bd, cd = lu[a + 1], lu[a + 2], lu[a + 3], lu[b + 1], lu[b + 2], lu[c + 1]
    for r in range(behind):
        left = lu[mirror[r] : mirror[r] + 4]
        m_a = left[0] * p_a
        m_b = (left[1] - m_a * ab) * p_b
        m_c = (left[2] - m_a * ac - m_b * bc) * p_c
        m_d = (left[3] - m_a * ad - m_b * bd - m_c * cd) * p_d
        left[0], left[1], left[2], left[3] = m_a, m_b, m_c, m_d
        size = abs((m_a * row_a[r]).real) + abs((m_b * row_b[r]).real) + abs((m_c * row_c[r]).real) + abs((m_d * row_d[r]).real)
        work[column[r]] += size
    at, r = 0, 0
    while r < behind:
        two = r + 2 <= behind
        left, other = lu[mirror[r] : mirror[r] + 4], lu[mirror[r + two] : mirror[r + two] + 4]
        m = left[0], left[1], left[2], left[3]
        both = left[0], left[1], left[2], left[3], other[0], other[1], other[2], other[3]
        for k in range(count):
            start, target = run_first[k], destination[at + k]
            sources = a + 4 + start, b + 3 + start, c + 2 + start, d + 1 + start
            if two:
                subtract_multiples(lu, (target, destination[at + count + k]), both, sources, run_length[k])
            else:
                subtract_multiples(lu, (target,), m, sources, run_length[k])
        at += (1 + two) * count
        r += 1 + two


@inner
def _load(plan, values, lu, size):
    """Load matrix entries into `lu`, zero at the fill, and the first term of `size`."""
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
        work[i] = rhs[plan.order[i]] - row_product(lu, plan.column, plan.row_start[i], plan.diagonal[i], work)
    for i in range(n - 1, -1, -1):
        known = row_product(lu, plan.column, plan.diagonal[i] + 1, plan.row_start[i + 1], work)
        work[i] = (work[i] - known) * lu[plan.diagonal[i]]
        rhs[plan.order[i]] = work[i]


@inlined
def row_product(values, columns, first, last, x):
    """Sum of values[p] x[columns[p]] over p = first ... last - 1, in four sums, none of which waits for another."""
    a = b = c = d = 0.0 * values[0]
    p = first
    while p + 4 <= last:
        a += values[p] * x[columns[p]]
        b += values[p + 1] * x[columns[p + 1]]
        c += values[p + 2] * x[columns[p + 2]]
        d += values[p + 3] * x[columns[p + 3]]
        p += 4
    while p < last:
        a += values[p] * x[columns[p]]
        p += 1
    return (a + b) + (c + d)


@kernel
def multiply(indptr, indices, values, x, y):
    """y = A x for a CSR matrix; x and y (n,)."""
    for i in range(y.size):
        y[i] = row_product(values, indices, indptr[i], indptr[i + 1], x)
