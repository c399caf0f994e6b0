"""Products with a matrix in its factors, against the matrix, and their derivatives against a complex step."""

from __future__ import annotations

import numpy as np
import pytest

from toolkit.foundation.compiled.calls import call
from toolkit.foundation.compiled.rows import filled_up
from toolkit.foundation.kernel import kernel, plain
from toolkit.linear.linear_solver import (
    Factored,
    FactoredChanges,
    add_factored,
    add_factored_block,
    add_factored_changes,
)

EPS, STEP, SIZE, ROWS, WIDE = np.finfo(float).eps, 1e-30, 9, 5, 4


@kernel
def product(matrix, x, out):
    """Python enters kernels alone."""
    add_factored(matrix, x, out)


@kernel
def block_product(matrix, factor, block, scratch, out):
    """As `product`."""
    add_factored_block(matrix, factor, block, scratch, out)


@kernel
def changed(matrix, changes, x, out):
    """As `product`."""
    add_factored_changes(matrix, changes, x, out)


class Case:
    """A matrix whose rows have four entries each, one of its columns none."""

    def __init__(self, dtype: type = float) -> None:
        rng = np.random.default_rng(3)
        self.column = np.array([rng.permutation(SIZE - 1)[:WIDE] for _ in range(ROWS)])
        self.value, self.weight = rng.normal(size=(ROWS, WIDE)).astype(dtype), rng.uniform(1, 2, ROWS).astype(dtype)
        self.x, self.block = rng.normal(size=SIZE), np.zeros((SIZE, filled_up(3)))
        self.block[:, :3] = rng.normal(size=(SIZE, 3))

    @property
    def dense(self) -> np.ndarray:
        rows = np.zeros((ROWS, SIZE), self.value.dtype)
        np.put_along_axis(rows, self.column, self.value, axis=1)
        return rows.T @ (self.weight[:, None] * rows)

    @property
    def factored(self) -> Factored:
        columns, order = self.column.ravel(), np.argsort(self.column.ravel(), kind="stable")
        felt, start = np.unique(columns[order], return_index=True)
        return Factored(
            WIDE * np.arange(ROWS + 1), columns.astype(np.uint32), self.value.ravel(), self.weight,
            felt, np.append(start, columns.size), (order // WIDE).astype(np.uint32), self.value.ravel()[order],
        )  # fmt: skip


def test_products_are_those_of_the_matrix():
    case = Case()
    out, several = np.ones(SIZE), np.ones_like(case.block)
    call(product, case.factored, case.x, out)
    call(block_product, case.factored, -2.0, case.block, np.full((ROWS, case.block.shape[1]), np.nan), several)
    np.testing.assert_allclose(out, 1 + case.dense @ case.x, rtol=0, atol=40 * EPS)
    np.testing.assert_allclose(several[:, :3], 1 - 2 * (case.dense @ case.block)[:, :3], rtol=0, atol=80 * EPS)


@pytest.mark.parametrize("compiled", [True, False])
def test_changes_of_rows_and_weights_are_derivatives_of_the_product(compiled):
    """Of three variables the first moves two rows, the second the weight of one, the third nothing."""
    case, moved = Case(), Case(complex)
    rng = np.random.default_rng(4)
    by_value, by_weight = rng.normal(size=(3, WIDE)), rng.normal(size=3)
    by_value[2] = 0
    changes = FactoredChanges(np.array([1, 4, 3]), np.array([0, 0, 1]), WIDE * np.arange(4), by_value.ravel(), by_weight)
    out = np.zeros((SIZE, 3))
    if compiled:
        call(changed, case.factored, changes, case.x, out)
    else:
        plain(changed)(case.factored, changes, case.x, out)
    for variable in range(3):
        moved = Case(complex)
        for d in np.flatnonzero(changes.variable == variable):
            moved.value[changes.row[d]] += 1j * STEP * by_value[d]
            moved.weight[changes.row[d]] += 1j * STEP * by_weight[d]
        np.testing.assert_allclose(out[:, variable], (moved.dense @ case.x).imag / STEP, rtol=0, atol=40 * EPS)
