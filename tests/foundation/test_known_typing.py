"""What is kept of numba's answers are numba's answers, and what it refuses it refuses again."""

from __future__ import annotations

import operator

import numpy as np
import pytest
from numba.core import types
from numba.core.errors import TypingError
from numba.core.registry import cpu_target

from toolkit.foundation.compiled.known_typing import known_typing
from toolkit.foundation.kernel import inner, kernel

OWN = cpu_target.typing_context
ROW, TABLE = types.Array(types.float64, 1, "C"), types.Array(types.float64, 2, "C")
ASKED = [
    (operator.add, (types.float64, types.int64)),
    (operator.truediv, (types.int64, types.int64)),
    (operator.getitem, (TABLE, types.UniTuple(types.int64, 2))),
    (operator.setitem, (ROW, types.uint64, types.complex128)),
    (operator.lt, (types.float64, types.float64)),
]


@pytest.mark.parametrize("asked", ASKED, ids=lambda asked: asked[0].__name__)
def test_an_answer_is_that_of_numba_the_first_time_and_later(asked):
    OWN.refresh()
    operation, given = asked
    wanted = OWN.resolve_function_type(OWN.resolve_value_type(operation), given, {}) if _fits(operation, given) else None
    for _ in range(2):
        if wanted is None:
            with pytest.raises(TypingError):
                known_typing(OWN).resolve_function_type(OWN.resolve_value_type(operation), given, {})
        else:
            assert known_typing(OWN).resolve_function_type(OWN.resolve_value_type(operation), given, {}) == wanted


def _fits(operation, given) -> bool:
    return not (
        operation is operator.setitem and given[2] is types.complex128
    )  # no complex number fits into an array of real ones


def test_there_is_one_for_what_numba_knows():
    assert known_typing(OWN) is known_typing(OWN)
    assert known_typing(known_typing(OWN)) is known_typing(OWN)


@inner
def half(x):
    return x / 2


@kernel
def halves(values, whole):
    for i in range(len(values)):
        values[i] = half(values[i]) + half(whole)


def test_one_formula_serves_several_types():
    """Formulas themselves are compiled for each, whatever is known of operations."""
    values = np.array([1.0, 2.0])
    halves(values, 3)
    assert values.tolist() == [2.0, 2.5]
    other = np.array([1.0 + 2.0j])
    halves(other, 0.5)
    assert other.tolist() == [0.75 + 1.0j]
