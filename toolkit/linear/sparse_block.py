"""Solutions for many right-hand sides from the factors of `sparse_lu`."""

from __future__ import annotations

import numpy as np

from toolkit.foundation.kernel import inner, kernel
from toolkit.linear.sparse_lu import solve

WIDE = 16
"""Most columns that are solved for by eight; of more whole rows of a block are subtracted at once."""
AT_ONCE = 8
"""Columns that the work of `solve_block` needs at least."""


@kernel
def solve_block(plan, lu, rhs, work):
    """Solution of A X = rhs, in place; rhs (n, n_x) and work (n, n_x or AT_ONCE), the design axis contiguous."""
    n_x, first = rhs.shape[1], np.int64(0)  # as in `sparse_lu.factor`
    if n_x == 1:
        solve(plan, lu, rhs[:, 0], work[:, 0])
    elif n_x > WIDE:
        _solve_rows(plan, lu, rhs, work)
    else:
        while n_x - first > 4:
            _solve_eight(plan, lu, rhs, work, first)
            first += AT_ONCE
        if first < n_x:
            _solve_four(plan, lu, rhs, work, first)


@inner
def _solve_rows(plan, lu, rhs, work):
    """As `solve`, all columns at once: every factor is read once, and times a row of the work subtracted from another one."""
    n, n_x = plan.order.size, rhs.shape[1]
    for i in range(n):
        given, row = rhs[plan.order[i]], work[i]
        for x in range(n_x):
            row[x] = given[x]
        for p in range(plan.row_start[i], plan.diagonal[i]):
            entry, known = lu[p], work[plan.column[p]]
            for x in range(n_x):
                row[x] -= entry * known[x]
    for i in range(n - 1, -1, -1):
        found, row = rhs[plan.order[i]], work[i]
        for p in range(plan.diagonal[i] + 1, plan.row_start[i + 1]):
            entry, known = lu[p], work[plan.column[p]]
            for x in range(n_x):
                row[x] -= entry * known[x]
        inverse = lu[plan.diagonal[i]]
        for x in range(n_x):
            row[x] *= inverse
            found[x] = row[x]


@inner
def _solve_four(plan, lu, rhs, work, first):
    """As `solve`, four columns at once from the first on: their sums stay in registers, and every factor is read once for all.

    Where there are fewer, the last one is solved for several times.
    """
    n, last = plan.order.size, rhs.shape[1] - 1
    c_a, c_b, c_c, c_d = first, min(first + 1, last), min(first + 2, last), min(first + 3, last)
    for i in range(n):
        given = rhs[plan.order[i]]
        a, b, c, d = given[c_a], given[c_b], given[c_c], given[c_d]
        for p in range(plan.row_start[i], plan.diagonal[i]):
            entry, known = lu[p], work[plan.column[p]]
            a -= entry * known[0]
            b -= entry * known[1]
            c -= entry * known[2]
            d -= entry * known[3]
        row = work[i]
        row[0], row[1], row[2], row[3] = a, b, c, d
    for i in range(n - 1, -1, -1):
        row = work[i]
        a, b, c, d = row[0], row[1], row[2], row[3]
        for p in range(plan.diagonal[i] + 1, plan.row_start[i + 1]):
            entry, known = lu[p], work[plan.column[p]]
            a -= entry * known[0]
            b -= entry * known[1]
            c -= entry * known[2]
            d -= entry * known[3]
        inverse, found = lu[plan.diagonal[i]], rhs[plan.order[i]]
        a, b, c, d = a * inverse, b * inverse, c * inverse, d * inverse
        row[0], row[1], row[2], row[3] = a, b, c, d
        found[c_a], found[c_b], found[c_c], found[c_d] = a, b, c, d


@inner
def _solve_eight(plan, lu, rhs, work, first):
    """As `_solve_four`, eight columns at once, of which there are at least five."""
    n, last = plan.order.size, rhs.shape[1] - 1
    c_a, c_b, c_c, c_d = first, first + 1, first + 2, first + 3
    c_e, c_f, c_g, c_h = first + 4, min(first + 5, last), min(first + 6, last), min(first + 7, last)
    for i in range(n):
        given = rhs[plan.order[i]]
        a, b, c, d, e, f, g, h = given[c_a], given[c_b], given[c_c], given[c_d], given[c_e], given[c_f], given[c_g], given[c_h]
        for p in range(plan.row_start[i], plan.diagonal[i]):
            entry, known = lu[p], work[plan.column[p]]
            a -= entry * known[0]
            b -= entry * known[1]
            c -= entry * known[2]
            d -= entry * known[3]
            e -= entry * known[4]
            f -= entry * known[5]
            g -= entry * known[6]
            h -= entry * known[7]
        row = work[i]
        row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7] = a, b, c, d, e, f, g, h
    for i in range(n - 1, -1, -1):
        row = work[i]
        a, b, c, d, e, f, g, h = row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7]
        for p in range(plan.diagonal[i] + 1, plan.row_start[i + 1]):
            entry, known = lu[p], work[plan.column[p]]
            a -= entry * known[0]
            b -= entry * known[1]
            c -= entry * known[2]
            d -= entry * known[3]
            e -= entry * known[4]
            f -= entry * known[5]
            g -= entry * known[6]
            h -= entry * known[7]
        inverse, found = lu[plan.diagonal[i]], rhs[plan.order[i]]
        a, b, c, d = a * inverse, b * inverse, c * inverse, d * inverse
        e, f, g, h = e * inverse, f * inverse, g * inverse, h * inverse
        row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7] = a, b, c, d, e, f, g, h
        found[c_a], found[c_b], found[c_c], found[c_d], found[c_e], found[c_f], found[c_g], found[c_h] = a, b, c, d, e, f, g, h
