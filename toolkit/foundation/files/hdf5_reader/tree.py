"""B-trees of version 2: records in order, each in a node of its own size."""

from __future__ import annotations

from collections.abc import Iterator

from toolkit.foundation.files.hdf5_reader.source import Cursor, Source, bytes_for

HUGE, LINKS_BY_NAME, ATTRIBUTES_BY_NAME = 1, 5, 8
"""Kinds of trees by what their records are."""
_AROUND = 10  # bytes of a node besides its records: signature, version, kind, checksum


class Tree:
    """Records of a tree, found once.

    Parameters
    ----------
    place : of the tree's header
    kind : of its records
    """

    def __init__(self, source: Source, place: int, kind: int) -> None:
        header = source.block(place, 38, b"BTHD")
        header.expect(0, "version of a tree")
        header.expect(kind, "kind of a tree")
        self._source, self._kind, self._seen = source, kind, {place}
        node, self._size, depth = header.number(4), header.number(2), header.number(2)
        header.take(2)
        root, count, total = header.number(8), header.number(2), header.number(8)
        if self._size < 1 or node < _AROUND + self._size:
            raise ValueError("the records of a tree have no place in its nodes")
        self._pointers = self._sizes(node, depth)
        self.records = list(self._below(root, count, depth)) if count else []
        if len(self.records) != total:
            raise ValueError(f"a tree has {len(self.records)} instead of {total} records")

    def _sizes(self, node: int, depth: int) -> list[tuple[int, int]]:
        """Bytes of a child's number of records and of the number of all records below it, for each level above the leaves."""
        most = (node - _AROUND) // self._size
        width, below, all_below = bytes_for(most), 0, most
        found = []
        for _ in range(depth):
            found.append((width, below))
            here = (node - _AROUND - 8 - width - below) // (self._size + 8 + width + below)
            if here < 1 or all_below > self._source.size:
                raise ValueError("a tree is deeper than a file of its size")
            all_below = (here + 1) * all_below + here
            below = bytes_for(all_below)
        return found

    def _below(self, place: int, count: int, depth: int) -> Iterator[bytes]:
        if place in self._seen:
            raise ValueError("a tree leads back to itself")
        self._seen.add(place)
        records = count * self._size
        if depth == 0:
            yield from self._split(self._open(place, records, b"BTLF"), count)
            return
        width, below = self._pointers[depth - 1]
        node = self._open(place, records + (count + 1) * (8 + width + below), b"BTIN")
        own = self._split(node, count)
        children = [(node.number(8), node.number(width), node.number(below))[:2] for _ in range(count + 1)]
        for k, child in enumerate(children):
            yield from self._below(*child, depth - 1)
            yield from own[k : k + 1]

    def _open(self, place: int, size: int, signature: bytes) -> Cursor:
        node = self._source.block(place, size + _AROUND, signature)
        node.expect(0, "version of a node")
        node.expect(self._kind, "kind of a node")
        return node

    def _split(self, node: Cursor, count: int) -> list[bytes]:
        return [node.take(self._size) for _ in range(count)]
