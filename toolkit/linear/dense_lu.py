"""Dense LU with partial pivoting: what the step loop falls back to when the fixed order of `sparse_lu` meets a bad pivot.

Which row holds the largest entry of a column depends on the units of the rows, so pivots are compared as if the matrix had been
equilibrated, every row and column with a largest entry of 1. The factors themselves stay in the units of the matrix.
"""

from __future__ import annotations

import numpy as np

from toolkit.foundation.kernel import inner, kernel

SWEEPS = 5
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
    for _ in range(SWEEPS):
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
