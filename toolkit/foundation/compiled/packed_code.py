"""Code for numba by which compiled code reads a packed record."""

from __future__ import annotations

import operator
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_builtin, lower_getattr_generic
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer, infer_getattr, infer_global, signature
from numba.experimental.function_type import FunctionModel
from numba.extending import NativeValue, models, register_model, unbox
from numba.np.arrayobj import make_array, populate_array
from numba.np.numpy_support import as_dtype

from toolkit.foundation.compiled.packed import FormulaType, PackedType, inside, words_of

register_model(PackedType)(models.OpaqueModel)
register_model(FormulaType)(FunctionModel)


@unbox(PackedType)
def _unbox_packed(_kind: Any, given: Any, c: Any) -> NativeValue:
    return NativeValue(_attribute(given, "address", c))


@unbox(FormulaType)
def _unbox_formula(kind: Any, given: Any, c: Any) -> NativeValue:
    return NativeValue(_formula(c.context, c.builder, kind, _attribute(given, "address", c)))


def _attribute(given: Any, name: str, c: Any) -> Any:
    """Address that an attribute of a Python object is."""
    number = c.pyapi.object_getattr_string(given, name)
    address = c.pyapi.long_as_voidptr(number)
    c.pyapi.decref(number)
    return address


def _formula(context: Any, builder: Any, kind: Any, address: Any) -> Any:
    found = cgutils.create_struct_proxy(kind)(context, builder)
    nothing = cgutils.get_null_value(cgutils.voidptr_t)
    found.c_addr, found.py_addr, found.jit_addr = nothing, nothing, address
    return found._getvalue()


@infer_getattr
class _Attributes(AttributeTemplate):
    """Types of the parts of a packed record by name."""

    key = PackedType

    def generic_resolve(self, kind: Any, name: str) -> Any:  # type: ignore[override]
        fields = getattr(kind.of, "fields", ())
        return inside(kind.of.types[fields.index(name)]) if name in fields else None


@infer
class _Places(AbstractTemplate):
    """Types of the parts of a packed tuple by a number that is known when it is compiled."""

    key = "static_getitem"

    def generic(self, args: Any, kws: Any) -> Any:
        kind, place = args
        if isinstance(kind, PackedType) and isinstance(place, int) and 0 <= place < len(kind.of.types):
            return signature(inside(kind.of.types[place]), *args)
        return None


@infer_global(operator.getitem)
class _Entries(AbstractTemplate):
    """Type of one entry of a packed tuple of formulas."""

    def generic(self, args: Any, kws: Any) -> Any:
        kind, place = args
        if isinstance(kind, PackedType) and isinstance(kind.of, types.UniTuple) and isinstance(place, types.Integer):
            return signature(inside(kind.of.dtype), kind, types.intp)
        return None


@lower_getattr_generic(PackedType)
def _get_attribute(context: Any, builder: Any, kind: Any, value: Any, name: str) -> Any:
    return _part(context, builder, kind.of, value, kind.of.fields.index(name))


@lower_builtin("static_getitem", PackedType, types.IntegerLiteral)
def _get_place(context: Any, builder: Any, found: Any, args: Any) -> Any:
    return _part(context, builder, found.args[0].of, args[0], found.args[1].literal_value)


@lower_builtin(operator.getitem, PackedType, types.intp)
def _get_entry(context: Any, builder: Any, found: Any, args: Any) -> Any:
    kind = found.args[0].of.dtype
    place = builder.mul(args[1], ir.Constant(WORD, words_of(kind)))
    return _load(context, builder, kind, builder.gep(_words(builder, args[0]), [place]))


WORD = ir.IntType(64)


def _words(builder: Any, address: Any) -> Any:
    return builder.bitcast(address, WORD.as_pointer())


def _part(context: Any, builder: Any, of: Any, address: Any, place: int) -> Any:
    begins = sum(map(words_of, of.types[:place]))
    return _load(context, builder, of.types[place], _at(builder, _words(builder, address), begins))


def _at(builder: Any, words: Any, place: int) -> Any:
    return builder.gep(words, [ir.Constant(WORD, place)], inbounds=True) if place else words


def _load(context: Any, builder: Any, kind: Any, words: Any) -> Any:
    """Value of a type that begins at an address."""
    if isinstance(inside(kind), PackedType):
        return builder.bitcast(words, cgutils.voidptr_t)
    if isinstance(kind, types.Array):
        return _array(context, builder, kind, words)
    if isinstance(kind, types.NoneType):
        return context.get_dummy_value()
    if isinstance(kind, types.Tuple | types.UniTuple):
        places = [sum(map(words_of, kind.types[:k])) for k in range(len(kind.types))]
        parts = [_load(context, builder, each, _at(builder, words, k)) for each, k in zip(kind.types, places, strict=True)]
        return context.make_tuple(builder, kind, parts)
    if isinstance(kind, FormulaType):
        return _formula(context, builder, kind, _word(builder, words, cgutils.voidptr_t))
    if isinstance(kind, types.Float):
        return _word(builder, words, ir.DoubleType())
    word = _word(builder, words)
    return builder.trunc(word, context.get_value_type(kind)) if isinstance(kind, types.Boolean) else word


def _word(builder: Any, words: Any, kind: Any = WORD) -> Any:
    """Word at an address, of which LLVM may know that nobody writes it while compiled code runs."""
    found = builder.load(builder.bitcast(words, kind.as_pointer()))
    found.set_metadata("invariant.load", builder.module.add_metadata([]))
    return found


def _array(context: Any, builder: Any, kind: Any, words: Any) -> Any:
    found, size = make_array(kind)(context, builder), as_dtype(kind.dtype).itemsize
    data = _word(builder, words, context.get_data_type(kind.dtype).as_pointer())
    shape = [_word(builder, _at(builder, words, 1 + k)) for k in range(kind.ndim)]
    strides = [_word(builder, _at(builder, words, 1 + kind.ndim + k)) for k in range(kind.ndim)]
    if kind.layout == "C":  # known from the shape, the last when it is compiled
        strides = [ir.Constant(WORD, size)]
        for length in shape[:0:-1]:
            strides.insert(0, builder.mul(strides[0], length))
    populate_array(found, data=data, shape=shape, strides=strides, itemsize=ir.Constant(WORD, size), meminfo=None)
    return found._getvalue()
