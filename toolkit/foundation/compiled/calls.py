"""Calls of compiled formulas from Python: records go by their addresses, and the code for the types of arguments is looked up once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from numba import config, typeof, void
from numba.extending import is_jitted

from toolkit.foundation.compiled.formula_stamp import CompiledFormula
from toolkit.foundation.compiled.packed import Formula, Packed, TypeKey, key_of, quiet
from toolkit.foundation.compiled.public_parts import PUBLIC_ONLY, first_class
from toolkit.foundation.rare_collections import rare_collections

R = TypeVar("R")


def call(function: Callable[..., R], *arguments: object) -> R:
    """Call a kernel; records among its arguments go as one address each, see `packed`."""
    if not is_jitted(function):
        return function(*arguments)
    given = [in_memory(each) for each in arguments]
    return entry_point(function, *given)(*given)


def entry_point(function: Callable[..., R], *arguments: object) -> Callable[..., R]:
    """Function that `call` calls for arguments of these types, which are `in_memory`: for whoever calls it again and again."""
    if not is_jitted(function):
        return function
    found: Callable[..., R] = quiet()(function) if PUBLIC_ONLY else compiled_for(function, list(arguments)).entry_point
    return found


def formula_for(function: Callable[..., R], *arguments: object) -> Callable[..., R] | Formula:
    """Formula to pass to other kernels: a kernel as it is compiled for the types of arguments."""
    if not is_jitted(function):
        return function
    if PUBLIC_ONLY:
        return first_class(function, void(*map(typeof, arguments)))
    return Formula(compiled_for(function, [in_memory(each) for each in arguments]))


def by_value(record: type[R]) -> type[R]:
    """Decorator of a small record that formulas make themselves: they hand it on by its words."""
    _BY_VALUE.add(record)
    return record


_BY_VALUE: set[type] = set()


def in_memory(given: object) -> object:
    """An argument as compiled code takes it: records, and tuples of formulas, as `Packed`; as it is where numba is switched off, or
    nothing but its documented parts is used."""
    if config.DISABLE_JIT or PUBLIC_ONLY or not isinstance(given, tuple) or type(given) in _BY_VALUE:  # type: ignore[attr-defined]
        return given
    return Packed(given) if hasattr(given, "_fields") or any(isinstance(each, Formula | tuple) for each in given) else given


def compiled_for(function: Callable, given: Sequence[object]) -> CompiledFormula:
    """A kernel as numba compiles it for the types of arguments `in_memory`; to have numba look at these takes longer than a short run."""
    key = function, *map(key_of, given)
    if key not in _COMPILED:
        kernel: Any = function
        kinds = tuple(map(typeof, given))
        with quiet(), rare_collections():
            if kernel.targetoptions.get("no_cpython_wrapper"):  # an inner formula, which refuses
                function(*given)
            kernel.compile(kinds)
        _COMPILED[key] = kernel.overloads[kinds]
    return _COMPILED[key]


_COMPILED: dict[tuple[Callable | TypeKey, ...], CompiledFormula] = {}
