"""A symmetric matrix K = B^T D B in its factors: what stiffness is before rounding mixes stretching with bending.

The rows of B are strains, small differences of coordinates. Summed as they are, B^T (D (B x)) has the round-off of these differences;
the products of K's own entries, which a skin of n elements makes n^4 times larger than their sum, have that of the products.
"""

from typing import NamedTuple

import numpy as np
import scipy

from toolkit.foundation.compiled.rows import add_rows
from toolkit.foundation.kernel import inner


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
