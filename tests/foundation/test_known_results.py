"""What the compiler remembers of numba's own functions is what numba itself makes of them."""

from __future__ import annotations

import operator
from collections.abc import Iterator

import numba
import pytest
from numba.core import types
from numba.core.errors import TypingError
from numba.core.registry import cpu_target
from numba.core.typing.context import Context

from toolkit.foundation.compiled.formula_compiler import KnownResults

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
