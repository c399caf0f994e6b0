"""Sums of multiples of rows: code that is written for the compiler against the same sums as plain Python."""

import numpy as np
import pytest

from toolkit.foundation.compiled.calls import call
from toolkit.foundation.compiled.rows import LANES, add_rows, add_to_each, filled_up, subtract_multiples
from toolkit.foundation.kernel import kernel, plain

WIDTHS = [0, 8, 16, 24, 32, 40, 72, 136]
ROUND_OFF = 1e-14
"""Of sums of up to nine products of order one."""


@kernel
def add_to_all(target, scale, factor, entries, numbers, starts, source):
    """`add_rows` with run number i for every row i of the target."""
    for i in range(len(target)):
        add_rows(target[i], scale, factor, entries, numbers, starts[i], starts[i + 1], source)


@kernel
def add_to_three(one, two, three, entries, count, source, start, stride):
    """`add_to_each` for three rows."""
    add_to_each((one, two, three), entries, count, source, start, stride)


@kernel
def add_to_one(one, entries, count, source, start, stride):
    """The same for one row."""
    add_to_each((one,), entries, count, source, start, stride)


@kernel
def subtract_from_two(values, factors, length):
    """`subtract_multiples` of three rows from two."""
    a, b, c, d, e, f = factors
    subtract_multiples(values, (0, 50), (a, b, c, d, e, f), (100, 149, 200), length)


@kernel
def subtract_from_one(values, factor, length):
    """The same of one row from one."""
    subtract_multiples(values, (3,), (factor,), (60,), length)


def judged(formula, arrays, *given):
    """The first of the arrays, which the others are added to, by compiled code and as plain Python."""
    found, expected = ([each.copy() for each in arrays] for _ in range(2))
    call(formula, *found, *given)
    plain(formula)(*expected, *given)
    for ours, theirs, before in zip(found, expected, arrays, strict=True):
        assert abs(ours - theirs).max(initial=0) < ROUND_OFF
        assert before.size == 0 or not np.array_equal(ours, before)


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("kind", [np.uint32, np.int64])
def test_rows_are_added_as_plain_python_does(width, kind):
    rng = np.random.default_rng(width)
    starts = np.append(0, np.cumsum(rng.integers(0, 6, 9)))
    entries, numbers = rng.normal(size=starts[-1]), rng.integers(0, 20, starts[-1]).astype(kind)
    target, source = rng.normal(size=(9, width)), rng.normal(size=(20, width))
    judged(add_to_all, [target], 0.3, -2.0, entries, numbers, starts, source)


@pytest.mark.parametrize("width", WIDTHS[1:])
def test_each_row_gets_its_own_sum(width):
    rng = np.random.default_rng(width)
    rows, entries, source = rng.normal(size=(3, width)), rng.normal(size=(3, 11)), rng.normal(size=5 + 9 * 2 * width)
    judged(add_to_three, list(rows), entries, 9, source, 5, 2 * width)
    judged(add_to_one, [rows[0]], entries, 9, source, 5, 2 * width)


@pytest.mark.parametrize("length", [*range(1, 20), 47])
def test_multiples_are_subtracted_and_nothing_beside_them_is_touched(length):
    rng = np.random.default_rng(length)
    values = rng.normal(size=250)
    judged(subtract_from_two, [values], tuple(rng.normal(size=6).tolist()), length)
    judged(subtract_from_one, [values], 0.7, length)
    changed = values.copy()
    call(subtract_from_one, changed, 0.7, length)
    assert np.array_equal(np.flatnonzero(changed != values), 3 + np.arange(length))


def test_rows_are_filled_up_to_whole_vectors():
    assert [filled_up(count) for count in (0, 1, LANES, LANES + 1)] == [0, LANES, LANES, 2 * LANES]
