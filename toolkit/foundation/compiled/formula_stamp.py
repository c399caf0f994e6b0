"""Hash of all that a kernel's code follows from: an edited formula is compiled anew with those that call it, and no others."""

from __future__ import annotations

import dis
from collections.abc import Callable, Hashable, Sequence
from functools import cache
from hashlib import sha256
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import TYPE_CHECKING, Any, Protocol, TypeGuard

import numpy as np
from numba import types
from numba.extending import is_jitted

from toolkit.foundation.compiled.rows import add_rows, add_to_each, subtract_multiples

if TYPE_CHECKING:
    from toolkit.foundation.compiled.numba_parts import JITCodeLibrary, JITCPUCodegen, Signature

WRITTEN = (add_rows, add_to_each, subtract_multiples)
"""Functions of which formulas take code that is written for the compiler."""
LIBRARIES = ("numpy", "math", "cmath", "numba")
"""Modules whose names always mean the same; a number of another module may change."""


LOADING = tuple(dis.opmap[name] for name in ("LOAD_CONST", "RETURN_CONST") if name in dis.opmap)
"""Instructions with the number of a constant."""


class CompiledFormula(Protocol):
    """A formula as numba has compiled it for the types of some arguments."""

    signature: Signature
    library: JITCodeLibrary
    codegen: JITCPUCodegen
    entry_point: Callable
    lifted: Sequence[Any]
    fndesc: Any


class Kernel(Hashable, Protocol):
    """A formula that numba compiles."""

    py_func: FunctionType
    targetoptions: dict[str, object]


def is_kernel(used: object) -> TypeGuard[Kernel]:
    """Whether a value is a formula that numba compiles."""
    return bool(is_jitted(used))  # type: ignore[arg-type]


class UnknownNameError(Exception):
    """Error of a kernel that uses a name of which it is unknown what its code takes from it.

    So its code cannot be kept.
    """


@cache
def formula_stamp(kernel: Kernel) -> str:
    """Hash of a kernel's own instructions and constants, and of those of every kernel that it calls: its code may hold copies of theirs.

    Modules count, because the code finds what it calls by their names. Comments, docstrings and places in a file do not.

    Raises
    ------
    UnknownNameError
        A kernel uses a name for something else than a kernel, numbers, an array, a named tuple, or a part of `LIBRARIES`.
    """
    found, numbers, texts = [kernel], {kernel: 0}, []
    for each in found:  # which grows
        for used in (called := _called(each)):
            if used not in numbers:
                numbers[used] = len(found)
                found.append(used)
        texts.append(f"{each.py_func.__module__} {_own(each)} calls {[numbers[used] for used in called]}")
    return sha256("\n".join(texts).encode()).hexdigest()


@cache
def layout(given: types.Type | tuple[types.Type, ...]) -> str:
    """Type of numba with the names and places of all records.

    numba writes the types alone, but code finds its records by both.
    """
    if isinstance(given, tuple):
        return f"({', '.join(map(layout, given))})"
    if isinstance(given, types.BaseTuple):
        kind, fields = getattr(given, "instance_class", tuple), getattr(given, "fields", ())
        return f"{kind.__module__}.{kind.__name__}{fields}{layout(tuple(getattr(given, 'types', ())))}"
    if isinstance(given, types.FunctionType):
        return f"{layout(given.signature.return_type)} of {layout(given.signature.args)}"
    return str(given)


@cache
def _own(kernel: Kernel) -> str:
    """Text on one kernel: how it is compiled, its instructions, and what it takes from the names around it."""
    names = [f"{name} is {_meaning(name, used)}" for name, used in [*_names(kernel), *_defaults(kernel)]]
    return "\n".join([repr(sorted(kernel.targetoptions.items())), _instructions(kernel.py_func), *names])


def _called(kernel: Kernel) -> list[Kernel]:
    return [used for _, used in _names(kernel) if is_kernel(used)]


def _names(kernel: Kernel) -> list[tuple[Hashable, object]]:
    """Names that a kernel finds in its module or in the function that made it, and what they stand for."""
    function = kernel.py_func
    space, around = function.__globals__, zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    named = [(name, space[name]) for code in _codes(function.__code__) for name in code.co_names if name in space]
    return named + [(name, cell.cell_contents) for name, cell in around]


def _defaults(kernel: Kernel) -> list[tuple[Hashable, object]]:
    """Default values of arguments, which whoever calls the kernel holds."""
    function = kernel.py_func
    return [*enumerate(function.__defaults__ or ()), *sorted((function.__kwdefaults__ or {}).items())]


def _meaning(name: Hashable, used: object) -> str:
    if is_kernel(used):
        return "a kernel"
    if isinstance(used, FunctionType) and used in WRITTEN:
        return _written()
    if used is None or isinstance(used, bool | int | float | complex | str | np.generic) or _is_plain(used):
        return f"{type(used).__name__} {used!r}"
    if isinstance(used, np.ndarray) and not used.dtype.hasobject:
        return f"{used.dtype} {used.shape} {used.strides} {used.tobytes().hex()}"
    if isinstance(used, type) and issubclass(used, tuple) and (fields := getattr(used, "_fields", ())):
        return f"{used.__module__}.{used.__name__} {fields} {vars(used).get('_field_defaults')}"
    if isinstance(used, ModuleType) and used.__name__ in LIBRARIES:
        return used.__name__
    if isinstance(used, BuiltinFunctionType | np.ufunc) or (isinstance(used, type) and used.__module__ == "builtins"):
        return f"{getattr(used, '__module__', 'numpy')}.{used.__name__}"
    raise UnknownNameError(repr(name))


@cache
def _written() -> str:
    return sha256(Path(__file__).with_name("written_code.py").read_bytes()).hexdigest()


def _is_plain(used: object) -> bool:
    """Whether a value is a tuple of numbers."""
    return type(used) is tuple and all(isinstance(each, bool | int | float | complex) or _is_plain(each) for each in used)


def _codes(code: CodeType) -> list[CodeType]:
    """Instructions of a function and of those inside it."""
    return [code, *(inside for each in code.co_consts if isinstance(each, CodeType) for inside in _codes(each))]


def _instructions(function: Callable) -> str:
    return "\n".join(_bytes(code, function.__doc__) for code in _codes(function.__code__))


def _bytes(code: CodeType, docstring: str | None) -> str:
    """Text of one function's instructions, without its docstring and its place in the file."""
    told = code.co_consts[:1] == (docstring,) and not _loads_first(code)
    constants = [_constant(each) for each in code.co_consts[told:]]
    variables = code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars
    counts = code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags
    return f"{code.co_code.hex()} {variables} {counts} {code.co_exceptiontable.hex()} {constants}"


def _loads_first(code: CodeType) -> bool:
    """Whether the first constant, where a docstring is, is one of the formula too."""
    instructions = set(zip(code.co_code[::2], code.co_code[1::2], strict=True))
    return any((each, 0) in instructions for each in LOADING)


def _constant(given: object) -> str:
    if isinstance(given, CodeType):
        return "a function"
    return repr(sorted(map(repr, given)) if isinstance(given, frozenset) else given)
