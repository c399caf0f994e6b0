"""Compiled code of `rows`: told to numba.

Columns by 32, as many vectors as are left: their sums stay in registers, and every factor is read once for all of them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.np.arrayobj import make_array

from toolkit.foundation.vectors.rows import LANES, add_rows

MOST = 4
"""Vectors whose sums are kept at once."""


@infer_global(add_rows)
class _AddRows(AbstractTemplate):
    key = add_rows

    def generic(self, args: Any, kws: Any) -> Any:
        return signature(types.none, *args)


I64, VECTOR = ir.IntType(64), ir.VectorType(ir.DoubleType(), LANES)
_KINDS = (types.Array, types.Float, types.Float, types.Array, types.Array, types.Integer, types.Integer, types.Array)


@lower_builtin(add_rows, *_KINDS)
def _add_rows(context: Any, builder: Any, found: Any, args: Any) -> Any:
    target, entries, numbers, source = arrays(context, builder, found, args)
    first, last = (context.cast(builder, args[k], found.args[k], types.intp) for k in (5, 6))
    width = builder.extract_value(target.shape, 0)

    def columns(at: Any, vectors: int) -> None:
        row, rows = (builder.gep(each.data, [at]) for each in (target, source))
        sums = _sums(builder, vectors, entries.data, numbers.data, first, last, rows, width)
        scale, factor = (spread(builder, args[k]) for k in (1, 2))
        for place, total in zip(places(builder, row, vectors), sums, strict=True):
            changed = builder.fadd(builder.load(place, align=8), builder.fmul(factor, total))
            builder.store(builder.fmul(scale, changed), place, align=8)

    by_vectors(builder, width, MOST, columns)
    return context.get_dummy_value()


def arrays(context: Any, builder: Any, found: Any, args: Any) -> list[Any]:
    """Arrays among the arguments of a compiled call."""
    kinds = enumerate(found.args)
    return [make_array(kind)(context, builder, args[k]) for k, kind in kinds if isinstance(kind, types.Array)]


def by_vectors(builder: Any, width: Any, most: int, columns: Callable[[Any, int], None]) -> None:
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


def _sums(builder: Any, vectors: int, entries: Any, numbers: Any, first: Any, last: Any, source: Any, width: Any) -> list[Any]:
    """Write code for the sums of multiples of rows, in so many vectors."""

    def grown(p: Any, sums: list[Any]) -> list[Any]:
        number = builder.load(builder.gep(numbers, [p]))
        number = builder.zext(number, I64) if number.type.width < I64.width else number
        row = places(builder, builder.gep(source, [builder.mul(number, width)]), vectors)
        entry = spread(builder, builder.load(builder.gep(entries, [p])))
        return [
            builder.fadd(each, builder.fmul(entry, builder.load(place, align=8))) for each, place in zip(sums, row, strict=True)
        ]

    return summed(builder, vectors, first, last, grown)


def summed(builder: Any, count: int, first: Any, last: Any, grown: Callable[[Any, list[Any]], list[Any]]) -> list[Any]:
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


def spread(builder: Any, value: Any, kind: Any = VECTOR) -> Any:
    """Vector of a kind with one number in all its lanes."""
    nothing, lanes = ir.Constant(kind, ir.Undefined), ir.Constant(ir.VectorType(ir.IntType(32), kind.count), [0] * kind.count)
    return builder.shuffle_vector(builder.insert_element(nothing, value, ir.Constant(ir.IntType(32), 0)), nothing, lanes)


def places(builder: Any, row: Any, vectors: int) -> list[Any]:
    """Addresses of the vectors of a row."""
    found = (builder.gep(row, [ir.Constant(I64, LANES * k)]) for k in range(vectors))
    return [builder.bitcast(place, VECTOR.as_pointer()) for place in found]
