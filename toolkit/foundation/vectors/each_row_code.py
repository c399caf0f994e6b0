"""Compiled code of `rows.add_to_each`: told to numba. The sums of all rows stay in registers."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.np.arrayobj import make_array

from toolkit.foundation.vectors.rows import add_to_each
from toolkit.foundation.vectors.rows_code import I64, arrays, by_vectors, places, spread, summed

MOST = {1: 4, 2: 2, 3: 2}
"""Vectors of each row whose sums are kept at once, for so many rows."""


@infer_global(add_to_each)
class _AddToEach(AbstractTemplate):
    key = add_to_each

    def generic(self, args: Any, kws: Any) -> Any:
        return signature(types.none, *args)


_KINDS = (types.UniTuple, types.Array, types.Integer, types.Array, types.Integer, types.Integer)


@lower_builtin(add_to_each, *_KINDS)
def _add_to_each(context: Any, builder: Any, found: Any, args: Any) -> Any:
    entries, source = arrays(context, builder, found, args)
    kind = make_array(found.args[0].dtype)
    targets = [kind(context, builder, each) for each in cgutils.unpack_tuple(builder, args[0], len(found.args[0]))]
    count, start, stride = (context.cast(builder, args[k], found.args[k], types.intp) for k in (2, 4, 5))
    first, length = builder.gep(source.data, [start]), builder.extract_value(entries.shape, 1)
    factors = [builder.gep(entries.data, [builder.mul(length, ir.Constant(I64, k))]) for k in range(len(targets))]

    def columns(at: Any, vectors: int) -> None:
        rows = builder.gep(first, [at])

        def grown(p: Any, sums: list[Any]) -> list[Any]:
            row = [builder.load(each, align=8) for each in places(builder, builder.gep(rows, [builder.mul(p, stride)]), vectors)]
            spreads = [spread(builder, builder.load(builder.gep(each, [p]))) for each in factors]
            products = [builder.fmul(factor, each) for factor in spreads for each in row]
            return [builder.fadd(each, product) for each, product in zip(sums, products, strict=True)]

        sums = iter(summed(builder, len(targets) * vectors, ir.Constant(I64, 0), count, grown))
        for target in targets:
            for place in places(builder, builder.gep(target.data, [at]), vectors):
                builder.store(builder.fadd(builder.load(place, align=8), next(sums)), place, align=8)

    by_vectors(builder, builder.extract_value(targets[0].shape, 0), MOST[len(targets)], columns)
    return context.get_dummy_value()
