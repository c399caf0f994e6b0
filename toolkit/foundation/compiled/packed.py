"""Records for compiled code as one address: where their numbers and arrays are stands in memory, written once.

numba hands a record on by all its words, a thousand of them for a scene, in every call between formulas; to read them is most of the work
of its compiler, and to collect them takes longer than a short run.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import c_void_p
from hashlib import sha256
from typing import Any, TypeAlias

import numpy as np
from numba import NumbaExperimentalFeatureWarning, typeof, types
from numba.extending import typeof_impl

from toolkit.foundation.compiled.formula_stamp import CompiledFormula, layout

LAID_OUT = 0x0001 | 0x0002 | 0x0100 | 0x0400
"""Flags of an array that its type follows from, as numpy numbers them: C- and F-contiguous, aligned, writeable."""

Record = types.Tuple | types.UniTuple | types.NamedTuple | types.NamedUniTuple
"""Types of numba for what consists of parts."""
Content: TypeAlias = "np.ndarray | Formula | tuple[Content, ...] | float | None"
"""What a packed record holds."""
TypeKey: TypeAlias = type | types.Type | int | tuple
"""What the type of an argument follows from: equal keys, equal types of numba."""


@contextmanager
def quiet() -> Iterator[None]:
    """Block, or decorator, without numba's note that functions among the arguments are experimental."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NumbaExperimentalFeatureWarning)
        yield


def _slow_address(array: np.ndarray) -> int:
    return int(array.__array_interface__["data"][0])


def _fast_address(array: np.ndarray) -> int:
    return c_void_p.from_address(id(array) + object.__basicsize__).value or 0


_PROBE = np.zeros(3)[1:]
address_of = _fast_address if _fast_address(_PROBE) == _slow_address(_PROBE) else _slow_address
"""Address where the numbers of an array begin: what stands first behind the head of its object, in all of numpy so far. To have
numpy tell it takes fifty times as long, which was a twentieth of a short run."""


class PackedType(types.Type):
    """numba's type of a `Packed`, which follows from the types of all that is in it.

    Parameters
    ----------
    of : type of the record, or of the tuple of functions
    """

    def __init__(self, of: types.Type) -> None:
        self.of: Any = of
        self.sizes = np.array(_sizes(of), bool)
        """Which of its words are no addresses."""
        kind = getattr(of, "instance_class", tuple).__name__
        super().__init__(name=f"Packed{kind}_{sha256(layout(of).encode()).hexdigest()[:16]}")


class FormulaType(types.FunctionType):
    """numba's type of a compiled formula of one signature, whichever formula it is."""


class Formula:
    """A formula, compiled for one signature, as an argument for others, which are compiled without its code.

    Parameters
    ----------
    compiled : what numba's compiler has made
    """

    def __init__(self, compiled: CompiledFormula) -> None:
        self.compiled, self.kind = compiled, FormulaType(compiled.signature)
        self.address = compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name)

    def __reduce__(self) -> str:
        raise TypeError("addresses hold in one process alone")


class Packed:
    """A record in memory, as one address.

    Of an array there stand address, shape and strides in bytes, of a number its own bits, of a formula its address, of None nothing, and of
    a record or a tuple the words of all that is in it.

    Parameters
    ----------
    record : a named tuple, or a tuple of formulas; kept as long as this
    """

    __slots__ = ("address", "kind", "record", "words")

    def __init__(self, record: tuple) -> None:
        words: list[int] = []
        self.kind = _kinds(_collect(record, words), record)
        self.record, self.words = record, np.array(words, np.int64)
        self.address = address_of(self.words)

    def same_shapes(self, other: Packed) -> bool:
        """Whether another record has the same numbers, and arrays of the same shapes."""
        return self.kind is other.kind and np.array_equal(self.words[self.kind.sizes], other.words[self.kind.sizes])


@typeof_impl.register(Packed)
@typeof_impl.register(Formula)
def _typeof_known(given: Packed | Formula, _context: object) -> types.Type:
    return given.kind


_KNOWN: dict[TypeKey, PackedType] = {}


def _kinds(key: TypeKey, record: tuple) -> PackedType:
    """Type of a record with such contents; numba's own way to find it takes long."""
    if key not in _KNOWN:
        with quiet():
            _KNOWN[key] = PackedType(typeof(record))
    return _KNOWN[key]


def key_of(given: object) -> TypeKey:
    """Key that the type of an argument follows from."""
    if isinstance(given, np.ndarray):
        return given.dtype, given.ndim, given.flags.num & LAID_OUT
    if isinstance(given, Packed):
        return id(given.kind)  # of which there is one for ever: `_KNOWN`
    if isinstance(given, Formula):
        return given.kind
    if isinstance(given, tuple):
        return type(given), *map(key_of, given)
    return type(given)


def _collect(given: Content, words: list[int]) -> TypeKey:
    """Append the words of a value, and return what its type follows from, as `key_of`."""
    if isinstance(given, np.ndarray):
        words.append(address_of(given))
        words += given.shape
        words += given.strides
        return given.dtype, given.ndim, given.flags.num & LAID_OUT  # as `key_of`, which a scene's hundred arrays would call
    if isinstance(given, tuple):
        return type(given), *[_collect(each, words) for each in given]
    if isinstance(given, Formula):
        words.append(given.address)
        return given.kind
    if isinstance(given, float):
        words.append(int(np.float64(given).view(np.int64)))
    elif given is not None:
        words.append(int(given))
    return type(given)


def _sizes(kind: types.Type) -> list[bool]:
    """Which words of a value of a type are no addresses, one bool for each word."""
    if isinstance(kind, Record):
        return [each for part in kind.types for each in _sizes(part)]
    return [not (isinstance(kind, types.Array | FormulaType) and k == 0) for k in range(words_of(kind))]


def words_of(kind: types.Type) -> int:
    """Number of words that a value of a type takes.

    Raises
    ------
    NotImplementedError
        Nobody has said how such a value is kept.
    """
    if isinstance(kind, types.Array):
        return 1 + 2 * kind.ndim
    if isinstance(kind, Record):
        return sum(words_of(part) for part in kind.types)
    if isinstance(kind, types.NoneType):
        return 0
    if isinstance(kind, types.Integer | types.Float | types.Boolean | FormulaType):
        return 1
    raise NotImplementedError(f"a record with {kind}")


def inside(kind: types.Type) -> types.Type:
    """Type by which a formula has a part of a packed record: records and tuples of formulas stay where they are."""
    records = isinstance(kind, types.BaseNamedTuple) or (isinstance(kind, types.UniTuple) and isinstance(kind.dtype, FormulaType))
    return PackedType(kind) if records else kind
