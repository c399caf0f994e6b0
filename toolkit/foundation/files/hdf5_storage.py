"""Arrays of an HDF5 file: where their bytes lie, filters on their way, and the heaps of large groups and attributes."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import prod

import numpy as np

from toolkit.foundation.files.hdf5_source import (
    DATASPACE,
    DATATYPE,
    EXTERNAL,
    FILTERS,
    HUGE,
    LAYOUT,
    UNDEFINED,
    Cursor,
    Header,
    Source,
    Tree,
    bytes_for,
    read_shape,
    read_type,
)

DEFLATE, SHUFFLE, FLETCHER32 = 1, 2, 3
_OLDEST_NAMED = 256


@dataclass(frozen=True)
class Filters:
    """Filters in the order in which they were applied, each by its number.

    Raises
    ------
    ValueError
        One of them is not known, or stands there twice, with which a file can claim a million times its size.
    """

    numbers: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        if not set(self.numbers) <= {DEFLATE, SHUFFLE, FLETCHER32} or len(set(self.numbers)) < len(self.numbers):
            raise ValueError("it is packed in a way that this program does not pack in")

    def undo(self, content: bytes, skipped: int, size: int, item: int) -> bytes:
        """Bytes that a piece of an array was before the filters were applied.

        Parameters
        ----------
        skipped : bit k says that filter k was not applied
        size, item : bytes of the whole piece and of each of its entries
        """
        for k in reversed(range(len(self.numbers))):
            if not skipped >> k & 1:
                content = _undone(self.numbers[k], content, size, item)
        if len(content) != size:
            raise ValueError(f"a piece of it has {len(content)} bytes instead of {size}")
        return content


def read_filters(message: Cursor) -> Filters:
    """Filters of an array, from their message."""
    message.expect(2, "version of the list of filters")
    numbers = []
    for _ in range(message.number(1)):
        number = message.number(2)
        name = message.number(2) if number >= _OLDEST_NAMED else 0
        message.take(2)
        message.take(4 * message.number(2) + name)
        numbers.append(number)
    return Filters(tuple(numbers))


def _undone(number: int, content: bytes, size: int, item: int) -> bytes:
    if number == FLETCHER32:
        if len(content) < 4 or fletcher32(content[:-4]) != int.from_bytes(content[-4:], "little"):
            raise ValueError("a checksum is wrong")
        return content[:-4]
    if number == DEFLATE:
        return _inflated(content, size + 4)  # a checksum may be among what was packed
    whole = len(content) // item * item
    return np.frombuffer(content[:whole], np.uint8).reshape(item, -1).T.tobytes() + content[whole:]


def _inflated(content: bytes, most: int) -> bytes:
    unpacker = zlib.decompressobj()
    try:
        found = unpacker.decompress(content, most)
    except zlib.error as error:
        raise ValueError(f"a piece of it cannot be unpacked: {error}") from error
    if not unpacker.eof:
        raise ValueError("a piece of it unpacks to more than its size, or is cut off")
    return found


def fletcher32(content: bytes) -> int:
    """Fletcher's checksum of words of two bytes, the larger one first; a sum is 65535 where it could be zero, unless all words are."""
    words = np.frombuffer(content + bytes(len(content) % 2), ">u2").astype(np.int64)
    if not words.any():
        return 0
    weights = np.arange(len(words), 0, -1) % 0xFFFF
    low, high = int(words.sum()) % 0xFFFF or 0xFFFF, int(words @ weights) % 0xFFFF or 0xFFFF
    return high << 16 | low


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


_MANAGED, _HUGE, _TINY = 0, 1, 2
_CHECKED = 0x02  # flag: direct blocks have checksums


class Heap:
    """Objects by their numbers, in blocks that double in size.

    Parameters
    ----------
    place : of the heap's header
    """

    def __init__(self, source: Source, place: int) -> None:
        self._source = source
        header = source.block(place, 146, b"FRHP")
        header.expect(0, "version of a heap")
        self._id_size = header.number(2)
        filters, flags, self._most = header.number(2), header.number(1), header.number(4)
        header.take(8)
        self._huge_tree = header.number(8)
        header.take(80)
        self._width, self._start, self._largest = header.number(2), header.number(8), header.number(8)
        bits = header.number(2)
        header.take(2)
        root, rows = header.number(8), header.number(2)
        if filters or not flags & _CHECKED or not 0 < bits <= 64:
            raise ValueError("a heap is packed, or has no checksums")
        if not (self._start and self._largest >= self._start and self._width) or rows > bits:
            raise ValueError("a heap has blocks of impossible sizes")
        self._offset_size, self._length_size = (bits + 7) // 8, bytes_for(min(self._largest - 1, self._most))
        self._seen: set[int] = set()
        self._huge: dict[int, tuple[int, int]] | None = None
        self._blocks = sorted(self._direct(root, 0, rows, self._start), key=lambda block: block[0]) if root != UNDEFINED else []

    def object(self, number: bytes) -> bytes:
        """Bytes of the object with a number."""
        cursor = Cursor(number)
        flags = cursor.number(1)
        kind = flags >> 4 & 3
        if kind == _TINY and self._id_size <= 17:
            return cursor.take((flags & 0x0F) + 1)
        if kind == _HUGE:
            place, size = self._huge_at(cursor.number(min(cursor.left, 8)))
            return self._source.at(place, size)
        if kind == _MANAGED:
            offset, size = cursor.number(self._offset_size), cursor.number(self._length_size)
            for start, content in self._blocks:
                if start <= offset and offset + size <= start + len(content):
                    return content[offset - start : offset - start + size]
        raise ValueError("a heap lacks an object")

    def _huge_at(self, number: int) -> tuple[int, int]:
        """Place and size of an object that has no place in the blocks."""
        if self._huge is None:
            self._huge = {}
            for record in Tree(self._source, self._huge_tree, HUGE).records:
                cursor = Cursor(record)
                place, size, own = cursor.number(8), cursor.number(8), cursor.number(8)
                self._huge[own] = place, size
        if number not in self._huge:
            raise ValueError("a heap lacks an object")
        return self._huge[number]

    def _direct(self, place: int, start: int, rows: int, size: int) -> Iterator[tuple[int, bytes]]:
        """Start within the heap and content of all direct blocks below a block of so many rows.

        A block of no rows is direct itself.
        """
        if place in self._seen:
            raise ValueError("a heap leads back to itself")
        self._seen.add(place)
        if rows == 0:
            yield start, self._block(place, start, size)
            return
        entries = self._width * rows
        block = self._source.block(place, 4 + 1 + 8 + self._offset_size + 8 * entries + 4, b"FHIB")
        self._check(block, start)
        for entry in range(entries):
            row, column = divmod(entry, self._width)
            own = self._start << max(row - 1, 0)
            child = block.number(8)
            if child != UNDEFINED:
                first = start + (own * self._width if row else 0) + own * column
                yield from self._direct(child, first, self._rows_of(own), own)

    def _rows_of(self, size: int) -> int:
        """Number of rows of an indirect block that covers so many bytes; zero for a block that is direct."""
        return 0 if size <= self._largest else (size // (self._start * self._width)).bit_length()

    def _block(self, place: int, start: int, size: int) -> bytes:
        hole = 4 + 1 + 8 + self._offset_size
        block = self._source.block(place, size, b"FHDB", hole)
        self._check(block, start)
        return block.content

    def _check(self, block: Cursor, start: int) -> None:
        block.expect(0, "version of a block")
        block.take(8)
        if block.number(self._offset_size) != start:
            raise ValueError("a block of a heap lies at another place than it says")
