"""Sections of a .msh file of gmsh, and the numbers in them, as text or binary."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from preprocessing.foreign_files.meshes.numbers_of_text import numbers_of_text, whole_numbers
from preprocessing.foreign_files.meshes.wrong_file import wrong_file
from toolkit.foundation.errors import InputError

REMEDY = "Save it again with gmsh, as MSH 4.1 or 2.2."
HEAD = re.compile(rb"\$([A-Za-z0-9_]{1,40})[ \t\r]*(?:\n|$)")


class Section(NamedTuple):
    """Section of a file, between `$Name` and `$EndName`."""

    name: str
    line: int  # of its first line; 0 in a binary file
    body: bytes


def sections(path: Path, content: bytes, binary: bool) -> list[Section]:
    """All sections of a file in their order.

    Raises
    ------
    InputError
        A section has no end, or something stands outside of sections.
    """
    found: list[Section] = []
    at, line = 0, 1
    while at < len(content):
        after = _next_line(content, at)
        if content[at:after].strip():
            head = HEAD.match(content, at)
            if head is None:
                raise wrong_file(path, "a line stands outside of all sections", REMEDY, 0 if binary else line)
            end, after = _end(path, content, head, 0 if binary else line)
            found.append(Section(head[1].decode(), 0 if binary else line + 1, content[head.end() : end]))
        line += 0 if binary else content.count(b"\n", at, after)
        at = after
    return found


def _next_line(content: bytes, at: int) -> int:
    """Position at which the next line begins."""
    end = content.find(b"\n", at)
    return len(content) if end < 0 else end + 1


def _end(path: Path, content: bytes, head: re.Match[bytes], line: int) -> tuple[int, int]:
    """Positions at which the body of a section ends, and at which the line after the section begins."""
    for mark in (b"$End" + head[1], b"$END" + head[1]):  # the second in the first version
        at = content.find(b"\n" + mark, head.end() - 1)
        if at >= 0:
            return max(at, head.end()), _next_line(content, at + 1)
    raise wrong_file(path, "a section has no end, so that the file is not whole", REMEDY, line)


class Numbers(Protocol):
    """Numbers of a section, which are taken one after the other."""

    def whole(self, n: int, kind: str = "int") -> np.ndarray:
        """The next n whole numbers, each an `int` or a `size` of gmsh."""

    def real(self, n: int) -> np.ndarray:
        """The next n real numbers."""

    def finish(self) -> None:
        """Refuse numbers that are left."""


class TextNumbers:
    """The numbers of a section of text."""

    def __init__(self, path: Path, section: Section) -> None:
        self.path, self.section, self.at = path, section, 0
        self.values = numbers_of_text(path, section.body, section.line, REMEDY)

    def real(self, n: int) -> np.ndarray:
        """The next n numbers."""
        if not 0 <= n <= len(self.values) - self.at:
            raise short(self.path, self.section)
        self.at += n
        return self.values[self.at - n : self.at]

    def table(self, n: int, width: int) -> np.ndarray:
        """The next n rows of so many numbers."""
        return self.real(n * width).reshape(n, width)

    def whole(self, n: int, kind: str = "int") -> np.ndarray:
        """The next n numbers, which have to be whole."""
        return self.as_whole(self.real(n))

    def as_whole(self, found: np.ndarray) -> np.ndarray:
        """Numbers that have to be whole."""
        return whole_numbers(self.path, found, REMEDY, self.section.line)

    def finish(self) -> None:
        """Refuse numbers that are left."""
        if self.at < len(self.values):
            raise wrong_file(self.path, f"${self.section.name} holds more numbers than it says", REMEDY)


class BinaryNumbers:
    """The numbers of a binary section; `size` is the number of bytes of a size, `order` that of bytes, "<" or ">"."""

    def __init__(self, path: Path, section: Section, size: int, order: str) -> None:
        self.path, self.section, self.at = path, section, 0
        self.types = {"int": f"{order}i4", "size": f"{order}i{size}", "real": f"{order}f8"}

    def real(self, n: int) -> np.ndarray:
        """The next n doubles."""
        return self._next(n, np.dtype(self.types["real"])).astype(float)

    def whole(self, n: int, kind: str = "int") -> np.ndarray:
        """The next n whole numbers of a kind."""
        return self._next(n, np.dtype(self.types[kind])).astype(np.int64)

    def rows(self, n: int, fields: list[tuple[str, str, tuple[int, ...]]]) -> np.ndarray:
        """The next n records, whose fields have a name, a kind of number and a shape."""
        return self._next(n, np.dtype([(name, self.types[kind], shape) for name, kind, shape in fields]))

    def _next(self, n: int, dtype: np.dtype) -> np.ndarray:
        if not 0 <= n * dtype.itemsize <= len(self.section.body) - self.at:
            raise short(self.path, self.section)
        found = np.frombuffer(self.section.body, dtype, n, self.at)
        self.at += n * dtype.itemsize
        return found

    def finish(self) -> None:
        """Refuse bytes that are left, besides the end of a line."""
        if self.section.body[self.at :].strip():
            raise wrong_file(self.path, f"${self.section.name} holds more bytes than it says", REMEDY)


def short(path: Path, section: Section) -> InputError:
    """Error of a section that claims more than it holds."""
    return wrong_file(path, f"${section.name} claims more numbers than it holds", REMEDY, section.line)
