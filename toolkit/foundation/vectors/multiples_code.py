"""Compiled code of `rows.subtract_multiples`: told to numba. Eight numbers at a time, and what is left by four, two and one."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.np.arrayobj import make_array

from toolkit.foundation.vectors.rows import LANES, subtract_multiples
from toolkit.foundation.vectors.rows_code import I64, spread


@infer_global(subtract_multiples)
class _SubtractMultiples(AbstractTemplate):
    key = subtract_multiples

    def generic(self, args: Any, kws: Any) -> Any:
        values, rows, factors, sources, _ = args
        rows, sources = (types.UniTuple(types.intp, len(each)) for each in (rows, sources))
        return signature(types.none, values, rows, types.UniTuple(types.float64, len(factors)), sources, types.intp)


@lower_builtin(subtract_multiples, types.Array, types.UniTuple, types.UniTuple, types.UniTuple, types.Integer)
def _subtract_multiples(context: Any, builder: Any, found: Any, args: Any) -> Any:
    data = make_array(found.args[0])(context, builder, args[0]).data
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


def _while_enough(builder: Any, at: Any, length: Any, rows: Any, factors: Any, sources: Any) -> None:
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


def _subtract(builder: Any, lanes: int, at: Any, rows: Any, factors: Any, sources: Any) -> None:
    """Write code that subtracts from `lanes` numbers of every row, and moves on by as many."""
    kind, now = ir.VectorType(ir.DoubleType(), lanes), builder.load(at)

    def place(row: Any) -> Any:
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
