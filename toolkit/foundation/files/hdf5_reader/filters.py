"""Filters of an array on its way into the file, and how they are undone."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np

from toolkit.foundation.files.hdf5_reader.source import Cursor

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
