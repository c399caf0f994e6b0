"""Headers of objects: what a group or an array is, as a list of messages."""

from __future__ import annotations

from dataclasses import dataclass

from toolkit.foundation.files.hdf5_reader.source import Cursor, OtherForm, Source

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
