"""Records for compiled code as one address: what formulas read there is what stands in the record, and plain Python gives the same."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest

from toolkit.foundation.compiled.calls import by_value, call, compiled_for, in_memory
from toolkit.foundation.compiled.packed import Packed, address_of
from toolkit.foundation.kernel import first_class, inner, kernel, plain


class Deep(NamedTuple):
    table: np.ndarray
    nothing: None
    factor: float


class Record(NamedTuple):
    count: int
    on: bool
    places: tuple
    vector: np.ndarray
    deep: Deep
    block: np.ndarray


@by_value
class Small(NamedTuple):
    x: float


@inner
def row(deep, k):
    total = 0.0
    for j in range(deep.table.shape[1]):
        total += deep.factor * deep.table[k, j]
    return total


@kernel
def read(record, functions, out):
    """Of every kind of value that a record may hold."""
    out[0] = record.count + (10.0 if record.on else 20.0)
    out[1] = len(record.places) + 100 * record.places[1]
    out[2] = row(record.deep, 1)
    out[3] = 1.0 if record.deep.nothing is None else 2.0
    for k in range(record.block.shape[0]):
        out[4 + k] = record.block[k, 1]
    for k in range(len(record.vector)):
        record.vector[k] += 1.0
    functions[0][record.count - 7](record.vector, out)


@kernel
def double(vector, out):
    out[6] = 2 * vector[0]


@kernel
def triple(vector, out):
    out[6] = 3 * vector[0]


@kernel
def square(small, out):
    out[0] = small.x**2


def record(count: int, block: np.ndarray) -> Record:
    return Record(count, count == 7, (3, 4), np.array([5.0, 6.0]), Deep(np.arange(6.0).reshape(2, 3), None, 0.5), block)


BLOCKS = {
    "rows": np.arange(4.0).reshape(2, 2),
    "columns": np.asfortranarray(np.arange(4.0).reshape(2, 2)),
    "part": np.eye(4)[::2, ::2],
}


@pytest.mark.parametrize("layout", BLOCKS)
@pytest.mark.parametrize("count", [7, 8])
def test_what_formulas_read_is_what_stands_in_the_record(layout, count):
    """Also arrays whose rows or columns are not side by side, and the formula that a number of the record chooses."""
    kinds: Any = read_signature()
    given, found, expected = record(count, BLOCKS[layout]), np.zeros(7), np.zeros(7)
    call(read, given, ((first_class(double, kinds), first_class(triple, kinds)), ()), found)
    assert given.vector.tolist() == [6.0, 7.0]  # written where the record has it
    plain(read)(record(count, BLOCKS[layout]), ((plain(double), plain(triple)), ()), expected)
    assert found.tolist() == expected.tolist()
    assert expected[6] == (12.0 if count == 7 else 18.0)


def read_signature() -> Any:
    from numba import float64, void

    return void(float64[::1], float64[::1])


def test_records_of_the_same_make_share_one_code_and_others_have_their_own():
    first, second, other = (in_memory(record(7, BLOCKS[name])) for name in ("rows", "rows", "columns"))
    assert isinstance(first, Packed)
    assert first.kind is second.kind
    assert first.kind != other.kind
    assert first.address != second.address


def test_a_record_that_formulas_make_goes_by_its_words():
    out = np.zeros(1)
    assert in_memory(Small(3.0)) == Small(3.0)
    call(square, Small(3.0), out)
    assert out[0] == 9.0


def test_what_a_record_refers_to_lives_as_long_as_its_address():
    packed = in_memory(Deep(np.full((1, 1), 4.0), None, 1.0))
    [np.zeros((1, 1)) for _ in range(100)]  # would come where it was
    assert packed.record.table[0, 0] == 4.0
    assert packed.words[0] == packed.record.table.__array_interface__["data"][0]


def test_arrays_of_other_types_get_code_of_their_own():
    """Nothing is read as what it is not: code is looked up by the types of what is handed in."""
    out = np.zeros(1)
    codes = {id(compiled_for(square, [Small(value), out])) for value in (2.0, 3.0)}
    assert len(codes) == 1
    assert compiled_for(square, [Small(2), out]) is not compiled_for(square, [Small(2.0), out])
    call(square, Small(2), out)
    assert out[0] == 4.0


def test_an_inner_formula_has_no_entrance_from_python_here_either():
    with pytest.raises(TypeError, match="only other kernels call"):
        call(row, Deep(np.zeros((1, 1)), None, 1.0), 0)


def test_the_address_of_an_array_is_what_numpy_tells():
    """Of parts, of nothing, of single numbers and of what nobody may write to."""
    whole = np.zeros((4, 3))
    frozen = whole.view()
    frozen.flags.writeable = False
    for array in (whole, whole[1:, 1:], whole[::-1], whole.T, np.zeros((0, 3)), np.array(1.0), frozen, np.zeros(2, complex)):
        assert address_of(array) == array.__array_interface__["data"][0]
