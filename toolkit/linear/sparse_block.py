"""Solutions for many right-hand sides from the factors of `sparse_lu`."""

from __future__ import annotations

from toolkit.foundation.kernel import copy, kernel
from toolkit.foundation.vectors.rows import add_rows


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
