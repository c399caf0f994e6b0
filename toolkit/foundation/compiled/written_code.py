"""Code that is written for the compiler: what reads packed records, and sums of multiples of rows, eight numbers at a time.

Columns of rows by 32, as many vectors as are left: their sums stay in registers, and every factor is read once for all of them.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import base, cgutils, pythonapi
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, Signature, infer_global
from numba.experimental.function_type import FunctionModel
from numba.extending import NativeValue, infer, infer_getattr, lower_builtin, lower_getattr_generic, models, register_model, unbox

from toolkit.foundation.compiled.packed import FormulaType, PackedType, Record, inside, words_of
from toolkit.foundation.compiled.rows import LANES, add_rows, add_to_each, subtract_multiples

Context: TypeAlias = base.BaseContext
Values: TypeAlias = Sequence[ir.Value]
Keywords: TypeAlias = Mapping[str, types.Type]

I64, VECTOR = ir.IntType(64), ir.VectorType(ir.DoubleType(), LANES)

register_model(PackedType)(models.OpaqueModel)
register_model(FormulaType)(FunctionModel)


@unbox(PackedType)
def _unbox_packed(_kind: PackedType, given: ir.Value, c: pythonapi._UnboxContext) -> NativeValue:
    return NativeValue(_attribute(given, "address", c))


@unbox(FormulaType)
def _unbox_formula(kind: FormulaType, given: ir.Value, c: pythonapi._UnboxContext) -> NativeValue:
    return NativeValue(_formula(c.context, c.builder, kind, _attribute(given, "address", c)))


def _attribute(given: ir.Value, name: str, c: pythonapi._UnboxContext) -> ir.Value:
    """Address that an attribute of a Python object is."""
    number = c.pyapi.object_getattr_string(given, name)
    address = c.pyapi.long_as_voidptr(number)
    c.pyapi.decref(number)
    return address


def _formula(context: Context, builder: ir.IRBuilder, kind: FormulaType, address: ir.Value) -> ir.Value:
    found = cgutils.create_struct_proxy(kind)(context, builder)
    nothing = cgutils.get_null_value(cgutils.voidptr_t)
    found.c_addr, found.py_addr, found.jit_addr = nothing, nothing, address
    return found._getvalue()


@infer_getattr
class _Attributes(AttributeTemplate):
    """Types of the parts of a packed record by name."""

    key = PackedType

    def generic_resolve(self, kind: PackedType, name: str) -> types.Type | None:  # type: ignore[override]
        fields = getattr(kind.of, "fields", ())
        return inside(kind.of.types[fields.index(name)]) if name in fields else None


@infer
class _Places(AbstractTemplate):
    """Types of the parts of a packed tuple by a number that is known when it is compiled."""

    key = "static_getitem"

    def generic(self, args: tuple[PackedType, types.Type], kws: Keywords) -> Signature | None:
        kind, place = args
        known = isinstance(kind, PackedType) and isinstance(place, int) and 0 <= place < len(kind.of.types)
        return inside(kind.of.types[place])(*args) if known else None


@infer_global(operator.getitem)
class _Entries(AbstractTemplate):
    """Type of one entry of a packed tuple of formulas."""

    def generic(self, args: tuple[PackedType, types.Type], kws: Keywords) -> Signature | None:
        kind, place = args
        known = isinstance(kind, PackedType) and isinstance(kind.of, types.UniTuple) and isinstance(place, types.Integer)
        return inside(kind.of.dtype)(kind, types.intp) if known else None


@lower_getattr_generic(PackedType)
def _get_attribute(context: Context, builder: ir.IRBuilder, kind: PackedType, value: ir.Value, name: str) -> ir.Value:
    return _part(context, builder, kind.of, value, kind.of.fields.index(name))


@lower_builtin("static_getitem", PackedType, types.IntegerLiteral)
def _get_place(context: Context, builder: ir.IRBuilder, found: Signature, args: Values) -> ir.Value:
    return _part(context, builder, found.args[0].of, args[0], found.args[1].literal_value)


@lower_builtin(operator.getitem, PackedType, types.intp)
def _get_entry(context: Context, builder: ir.IRBuilder, found: Signature, args: Values) -> ir.Value:
    kind = found.args[0].of.dtype
    place = builder.mul(args[1], ir.Constant(I64, words_of(kind)))
    return _load(context, builder, kind, builder.gep(_words(builder, args[0]), [place]))


def _words(builder: ir.IRBuilder, address: ir.Value) -> ir.Value:
    return builder.bitcast(address, I64.as_pointer())


def _part(context: Context, builder: ir.IRBuilder, of: Record, address: ir.Value, place: int) -> ir.Value:
    begins = sum(map(words_of, of.types[:place]))
    return _load(context, builder, of.types[place], _at(builder, _words(builder, address), begins))


def _at(builder: ir.IRBuilder, words: ir.Value, place: int) -> ir.Value:
    return builder.gep(words, [ir.Constant(I64, place)], inbounds=True) if place else words


def _load(context: Context, builder: ir.IRBuilder, kind: types.Type, words: ir.Value) -> ir.Value:
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


def _word(builder: ir.IRBuilder, words: ir.Value, kind: ir.Type = I64) -> ir.Value:
    """Word at an address, of which LLVM may know that nobody writes it while compiled code runs."""
    found = builder.load(builder.bitcast(words, kind.as_pointer()))
    found.set_metadata("invariant.load", builder.module.add_metadata([]))
    return found


def _array(context: Context, builder: ir.IRBuilder, kind: types.Array, words: ir.Value) -> ir.Value:
    found, size = context.make_array(kind)(context, builder), np.dtype(kind.dtype.name).itemsize
    data = _word(builder, words, context.get_data_type(kind.dtype).as_pointer())
    shape = [_word(builder, _at(builder, words, 1 + k)) for k in range(kind.ndim)]
    strides = [_word(builder, _at(builder, words, 1 + kind.ndim + k)) for k in range(kind.ndim)]
    if kind.layout == "C":  # known from the shape, the last when it is compiled
        strides = [ir.Constant(I64, size)]
        for length in shape[:0:-1]:
            strides.insert(0, builder.mul(strides[0], length))
    context.populate_array(found, data=data, shape=shape, strides=strides, itemsize=ir.Constant(I64, size), meminfo=None)
    return found._getvalue()


MOST, MOST_EACH = 4, {1: 4, 2: 2, 3: 2}
"""Vectors whose sums are kept at once; of each row, for so many rows."""
_KINDS = (types.Array, types.Float, types.Float, types.Array, types.Array, types.Integer, types.Integer, types.Array)


@infer_global(add_rows)
@infer_global(add_to_each)
class _Sums(AbstractTemplate):
    """Types of the arguments of a sum of rows, as they are."""

    def generic(self, args: Sequence[types.Type], kws: Keywords) -> Signature | None:
        return types.none(*args)


@lower_builtin(add_rows, *_KINDS)
def _add_rows(context: Context, builder: ir.IRBuilder, found: Signature, args: Values) -> ir.Value:
    target, entries, numbers, source = arrays(context, builder, found, args)
    first, last = (context.cast(builder, args[k], found.args[k], types.intp) for k in (5, 6))
    width = builder.extract_value(target.shape, 0)

    def columns(at: ir.Value, vectors: int) -> None:
        row, rows = (builder.gep(each.data, [at]) for each in (target, source))
        sums = _sums(builder, vectors, entries.data, numbers.data, first, last, rows, width)
        scale, factor = (spread(builder, args[k]) for k in (1, 2))
        for place, total in zip(places(builder, row, vectors), sums, strict=True):
            changed = builder.fadd(builder.load(place, align=8), builder.fmul(factor, total))
            builder.store(builder.fmul(scale, changed), place, align=8)

    by_vectors(builder, width, MOST, columns)
    return context.get_dummy_value()


def arrays(context: Context, builder: ir.IRBuilder, found: Signature, args: Values) -> list[cgutils._StructProxy]:
    """Arrays among the arguments of a compiled call."""
    kinds = enumerate(found.args)
    return [context.make_array(kind)(context, builder, args[k]) for k, kind in kinds if isinstance(kind, types.Array)]


def by_vectors(builder: ir.IRBuilder, width: ir.Value, most: int, columns: Callable[[ir.Value, int], None]) -> None:
    """Write code for all columns of a row, `columns(at, vectors)` for at most so many vectors from column `at` on."""
    column = cgutils.alloca_once(builder, I64)
    builder.store(ir.Constant(I64, 0), column)
    begin, work, end = (builder.append_basic_block(name) for name in ("rows.begin", "rows.work", "rows.end"))
    builder.branch(begin)
    builder.position_at_end(begin)
    at = builder.load(column)
    left = builder.sub(width, at)
    builder.cbranch(builder.icmp_signed(">", left, ir.Constant(I64, 0)), work, end)
    builder.position_at_end(work)
    builder.store(builder.add(at, ir.Constant(I64, LANES * most)), column)
    for vectors in range(most, 0, -1):
        own, other = builder.append_basic_block("rows.own"), builder.append_basic_block("rows.other")
        builder.cbranch(builder.icmp_signed(">=", left, ir.Constant(I64, LANES * vectors)), own, other)
        builder.position_at_end(own)
        columns(at, vectors)
        builder.branch(begin)
        builder.position_at_end(other)
    builder.branch(begin)
    builder.position_at_end(end)


def _sums(
    builder: ir.IRBuilder,
    vectors: int,
    entries: ir.Value,
    numbers: ir.Value,
    first: ir.Value,
    last: ir.Value,
    source: ir.Value,
    width: ir.Value,
) -> list[ir.Value]:
    """Write code for the sums of multiples of rows, in so many vectors."""

    def grown(p: ir.Value, sums: list[ir.Value]) -> list[ir.Value]:
        number = builder.load(builder.gep(numbers, [p]))
        number = builder.zext(number, I64) if number.type.width < I64.width else number
        row = places(builder, builder.gep(source, [builder.mul(number, width)]), vectors)
        entry = spread(builder, builder.load(builder.gep(entries, [p])))
        return [
            builder.fadd(each, builder.fmul(entry, builder.load(place, align=8))) for each, place in zip(sums, row, strict=True)
        ]

    return summed(builder, vectors, first, last, grown)


def summed(
    builder: ir.IRBuilder,
    count: int,
    first: ir.Value,
    last: ir.Value,
    grown: Callable[[ir.Value, list[ir.Value]], list[ir.Value]],
) -> list[ir.Value]:
    """Write a loop over p = first ... last - 1 with so many vectors of sums.

    `grown(p, sums)` writes what they are after one more turn.
    """
    zero = ir.Constant(VECTOR, [0.0] * LANES)
    before, loop, done = builder.block, builder.append_basic_block("sums.loop"), builder.append_basic_block("sums.done")
    builder.cbranch(builder.icmp_signed("<", first, last), loop, done)
    builder.position_at_end(loop)
    p, sums = builder.phi(I64), [builder.phi(VECTOR) for _ in range(count)]
    new, further = grown(p, sums), builder.add(p, ir.Constant(I64, 1))
    builder.cbranch(builder.icmp_signed("<", further, last), loop, done)
    for phi, start, later in ((p, first, further), *((each, zero, value) for each, value in zip(sums, new, strict=True))):
        phi.add_incoming(start, before)
        phi.add_incoming(later, loop)
    builder.position_at_end(done)
    found = [builder.phi(VECTOR) for _ in range(count)]
    for each, value in zip(found, new, strict=True):
        each.add_incoming(zero, before)
        each.add_incoming(value, loop)
    return found


def spread(builder: ir.IRBuilder, value: ir.Value, kind: ir.VectorType = VECTOR) -> ir.Value:
    """Vector of a kind with one number in all its lanes."""
    nothing, lanes = ir.Constant(kind, ir.Undefined), ir.Constant(ir.VectorType(ir.IntType(32), kind.count), [0] * kind.count)
    return builder.shuffle_vector(builder.insert_element(nothing, value, ir.Constant(ir.IntType(32), 0)), nothing, lanes)


def places(builder: ir.IRBuilder, row: ir.Value, vectors: int) -> list[ir.Value]:
    """Addresses of the vectors of a row."""
    found = (builder.gep(row, [ir.Constant(I64, LANES * k)]) for k in range(vectors))
    return [builder.bitcast(place, VECTOR.as_pointer()) for place in found]


_KINDS_EACH = (types.UniTuple, types.Array, types.Integer, types.Array, types.Integer, types.Integer)


@lower_builtin(add_to_each, *_KINDS_EACH)
def _add_to_each(context: Context, builder: ir.IRBuilder, found: Signature, args: Values) -> ir.Value:
    entries, source = arrays(context, builder, found, args)
    kind = context.make_array(found.args[0].dtype)
    targets = [kind(context, builder, each) for each in cgutils.unpack_tuple(builder, args[0], len(found.args[0]))]
    count, start, stride = (context.cast(builder, args[k], found.args[k], types.intp) for k in (2, 4, 5))
    first, length = builder.gep(source.data, [start]), builder.extract_value(entries.shape, 1)
    factors = [builder.gep(entries.data, [builder.mul(length, ir.Constant(I64, k))]) for k in range(len(targets))]

    def columns(at: ir.Value, vectors: int) -> None:
        rows = builder.gep(first, [at])

        def grown(p: ir.Value, sums: list[ir.Value]) -> list[ir.Value]:
            row = [builder.load(each, align=8) for each in places(builder, builder.gep(rows, [builder.mul(p, stride)]), vectors)]
            spreads = [spread(builder, builder.load(builder.gep(each, [p]))) for each in factors]
            products = [builder.fmul(factor, each) for factor in spreads for each in row]
            return [builder.fadd(each, product) for each, product in zip(sums, products, strict=True)]

        sums = iter(summed(builder, len(targets) * vectors, ir.Constant(I64, 0), count, grown))
        for target in targets:
            for place in places(builder, builder.gep(target.data, [at]), vectors):
                builder.store(builder.fadd(builder.load(place, align=8), next(sums)), place, align=8)

    by_vectors(builder, builder.extract_value(targets[0].shape, 0), MOST_EACH[len(targets)], columns)
    return context.get_dummy_value()


@infer_global(subtract_multiples)
class _Multiples(AbstractTemplate):
    """Types of the arguments of `subtract_multiples`, as its code takes them."""

    def generic(self, args: tuple[types.UniTuple, ...], kws: Keywords) -> Signature | None:
        values, rows, factors, sources, _ = args
        rows, sources = (types.UniTuple(types.intp, len(each)) for each in (rows, sources))
        return types.none(values, rows, types.UniTuple(types.float64, len(factors)), sources, types.intp)


@lower_builtin(subtract_multiples, types.Array, types.UniTuple, types.UniTuple, types.UniTuple, types.Integer)
def _subtract_multiples(context: Context, builder: ir.IRBuilder, found: Signature, args: Values) -> ir.Value:
    data = context.make_array(found.args[0])(context, builder, args[0]).data
    rows, factors, sources = (cgutils.unpack_tuple(builder, args[k], len(found.args[k])) for k in (1, 2, 3))
    rows, sources = ([builder.gep(data, [each]) for each in begins] for begins in (rows, sources))
    at = cgutils.alloca_once(builder, I64)
    builder.store(ir.Constant(I64, 0), at)
    _while_enough(builder, at, args[4], rows, factors, sources)
    lanes = LANES // 2
    while lanes >= 1:
        left = builder.sub(args[4], builder.load(at))
        with builder.if_then(builder.icmp_signed(">=", left, ir.Constant(I64, lanes))):
            _subtract(builder, lanes, at, rows, factors, sources)
        lanes //= 2
    return context.get_dummy_value()


def _while_enough(builder: ir.IRBuilder, at: ir.Value, length: ir.Value, rows: Values, factors: Values, sources: Values) -> None:
    """Write code for all whole vectors of LANES numbers in the rows."""
    begin, work, end = (builder.append_basic_block(name) for name in ("multiples.begin", "multiples.work", "multiples.end"))
    builder.branch(begin)
    builder.position_at_end(begin)
    enough = builder.icmp_signed(">=", builder.sub(length, builder.load(at)), ir.Constant(I64, LANES))
    builder.cbranch(enough, work, end)
    builder.position_at_end(work)
    _subtract(builder, LANES, at, rows, factors, sources)
    builder.branch(begin)
    builder.position_at_end(end)


def _subtract(builder: ir.IRBuilder, lanes: int, at: ir.Value, rows: Values, factors: Values, sources: Values) -> None:
    """Write code that subtracts from `lanes` numbers of every row, and moves on by as many."""
    kind, now = ir.VectorType(ir.DoubleType(), lanes), builder.load(at)

    def place(row: ir.Value) -> ir.Value:
        return builder.bitcast(builder.gep(row, [now]), kind.as_pointer())

    known = [builder.load(place(source), align=8) for source in sources]
    changed = []
    for r, row in enumerate(rows):
        own = factors[r * len(sources) : (r + 1) * len(sources)]
        products = [builder.fmul(spread(builder, factor, kind), each) for factor, each in zip(own, known, strict=True)]
        total = products[0]
        for each in products[1:]:
            total = builder.fadd(total, each)
        changed.append((builder.fsub(builder.load(place(row), align=8), total), row))
    for value, row in changed:
        builder.store(value, place(row), align=8)
    builder.store(builder.add(now, ir.Constant(I64, lanes)), at)
