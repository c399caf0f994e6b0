"""HDF5 read in Python, as far as the program writes it: bytes, headers, trees and types, which nobody can trust.

Bytes never reach compiled code that trusts them. No library is that guard: HDF5's own, below h5py, follows wrong sizes and addresses out of
its memory where their checksums are right (30 of 6000 such files ended the process), and pyfive 1.3 reads no arrays in the pieces of
HDF5 1.10, which our files are made of.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import BinaryIO

import numpy as np

UNDEFINED = 2**64 - 1
"""Address of what is not there."""
MOST_CHECKED = 2**26
"""Bytes of the file's own structures that are checked at most, which takes some ten seconds; none of ours has a tenth of that."""
LARGEST_KEPT_STRUCTURE = 4096
"""Bytes of a structure up to which its checksum is kept: a run reads a model several times, and models of one kind have some alike."""
_WORD = 0xFFFFFFFF


class OtherForm(ValueError):
    """Error of a part of the file that has a form which this program never writes, though HDF5 knows it.

    Another program may have written it.
    """


class Source:
    """An open file, read in pieces; every method raises ValueError for what cannot be.

    Parameters
    ----------
    file : opened in binary mode
    size : of the file, in bytes
    """

    def __init__(self, file: BinaryIO, size: int) -> None:
        self._file = file
        self.size = size
        self._left = MOST_CHECKED

    def at(self, place: int, count: int) -> bytes:
        """Bytes of the file, so many from a place on."""
        if count > self.size or place > self.size - count:
            raise ValueError("it refers to places outside of itself")
        self._file.seek(place)
        found = self._file.read(count)
        if len(found) < count:
            raise ValueError("it became shorter while it was read")
        return found

    def block(self, place: int, count: int, signature: bytes = b"", hole: int | None = None) -> Cursor:
        """Content of a block that ends with its checksum, behind its signature.

        Parameters
        ----------
        hole : place of the checksum, where it is not the end: there it counts as zeros
        """
        self._left -= count
        if self._left < 0:
            raise ValueError("its structures are larger than those of any file that this program writes")
        content = self.at(place, count)
        end = count - 4 if hole is None else hole
        stored = content[end : end + 4]
        covered = content[:end] if hole is None else content[:end] + bytes(4) + content[end + 4 :]
        found = _known_checksum if count <= LARGEST_KEPT_STRUCTURE else checksum
        if not content.startswith(signature) or len(stored) < 4 or found(covered) != int.from_bytes(stored, "little"):
            raise ValueError("a checksum is wrong")
        return Cursor(content if hole is not None else covered, len(signature))


class Cursor:
    """Bytes that are read one number after the other."""

    def __init__(self, content: bytes, place: int = 0) -> None:
        self.content, self.place = content, place

    def take(self, count: int) -> bytes:
        """Next bytes, so many."""
        end = self.place + count
        if end > len(self.content):
            raise ValueError("a structure ends too early")
        found = self.content[self.place : end]
        self.place = end
        return found

    def number(self, size: int) -> int:
        """Next number without a sign, of so many bytes."""
        return int.from_bytes(self.take(size), "little")

    def expect(self, value: int, what: str) -> None:
        """Refuse another value of the next byte: another version, or another kind of thing."""
        if (found := self.number(1)) != value:
            raise ValueError(f"{what} is {found} instead of {value}")

    @property
    def left(self) -> int:
        """Number of bytes that were not read yet."""
        return len(self.content) - self.place


