"""Groups, arrays and attributes of a file by their names."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import prod
from typing import Any

import numpy as np

from toolkit.foundation.files.hdf5_source import (
    ATTRIBUTE,
    ATTRIBUTE_INFO,
    ATTRIBUTES_BY_NAME,
    LAYOUT,
    LINK,
    LINK_INFO,
    LINKS_BY_NAME,
    UNDEFINED,
    Cursor,
    Header,
    OtherForm,
    Source,
    Tree,
    read_header,
    read_shape,
    read_type,
)
from toolkit.foundation.files.hdf5_storage import Array, Heap

SIGNATURE, OLDEST = b"\x89HDF\r\n\x1a\n", 3
"""First bytes of every HDF5 file, and behind them the number of its format, of which this is the first that has checksums."""
FORMAT = ("v110", "v110")
"""Format for the library when it writes: from this version on a flipped bit is noticed and not followed."""
SQUEEZED, MOST_BYTES = 1100, 2**34
"""Most that HDF5's compression makes of a byte, with a little to spare, and most that all arrays of a file can be: a file that claims
more was never written."""
_ORDERED = 0x01
_HARD = 0


@dataclass(frozen=True)
class Link:
    """A name in a group, with the place of its object.

    The place is None if the object lies in another file, or is found by another name.
    """

    name: str
    place: int | None
    order: int


class Group:
    """Objects and attributes by their names."""

    def __init__(self, source: Source, header: Header) -> None:
        self._source, self._header = source, header

    @cached_property
    def links(self) -> dict[str, Link]:
        """Links of the group, in the order in which they were made if the file keeps that, by name otherwise."""
        info = self._header.one(LINK_INFO)
        info.expect(0, "version of a group")
        flags = info.number(1)
        info.take(8 if flags & _ORDERED else 0)
        heap, tree = info.number(8), info.number(8)
        contents = [message.content for message in self._header.all(LINK)]
        if heap != UNDEFINED:
            names = Heap(self._source, heap)
            contents += [names.object(record[4:]) for record in Tree(self._source, tree, LINKS_BY_NAME).records]
        found = [_link(Cursor(content)) for content in contents]
        return _by_name([(link.name, link.order, link) for link in found], bool(flags & _ORDERED))

    @property
    def in_order(self) -> bool:
        """Whether the file keeps the order in which its attributes were made."""
        return self._header.ordered

    @cached_property
    def attributes(self) -> dict[str, bytes]:
        """Content of each attribute as the file holds it, in the order of `links`."""
        found = [(_attribute_name(message.content), message.order, message.content) for message in self._header.all(ATTRIBUTE)]
        if self._header.has(ATTRIBUTE_INFO):
            info = self._header.one(ATTRIBUTE_INFO)
            info.expect(0, "version of a list of attributes")
            flags = info.number(1)
            info.take(2 if flags & _ORDERED else 0)
            heap, tree = info.number(8), info.number(8)
            if heap != UNDEFINED:
                kept = Heap(self._source, heap)
                for record in Tree(self._source, tree, ATTRIBUTES_BY_NAME).records:
                    content = kept.object(record[:8])
                    found.append((_attribute_name(content), int.from_bytes(record[9:13], "little"), content))
        return _by_name(found, self._header.ordered)

    def attribute(self, name: str) -> str | int | float:
        """Value of an attribute: a number, or a text of fixed length.

        The place where HDF5 keeps texts of variable length has no checksum.
        """
        if name not in self.attributes:
            raise ValueError(f"it lacks the attribute {name}")
        cursor = Cursor(self.attributes[name])
        cursor.expect(3, "version of an attribute")
        shared, sizes = cursor.number(1), [cursor.number(2) for _ in range(3)]
        cursor.take(1)
        _, kind, space = (Cursor(cursor.take(size)) for size in sizes)
        try:
            dtype, shape = read_type(kind), read_shape(space)
            if shared or shape:
                error = OtherForm if not shared and prod(shape) == 1 else ValueError
                raise error("it is many, or its type lies elsewhere")
        except ValueError as error:
            raise type(error)(f"the attribute {name} is neither a number nor a text of fixed length: {error}") from error
        value: Any = np.frombuffer(cursor.take(dtype.itemsize), dtype)[0]
        return value.decode() if isinstance(value, bytes) else value.item()


class File(Group):
    """The root of a file, whose other objects are read when they are asked for, and once."""

    def __init__(self, source: Source) -> None:
        start = source.at(0, len(SIGNATURE) + 1)
        if not start.startswith(SIGNATURE):
            raise ValueError("it is no HDF5 file")
        if start[-1] != OLDEST:
            raise OtherForm("it was written by another program or another version of this one, in a format without checksums")
        block = source.block(0, 48, SIGNATURE)
        block.take(1)
        sizes, base, _, end, root = block.take(3), *(block.number(8) for _ in range(4))
        if sizes != b"\x08\x08\0" or base:
            raise ValueError("it has addresses of another kind, or was not closed by the program that wrote it")
        if end > source.size:
            raise ValueError(f"it is truncated: {source.size} of its {end} bytes are there")
        self._objects: dict[int, Group | Array] = {}
        super().__init__(source, read_header(source, root))
        self._objects[root] = self

    def object(self, place: int) -> Group | Array:
        """Group or array at a place of the file."""
        if place not in self._objects:
            header = read_header(self._source, place)
            self._objects[place] = (Array if header.has(LAYOUT) else Group)(self._source, header)
        return self._objects[place]


def _link(content: Cursor) -> Link:
    content.expect(1, "version of a link")
    flags = content.number(1)
    kind = content.number(1) if flags & 0x08 else _HARD
    order = content.number(8) if flags & 0x04 else 0
    content.take(1 if flags & 0x10 else 0)
    name = content.take(content.number(1 << (flags & 3))).decode()
    return Link(name, content.number(8) if kind == _HARD else None, order)


def _attribute_name(content: bytes) -> str:
    cursor = Cursor(content)
    cursor.take(2)
    size = cursor.number(2)
    cursor.take(5)
    return cursor.take(size).rstrip(b"\0").decode()


def _by_name(found: list[tuple[str, int, Any]], ordered: bool) -> dict[str, Any]:
    """Things by their names, in the order in which they were made or of their names."""
    named = {name: thing for name, _, thing in sorted(found, key=lambda each: each[1] if ordered else each[0].encode())}
    if len(named) < len(found):
        raise ValueError("it has the same name twice")
    return named
