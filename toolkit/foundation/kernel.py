"""One source, two ways to run: formulas compiled by numba, and the same formulas as plain Python on complex arrays.

With the environment variable NUMBA_DISABLE_JIT=1 real numbers run as plain Python too, slowly, so that a debugger can step through.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from types import FunctionType
from typing import TYPE_CHECKING, Any

import numba
from numba import config
from numba.extending import is_jitted

from toolkit.foundation.compiled import public_parts
from toolkit.foundation.compiled.compiled_code import CompiledCode
from toolkit.foundation.compiled.packed import Formula, quiet
from toolkit.foundation.compiled.public_parts import PUBLIC_ONLY
from toolkit.foundation.errors import InputError
from toolkit.foundation.rare_collections import rare_collections

if not PUBLIC_ONLY:
    from toolkit.foundation.compiled.numba_parts import FormulaCompiler, InnerFormula
if TYPE_CHECKING:
    from toolkit.foundation.compiled.numba_parts import Signature

SETTINGS = {"error_model": "numpy", "_nrt": False, "forceinline": False, "no_cfunc_wrapper": True}
"""Settings of numba for all formulas; one that did not say whether it becomes part of its callers would take that from the first
of them."""


def kernel(function: Callable) -> Callable:
    """Decorator of a formula that Python calls: compiled on first use, kept on disk, callable by other kernels too.

    Kernels allocate nothing, so they are compiled without numba's reference counting (`_nrt`): measured, that doubles the speed of
    the step loop and halves the time to compile it. Other kernels take it as an inner formula: code that Python can enter is made for
    those alone that Python enters.
    """
    entrance = _compiled(function)
    if is_jitted(entrance) and not PUBLIC_ONLY:
        within: Any = _inner(function)
        entrance.__dict__.update(get_call_template=within.get_call_template, get_overload=within.get_overload)
    return entrance


def loop(function: Callable) -> Callable:
    """Decorator of a kernel that runs for long: other threads of Python go on meanwhile, as its arrays belong to one run alone."""
    return _compiled(function, nogil=True)


def inner(function: Callable) -> Callable:
    """Decorator of a formula that only other kernels call; without an entrance from Python it compiles faster."""
    return _inner(function)


def inlined(function: Callable) -> Callable:
    """Decorator of an inner formula that becomes part of its callers, where passing on many arguments would cost more than it does.

    Measured, it doubles the speed of small mechanisms, and takes a third more time to compile; so it is kept to what runs most.
    """
    return _inner(function, forceinline=True)


def _inner(function: Callable, **options: bool) -> Callable:
    if config.DISABLE_JIT:  # type: ignore[attr-defined]
        return function
    if PUBLIC_ONLY:
        return public_parts.compiled(function)
    return InnerFormula(function, SETTINGS | options, partial(CompiledCode, inner=True))


def _compiled(function: Callable, **options: bool) -> Callable:
    if PUBLIC_ONLY:
        return public_parts.compiled(function, **options)
    dispatcher: Any = numba.njit(function, pipeline_class=FormulaCompiler, **SETTINGS | options)  # type: ignore[call-overload]
    if not config.DISABLE_JIT:  # type: ignore[attr-defined]
        dispatcher._cache = CompiledCode(dispatcher)
    return dispatcher


MOST_FAMILIES = 8
"""Most families of joints, and of loads, that one scene can use; fixed, so that the loop is compiled once for every scene."""


@inner
def copy(source, target):
    """Copy a vector into another: target = source."""
    for i in range(len(source)):
        target[i] = source[i]


def slots(functions: list[Callable], signature: Signature) -> tuple[Formula | Callable, ...]:
    """Functions as the fixed-length tuple of one type that the compiled loop accepts.

    Raises
    ------
    InputError
        More functions than slots.
    """
    if len(functions) > MOST_FAMILIES:
        raise InputError(
            f"the scene uses {len(functions)} different kinds of joints or of loads, at most {MOST_FAMILIES} are possible. "
            "Unite kinds that differ only in a parameter."
        )
    return tuple(([first_class(function, signature) for function in functions] * MOST_FAMILIES)[:MOST_FAMILIES])


@cache
def first_class(function: Callable, signature: Signature) -> Formula | Callable:
    """A kernel compiled for one signature, as an argument for other kernels, compiled without its code."""
    if not is_jitted(function):
        return function
    if PUBLIC_ONLY:
        return public_parts.first_class(function, signature)
    kernel: Any = function
    with quiet(), rare_collections():
        kernel.compile(signature)
        return Formula(kernel.get_compile_result(signature))


@cache
def plain(function: Callable) -> Callable:
    """Formula as plain Python, together with every kernel that it calls; it takes complex arrays."""
    if not is_jitted(function):
        return function
    kernel: Any = function
    source: FunctionType = kernel.py_func
    names = {name: value for name, value in source.__globals__.items() if name in source.__code__.co_names}
    called = {name: plain(value) for name, value in names.items() if is_jitted(value) and value is not function}
    result = FunctionType(source.__code__, {**source.__globals__, **called}, source.__name__, source.__defaults__)
    result.__doc__ = source.__doc__
    return result
