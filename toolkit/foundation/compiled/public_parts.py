"""Formulas compiled by what numba documents alone: they take longer to compile and to run, and give the same numbers.

That is how they are compiled where numba is newer than `TESTED`, where its private parts are not what they were, or on request.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache, partial
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numba
from numba import config
from numba.extending import overload

from toolkit.foundation.compiled.compiled_code import folder_for
from toolkit.foundation.compiled.rows import add_rows, add_to_each, subtract_multiples

if TYPE_CHECKING:
    from toolkit.foundation.compiled.numba_parts import Signature

VARIABLE = "FFRF_NUMBA"
"""Environment variable that asks, by the value `public`, for the documented parts of numba alone."""
TESTED = (0, 68)
"""Newest numba whose private parts are known to be what `numba_parts` takes them for."""


def _public_only() -> bool:
    """Whether nothing but documented parts of numba is to be used."""
    if os.environ.get(VARIABLE) == "public" or (numba.version_info.short or TESTED) > TESTED:
        return True
    try:
        import toolkit.foundation.compiled.numba_parts  # noqa: F401
    except (ImportError, AttributeError):
        return True
    return False


PUBLIC_ONLY = _public_only()
SETTINGS: Any = {"error_model": "numpy"}


def compiled(function: Callable, **options: bool) -> Callable:
    """A formula, compiled on first use; kept on disk if it is one of this program, as numba sees no change in what others call."""
    return _kept(partial(numba.njit, **SETTINGS, **options), function)


@cache
def first_class(function: Callable, signature: Signature) -> Callable:
    """A formula compiled for one signature, as an argument for others, which are compiled without its code."""
    kernel: Any = function
    return _kept(partial(numba.cfunc, signature, **SETTINGS), kernel.py_func)


def _kept(compiler: Callable, function: Callable) -> Callable:
    settings: Any = config
    folder = _folder() if function.__module__.startswith("toolkit.") and not settings.DISABLE_JIT else None
    if folder is None:
        return compiler()(function)
    before, settings.CACHE_DIR = settings.CACHE_DIR, str(folder)
    try:
        return compiler(cache=True)(function)
    finally:
        settings.CACHE_DIR = before


@cache
def _folder() -> Path | None:
    """Folder for the code of this program as it is; None if there is no place."""
    program = Path(__file__).parents[2]
    sources = sorted(program.rglob("*.py"))
    state = sha256(b"".join(each.read_bytes() for each in sources)).hexdigest()[:16]
    return folder_for(f"public_{state}")


def _tell_numba_of_rows() -> None:
    """Say what sums of rows are in compiled code: the same sums as those of `written_code`, one number at a time."""

    @overload(add_rows, jit_options=SETTINGS)
    def added(target, scale, factor, entries, numbers, first, last, source):  # type: ignore[no-untyped-def]
        def code(target, scale, factor, entries, numbers, first, last, source):  # type: ignore[no-untyped-def]
            for j in range(len(target)):
                total = 0.0
                for p in range(first, last):
                    total += entries[p] * source[numbers[p], j]
                target[j] = scale * (target[j] + factor * total)

        return code

    @overload(add_to_each, jit_options=SETTINGS)
    def added_to_each(targets, entries, count, source, start, stride):  # type: ignore[no-untyped-def]
        def code(targets, entries, count, source, start, stride):  # type: ignore[no-untyped-def]
            for k in range(len(targets)):
                for j in range(len(targets[k])):
                    total = 0.0
                    for p in range(count):
                        total += entries[k, p] * source[start + p * stride + j]
                    targets[k][j] += total

        return code

    @overload(subtract_multiples, jit_options=SETTINGS)
    def subtracted(values, rows, factors, sources, length):  # type: ignore[no-untyped-def]
        def code(values, rows, factors, sources, length):  # type: ignore[no-untyped-def]
            for j in range(length):
                for r in range(len(rows)):
                    own = r * len(sources)
                    total = factors[own] * values[sources[0] + j]
                    for s in range(1, len(sources)):
                        total += factors[own + s] * values[sources[s] + j]
                    values[rows[r] + j] -= total

        return code


if PUBLIC_ONLY:
    _tell_numba_of_rows()
