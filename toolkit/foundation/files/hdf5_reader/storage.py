"""Arrays: where their bytes lie, and what they are."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import prod

import numpy as np

from toolkit.foundation.files.hdf5_reader.filters import Filters, read_filters
from toolkit.foundation.files.hdf5_reader.header import DATASPACE, DATATYPE, EXTERNAL, FILTERS, LAYOUT, Header
from toolkit.foundation.files.hdf5_reader.source import UNDEFINED, Cursor, Source
from toolkit.foundation.files.hdf5_reader.types import read_shape, read_type

_COMPACT, _CONTIGUOUS, _CHUNKED = 0, 1, 2
_SINGLE, _FIXED = 1, 3
_WHOLE_EDGES, _PACKED_SINGLE = 0x01, 0x02
ELSEWHERE = "it has numbers which are not in the file, or not in a way that this program writes them in"


@dataclass(frozen=True)
class Piece:
    """A part of an array in the file; bit k of `skipped` says that filter k was not applied."""

    place: int
    size: int
    skipped: int = 0


class Array:
    """An array in a file; ValueError for every kind that this program does not write."""

    def __init__(self, source: Source, header: Header) -> None:
        self._source = source
        self.shape, self.type = read_shape(header.one(DATASPACE)), read_type(header.one(DATATYPE))
        self._filters = read_filters(header.one(FILTERS)) if header.has(FILTERS) else Filters()
        self._layout = header.one(LAYOUT)
        version, self._kind = self._layout.number(1), self._layout.number(1)
        if header.has(EXTERNAL) or version not in (3, 4) or self._kind not in (_COMPACT, _CONTIGUOUS, _CHUNKED):
            raise ValueError(ELSEWHERE)
        if self._kind == _CHUNKED:
            self._read_chunked(version)
        self._rest = self._layout.place

    def _read_chunked(self, version: int) -> None:
        """Read the shape of the pieces, and how they are found."""
        if version != 4:
            raise ValueError(ELSEWHERE)
        flags, axes, width = (self._layout.number(1) for _ in range(3))
        *self._chunk, item = (self._layout.number(width) for _ in range(axes))
        self._index = self._layout.number(1)
        self._packed_single = bool(flags & _PACKED_SINGLE)
        if len(self._chunk) != len(self.shape) or not all(self._chunk) or item != self.type.itemsize or flags & _WHOLE_EDGES:
            raise ValueError("its pieces do not fit its shape")

    @property
    def claimed(self) -> int:
        """Bytes that the array takes in memory, with the piece that is being unpacked; they need not be in the file."""
        piece = prod(self._chunk) if self._kind == _CHUNKED else 0
        return self.type.itemsize * max(prod(self.shape), piece)

    @property
    def stored_bytes(self) -> int:
        """Bytes that the array's numbers take in the file, as they are packed."""
        return sum(piece.size for piece in self._pieces)

    def read(self) -> np.ndarray:
        """Numbers of the whole array; `claimed` is to be judged before."""
        if self._kind == _CHUNKED:
            return self._assembled()
        if self._filters.numbers or sum(piece.size for piece in self._pieces) != self.type.itemsize * prod(self.shape):
            raise ValueError("its size and its shape differ")
        content = self._compact if self._kind == _COMPACT else b"".join(self._source.at(p.place, p.size) for p in self._pieces)
        return np.frombuffer(content, self.type).reshape(self.shape).copy()

    def _assembled(self) -> np.ndarray:
        found, pieces = np.empty(self.shape, self.type), self._pieces
        if not pieces:
            return found
        size, item = self.type.itemsize * prod(self._chunk), self.type.itemsize
        corners = product(*(range(0, n, c) for n, c in zip(self.shape, self._chunk, strict=True)))
        for piece, corner in zip(pieces, corners, strict=True):
            content = self._filters.undo(self._source.at(piece.place, piece.size), piece.skipped, size, item)
            part = np.frombuffer(content, self.type).reshape(self._chunk)
            inside = tuple(slice(min(c, n - at)) for c, n, at in zip(self._chunk, self.shape, corner, strict=True))
            found[tuple(slice(at, at + c) for c, at in zip(self._chunk, corner, strict=True))] = part[inside]
        return found

    @cached_property
    def _compact(self) -> bytes:
        cursor = Cursor(self._layout.content, self._rest)
        return cursor.take(cursor.number(2))

    @cached_property
    def _pieces(self) -> list[Piece]:
        """Pieces of the array in the order of their corners."""
        if self._kind == _COMPACT:
            return [Piece(0, len(self._compact))]
        rest = Cursor(self._layout.content, self._rest)
        if self._kind == _CHUNKED:
            found = list(self._chunks(rest)) if prod(self.shape) else []
        else:
            found = [Piece(rest.number(8), rest.number(8))] if prod(self.shape) else []
        if any(piece.place == UNDEFINED for piece in found) or sum(piece.size for piece in found) > self._source.size:
            raise ValueError(ELSEWHERE)
        return found

    def _chunks(self, rest: Cursor) -> Iterator[Piece]:
        count = prod(-(-n // c) for n, c in zip(self.shape, self._chunk, strict=True))
        size = prod(self._chunk) * self.type.itemsize
        if count > self._source.size:
            raise ValueError(ELSEWHERE)
        if self._index == _SINGLE and count == 1:
            packed = (rest.number(8), rest.number(4)) if self._packed_single else (size, 0)
            yield Piece(rest.number(8), *packed)
        elif self._index == _FIXED:
            rest.take(1)
            yield from self._listed(rest.number(8), count, size)
        else:
            raise ValueError(ELSEWHERE)

    def _listed(self, place: int, count: int, size: int) -> Iterator[Piece]:
        """Pieces of the array by a list, whose long form has pages with a checksum each."""
        if place == UNDEFINED:
            raise ValueError(ELSEWHERE)
        header = self._source.block(place, 28, b"FAHD")
        header.expect(0, "version of a list")
        packed = bool(self._filters.numbers)
        header.expect(int(packed), "kind of a list")
        entry, page = header.number(1), 1 << min(header.number(1), 32)
        most, block = header.number(8), header.number(8)
        if entry < 8 + 5 * packed or most != count or block == UNDEFINED:
            raise ValueError(ELSEWHERE)
        pages, paged = -(-count // page), count > page
        begin = 14 + (-(-pages // 8) if paged else count * entry) + 4
        head = self._source.block(block, begin, b"FADB")
        head.expect(0, "version of a list")
        head.expect(int(packed), "kind of a list")
        head.take(8)
        if paged and not all(head.content[14 + k // 8] >> 7 - k % 8 & 1 for k in range(pages)):
            raise ValueError(ELSEWHERE)
        for k in range(pages if paged else 1):
            here = min(page, count - k * page) if paged else count
            own = self._source.block(block + begin + k * (page * entry + 4), here * entry + 4) if paged else head
            for _ in range(here):
                place = own.number(8)
                yield Piece(place, own.number(entry - 12), own.number(4)) if packed else Piece(place, size)
