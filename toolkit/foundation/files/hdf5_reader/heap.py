"""Fractal heaps: where the names of large groups and large attributes lie."""

from __future__ import annotations

from collections.abc import Iterator

from toolkit.foundation.files.hdf5_reader.source import UNDEFINED, Cursor, Source, bytes_for
from toolkit.foundation.files.hdf5_reader.tree import HUGE, Tree

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
