"""Bytes of an HDF5 file: no place outside of the file, no block whose checksum is wrong."""

from __future__ import annotations

import struct
from typing import BinaryIO

UNDEFINED = 2**64 - 1
"""Address of what is not there."""
MOST_CHECKED = 2**26
"""Bytes of the file's own structures that are checked at most, which takes some ten seconds; none of ours has a tenth of that."""
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
        if not content.startswith(signature) or len(stored) < 4 or checksum(covered) != int.from_bytes(stored, "little"):
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
