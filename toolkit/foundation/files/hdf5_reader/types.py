"""Types and shapes of arrays: whole numbers, floating-point numbers and texts of fixed length."""

from __future__ import annotations

import numpy as np

from toolkit.foundation.files.hdf5_reader.source import Cursor, OtherForm

_WHOLE, _FLOATING, _TEXT, _VARIABLE = 0, 1, 3, 9
_NAMES = {
    2: "a time",
    4: "bits",
    5: "opaque",
    6: "records",
    7: "references",
    8: "an enumeration",
    9: "of variable length",
    10: "arrays",
}
_FORMATS = {2: (15, 10, 5, 0, 10, 15), 4: (31, 23, 8, 0, 23, 127), 8: (63, 52, 11, 0, 52, 1023)}
"""Bytes -> sign's place, exponent's place and bits, mantissa's place and bits, bias: floating-point numbers of IEEE 754."""
_SCALAR, _SIMPLE = 0, 1


def read_type(message: Cursor) -> np.dtype:
    """Type of an array; ValueError if it is not one of numbers of at most 8 bytes or texts."""
    kind, bits, size = message.number(1) & 0x0F, message.number(3), message.number(4)
    if kind == _TEXT and size:
        return np.dtype(f"S{size}")
    if kind == _WHOLE and size in (1, 2, 4, 8):
        offset, precision = message.number(2), message.number(2)
        if bits & ~0x09 == 0 and (offset, precision) == (0, 8 * size):
            return np.dtype(f"{'>' if bits & 1 else '<'}{'i' if bits & 8 else 'u'}{size}")
    elif kind == _FLOATING and size in _FORMATS:
        offset, precision = message.number(2), message.number(2)
        layout = tuple(message.number(1) for _ in range(4))
        found = (bits >> 8 & 0xFF, *layout, message.number(4))
        if bits & 0xFE == 0x20 and (offset, precision) == (0, 8 * size) and found == _FORMATS[size]:
            return np.dtype(f"{'>' if bits & 1 else '<'}f{size}")
    error = OtherForm if kind == _VARIABLE else ValueError
    raise error(f"it is {_NAMES.get(kind, 'of a foreign kind')} instead of numbers")


def read_shape(message: Cursor) -> tuple[int, ...]:
    """Number of entries along each axis; none for a single number."""
    version, rank, _ = message.number(1), message.number(1), message.number(1)
    if version != 2:
        raise OtherForm(f"version of a shape is {version} instead of 2")
    kind = message.number(1)
    if kind not in (_SCALAR, _SIMPLE) or (kind == _SCALAR and rank):
        raise ValueError("it is empty")
    return tuple(message.number(8) for _ in range(rank))
