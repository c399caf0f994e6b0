"""What the compiler remembers of numba's own functions is what numba itself makes of them."""

from __future__ import annotations

import operator
from collections.abc import Iterator

import numba
import numpy as np
import pytest
from numba.core import types
from numba.core.errors import TypingError
from numba.core.registry import cpu_target
from numba.core.typing.context import Context

from toolkit.foundation.compiled.numba_parts import KnownOperators, KnownResults
from toolkit.foundation.kernel import kernel

FLOATS, COMPLEX = (types.float64, types.float64), (types.complex128, types.int64)


@pytest.fixture
def numbas() -> Context:
    """What numba itself knows, at the state in which it compiles."""
    context = cpu_target.typing_context
    context.refresh()
    return context


@pytest.fixture
def asked(monkeypatch, numbas) -> Iterator[list]:
    """The calls that numba is asked for, from an empty memory on."""
    calls = []
    own = Context.resolve_function_type

    def counted(self, func, args, kws):
        calls.append((func, args))
        return own(self, func, args, kws)

    monkeypatch.setattr(KnownResults, "results", {})
    monkeypatch.setattr(Context, "resolve_function_type", counted)
    return calls


@pytest.mark.parametrize("function", [operator.add, operator.truediv, abs])
@pytest.mark.parametrize("args", [FLOATS, COMPLEX])
def test_numbas_own_functions_are_resolved_as_by_numba_and_once(numbas, asked, function, args):
    args, of_numba = args[:1] if function is abs else args, numbas.resolve_value_type(function)
    expected = numbas.resolve_function_type(of_numba, args, {})
    asked.clear()
    found = [KnownResults(numbas).resolve_function_type(of_numba, args, {}) for _ in range(3)]
    assert found == [expected] * 3
    assert asked == [(of_numba, args)]  # by the first of three compilers, from which the others know it


@pytest.mark.parametrize("function", [operator.add, operator.getitem])
def test_code_is_written_by_what_was_resolved_before(numbas, asked, function):
    """An operator gives the step that writes code what it gave the step that found the types, and leads to the same code."""
    args = FLOATS if function is operator.add else (types.float64[::1], types.intp)
    of_numba, known = numbas.resolve_value_type(function), KnownOperators(numbas)
    expected = KnownResults(numbas).resolve_function_type(of_numba, args, {})
    asked.clear()
    found = known.resolve_value_type(function)
    assert found.get_call_type(known, args, {}) is expected
    assert not asked
    assert found.get_impl_key(expected) == of_numba.get_impl_key(expected)


@pytest.mark.usefixtures("asked")
def test_written_entries_are_resolved_as_by_numba(numbas):
    args = types.float64[::1], types.intp, types.int64
    found = [KnownResults(numbas).resolve_setitem(*args) for _ in range(2)]
    assert found == [numbas.resolve_setitem(*args)] * 2


def test_formulas_with_functions_inside_are_compiled():
    """Most have none, and are spared the step that looks for them."""

    @kernel
    def sums(x, found):
        def part(k):
            return x[k] + 1

        for k in range(len(x)):
            found[k] = part(k)

    found = np.zeros(3)
    sums(np.arange(3.0), found)
    assert list(found) == [1, 2, 3]
    assert sums.nopython_signatures


@pytest.mark.usefixtures("asked")
def test_results_of_other_types_are_not_taken_for_each_other(numbas):
    known, add = KnownResults(numbas), numbas.resolve_value_type(operator.add)
    found = [known.resolve_function_type(add, args, {}).return_type for args in (FLOATS, COMPLEX, (types.int64, types.int64))]
    assert found == [types.float64, types.complex128, types.int64]


@pytest.mark.usefixtures("asked")
def test_functions_of_users_are_left_to_numba(numbas):
    """Their formulas may be others under the same name."""

    @numba.njit
    def twice(x):
        return 2 * x

    of_user = numba.typeof(twice)
    expected = numbas.resolve_function_type(of_user, (types.float64,), {})
    known = KnownResults(numbas)
    assert known.resolve_function_type(of_user, (types.float64,), {}) == expected
    assert all(func is not of_user for func, *_ in KnownResults.results)


@pytest.mark.usefixtures("asked")
def test_what_fails_is_not_remembered(numbas):
    known, add = KnownResults(numbas), numbas.resolve_value_type(operator.add)
    for _ in range(2):
        with pytest.raises(TypingError):
            known.resolve_function_type(add, (types.float64, types.none), {})
    assert not KnownResults.results


def test_no_answer_yet_is_asked_for_again(numbas, monkeypatch):
    known, add = KnownResults(numbas), numbas.resolve_value_type(operator.add)
    monkeypatch.setattr(KnownResults, "results", {})
    monkeypatch.setattr(Context, "resolve_function_type", lambda *_: None)
    assert known.resolve_function_type(add, FLOATS, {}) is None
    assert not KnownResults.results