def bytes_for(largest: int) -> int:
    """Number of bytes that hold every number up to the largest one."""
    return max(1, (largest.bit_length() + 7) // 8)


@lru_cache(maxsize=2048)
def _known_checksum(content: bytes) -> int:
    return checksum(content)


def checksum(content: bytes) -> int:
    """Checksum of HDF5's structures: `lookup3` by Bob Jenkins, byte by byte in its own order."""
    size = len(content)
    padded = content + bytes(-size % 12)
    words = struct.unpack(f"<{len(padded) // 4}I", padded)
    a = b = c = (0xDEADBEEF + size) & _WORD
    if not size:
        return c
    last = len(words) - 3
    for k in range(0, last, 3):
        a, b, c = a + words[k], b + words[k + 1], (c + words[k + 2]) & _WORD
        a = (a - c & _WORD) ^ (c << 4 & _WORD | c >> 28)
        c = c + b & _WORD
        b = (b - a & _WORD) ^ (a << 6 & _WORD | a >> 26)
        a = a + c & _WORD
        c = (c - b & _WORD) ^ (b << 8 & _WORD | b >> 24)
        b = b + a & _WORD
        a = (a - c & _WORD) ^ (c << 16 & _WORD | c >> 16)
        c = c + b & _WORD
        b = (b - a & _WORD) ^ (a << 19 & _WORD | a >> 13)
        a = a + c & _WORD
        c = (c - b & _WORD) ^ (b << 4 & _WORD | b >> 28)
        b = b + a & _WORD
    a, b, c = a + words[last] & _WORD, b + words[last + 1] & _WORD, c + words[last + 2] & _WORD
    c = (c ^ b) - (b << 14 & _WORD | b >> 18) & _WORD
    a = (a ^ c) - (c << 11 & _WORD | c >> 21) & _WORD
    b = (b ^ a) - (a << 25 & _WORD | a >> 7) & _WORD
    c = (c ^ b) - (b << 16 & _WORD | b >> 16) & _WORD
    a = (a ^ c) - (c << 4 & _WORD | c >> 28) & _WORD
    b = (b ^ a) - (a << 14 & _WORD | a >> 18) & _WORD
    return (c ^ b) - (b << 24 & _WORD | b >> 8) & _WORD


DATASPACE, LINK_INFO, DATATYPE, LINK, EXTERNAL, LAYOUT, FILTERS, ATTRIBUTE, CONTINUATION, SYMBOLS, ATTRIBUTE_INFO = (
    *(0x01, 0x02, 0x03, 0x06, 0x07, 0x08, 0x0B, 0x0C, 0x10, 0x11, 0x15),
)
"""Kinds of messages that are understood; others say how an object came about, not what it is."""
_READ = {DATASPACE, LINK_INFO, DATATYPE, LINK, LAYOUT, FILTERS, ATTRIBUTE, CONTINUATION, ATTRIBUTE_INFO}
_TIMES, _PHASES, _ORDERED = 0x20, 0x10, 0x04
_SHARED, _MUST_BE_KNOWN = 0x02, 0x88
_LAST_KNOWN = 0x18


@dataclass(frozen=True)
class Message:
    """One message of a header: its kind, its content and its order.

    Parameters
    ----------
    order : which of its kind it was when it was made, if the file keeps that
    """

    kind: int
    content: bytes
    order: int


@dataclass(frozen=True)
class Header:
    """All messages of an object; with `ordered` its attributes are listed in the order in which they were made."""

    messages: tuple[Message, ...]
    ordered: bool

    def all(self, kind: int) -> list[Message]:
        """Messages of a kind that the header has."""
        return [each for each in self.messages if each.kind == kind]

    def has(self, kind: int) -> bool:
        """Whether the header has a message of a kind."""
        return any(each.kind == kind for each in self.messages)

    def one(self, kind: int) -> Cursor:
        """Content of the message of a kind of which there is one only."""
        found = self.all(kind)
        if len(found) != 1:
            raise ValueError(f"an object has {len(found)} messages of kind {kind} instead of one")
        return Cursor(found[0].content)


def read_header(source: Source, place: int) -> Header:
    """Header of the object at a place of the file, with all its continuations."""
    start = Cursor(source.at(place, min(64, source.size - place) if place < source.size else 64))
    if start.take(4) != b"OHDR":
        raise OtherForm("what stands there was written by another program, in a format without checksums")
    start.expect(2, "version of a header")
    flags = start.number(1)
    start.take((16 if flags & _TIMES else 0) + (4 if flags & _PHASES else 0))
    size = start.number(1 << (flags & 3))
    block = source.block(place, start.place + size + 4)
    block.take(start.place)
    messages, blocks, seen = [], [block], {place}
    while blocks:
        for each in _messages(blocks.pop(), bool(flags & _ORDERED)):
            messages.append(each)
            if each.kind == CONTINUATION:
                where = Cursor(each.content)
                next_place, count = where.number(8), where.number(8)
                if next_place in seen:
                    raise ValueError("a header continues in itself")
                seen.add(next_place)
                blocks.append(source.block(next_place, count, b"OCHK"))
    if any(each.kind == SYMBOLS for each in messages):
        raise OtherForm("a group was written by another program, in a format without checksums")
    return Header(tuple(messages), bool(flags & _ORDERED))


def _messages(block: Cursor, ordered: bool) -> list[Message]:
    """Messages of one block; what is left at its end is too short for one."""
    found = []
    while block.left >= (6 if ordered else 4):
        kind, size, flags = block.number(1), block.number(2), block.number(1)
        order = block.number(2) if ordered else 0
        content = block.take(size)
        if (kind in _READ and flags & _SHARED) or (kind > _LAST_KNOWN and flags & _MUST_BE_KNOWN):
            raise ValueError("an object has a part that lies elsewhere, or is of an unknown kind")
        found.append(Message(kind, content, order))
    return found


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
