"""Blocks of a deck: a keyword line with its parameters, and the data lines below it, with what is included in their place.

A line that begins with one star is a keyword line, with two a comment. A keyword line that ends with a comma goes on in the next line. Case
does not count, nor do blanks, but within quotation marks. Files are mapped into memory, so that large ones are never copied as a whole.
"""

from __future__ import annotations

import mmap
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BufferedReader, RawIOBase, TextIOWrapper
from itertools import chain
from pathlib import Path
from typing import Any

from preprocessing.foreign_files.abaqus.vocabulary import spelled, spelled_parameter
from preprocessing.foreign_files.inclusion import included_file
from toolkit.foundation.errors import InputError

COMMENT = re.compile(rb"^[ \t]*\*\*", re.MULTILINE)


@dataclass(frozen=True, eq=False)
class Text:
    """Content of one file as bytes."""

    file: Path
    content: Any  # bytes, or the file mapped into memory

    def place(self, at: int) -> str:
        """Position of a byte in the file, in words."""
        return f"{str(self.file)!r}, line {self.line(at)}"

    def line(self, at: int) -> int:
        """Number of the line, from 1, in which a byte is."""
        with memoryview(self.content) as whole:
            step = 2**24
            return 1 + sum(bytes(whole[start : min(start + step, at)]).count(b"\n") for start in range(0, at, step))

    def release(self) -> None:
        """Let the system take back the memory that the file is mapped into; it is read again where it is needed again."""
        advice = getattr(mmap, "MADV_DONTNEED", None)  # not on every system
        if advice is not None and isinstance(self.content, mmap.mmap):
            self.content.madvise(advice)


def read_text(path: Path) -> Text:
    """Map a file into memory.

    Raises
    ------
    InputError
        It is no plain text.
    """
    with path.open("rb") as file:
        content: Any = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) if path.stat().st_size else b""
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise InputError(f"{str(path)!r} is written in UTF-16. Save it as plain text in UTF-8.")
    if content.find(b"\0") >= 0:
        raise InputError(f"{str(path)!r} holds zero bytes, and is no text. Give an input deck of Abaqus or CalculiX.")
    if content.find(b"\r") >= 0 and content.find(b"\n") < 0:  # lines end as on old computers
        content = bytes(content).replace(b"\r", b"\n")
    return Text(path, content)


@dataclass(frozen=True)
class Piece:
    """Lines of one file that follow each other."""

    text: Text
    start: int
    end: int

    @property
    def has_comments(self) -> bool:
        """Whether one of the lines is a comment."""
        first = self.text.content.find(b"**", self.start, self.end)
        return (
            first >= 0 and COMMENT.search(self.text.content, self.text.content.rfind(b"\n", 0, first) + 1, self.end) is not None
        )

    @property
    def blank(self) -> bool:
        """Whether the piece holds nothing but blanks and comments."""
        return next(self.rows(), None) is None

    def lines(self) -> TextIOWrapper:
        """Lines of the piece as a text file."""
        return TextIOWrapper(BufferedReader(_Window(self)), "utf-8", "replace")

    def data(self) -> Iterator[str]:
        """Lines of the piece that are no comments."""
        lines = self.lines()
        return (line for line in lines if not line.lstrip().startswith("**")) if self.has_comments else iter(lines)

    def rows(self) -> Iterator[tuple[int, str]]:
        """Number in the piece, from 0, and text of every line that is neither blank nor a comment."""
        for k, line in enumerate(self.lines()):
            if (text := line.strip()) and not text.startswith("**"):
                yield k, text


class _Window(RawIOBase):
    """Part of a file in memory, to be read from its beginning."""

    def __init__(self, piece: Piece) -> None:
        self._view, self._at, self._end = memoryview(piece.text.content), piece.start, piece.end

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        size = min(len(buffer), self._end - self._at)
        buffer[:size] = self._view[self._at : self._at + size]
        self._at += size
        return size


PARAMETER = re.compile(r"""((?:"[^"]*"|[^,"])*)(?:,|\Z)""")
DATA = re.compile(rb"\s*[0-9+.-]")
"""Beginning of a data line of numbers, as no parameter begins."""
WITH_FILES = ("INCLUDE", "NODE", "ELEMENT", "NSET", "ELSET")
"""Keywords whose parameter INPUT names a file with data lines of nodes and elements."""


@dataclass(frozen=True)
class Block:
    """Keyword line with its data lines."""

    keyword: str  # in capitals, without its star; empty of lines ahead of the first keyword
    parameters: dict[str, str]  # name in capitals -> value as it is written; empty where it has none
    text: Text
    start: int
    pieces: list[Piece] = field(default_factory=list)

    @property
    def line(self) -> int:
        """Number of the keyword line in its file."""
        return self.text.line(self.start)

    @property
    def place(self) -> str:
        """Position of the keyword line in words."""
        return self.text.place(self.start)

    def lines(self) -> Iterator[tuple[str, str]]:
        """Place, in words, and text of every data line that is neither blank nor a comment."""
        for piece in self.pieces:
            first = piece.text.line(piece.start)
            for k, line in piece.rows():
                yield f"{str(piece.text.file)!r}, line {first + k}", line

    def rows(self) -> Iterator[tuple[str, list[str]]]:
        """Position, in words, and fields of every data line that is neither blank nor a comment; no last field is empty."""
        for place, line in self.lines():
            yield place, fields_of(line)

    def data(self) -> Iterator[str]:
        """Data lines without blank lines and comments."""
        return chain.from_iterable(piece.data() for piece in self.pieces)

    def refuse(self, what: str) -> InputError:
        """Error saying that something is wrong with this block."""
        return InputError(f"{self.place}: {what}")


def fields_of(line: str) -> list[str]:
    """Fields between the commas of a line; a comma at its end counts for nothing."""
    found = [text.strip() for text in line.split(",")]
    return found[:-1] if found[-1] == "" else found


def label_of(text: str) -> str:
    """Label for comparison: capitals without blanks, unless it is quoted."""
    return text[1:-1] if len(text) > 1 and text[0] == text[-1] == '"' else re.sub(r"\s", "", text).upper()


def name_of(text: str) -> str:
    """Name for messages: as the deck spells it, without the quotation marks around it."""
    text = text.strip()
    return text[1:-1] if len(text) > 1 and text[0] == text[-1] == '"' else text


def blocks_of(path: Path) -> list[Block]:
    """All blocks of a deck in their order; the lines of an included file stand in the place of the line that includes it.

    Raises
    ------
    InputError
        A file is no text or missing, or the deck has no keyword.
    """
    found: list[Block] = []
    _read(path, path, found)
    if not any(block.keyword for block in found):
        raise InputError(f"{str(path)!r} has no keyword line. Give an input deck of Abaqus or CalculiX.")
    return found


def _read(path: Path, main: Path, found: list[Block]) -> None:
    """Append the blocks of a file, and the lines ahead of its first keyword to the block before it."""
    text = read_text(path)
    at = 3 if text.content[:3] == b"\xef\xbb\xbf" else 0
    for head in keyword_lines(text.content):
        _append(found, Piece(text, at, head.start))
        if head.keyword != "INCLUDE":
            found.append(Block(head.keyword, head.parameters, text, head.start))
        if name := head.file:
            _read(included_file(main, path, name), main, found)
        at = head.end
    _append(found, Piece(text, at, len(text.content)))


def _append(found: list[Block], piece: Piece) -> None:
    """Append lines to the last block; those ahead of all keywords make a block without a keyword."""
    if piece.start >= piece.end:  # also where a byte order mark is all that stands ahead of the first keyword
        return
    if not found and not piece.blank:
        found.append(Block("", {}, piece.text, piece.start))
    if found:
        found[-1].pieces.append(piece)


@dataclass(frozen=True)
class KeywordLine:
    """A keyword line, or several that continue one another."""

    keyword: str
    parameters: dict[str, str]
    start: int  # of the line in the file
    end: int

    @property
    def file(self) -> str:
        """Name of the file whose lines belong after this keyword line; empty if there is none."""
        return self.parameters.get("INPUT", "") if self.keyword in WITH_FILES else ""


def keyword_lines(content: Any) -> Iterator[KeywordLine]:
    """The keyword lines of a deck: bytes, or a file mapped into memory."""
    end = at = 0
    while (star := content.find(b"*", at)) >= 0:
        start = content.rfind(b"\n", 0, star) + 1
        stop = content.find(b"\n", star)
        at = stop + 1 if stop >= 0 else len(content)
        ahead = content[start:star].removeprefix(b"\xef\xbb\xbf")
        if ahead.strip(b" \t\r") or content[star + 1 : star + 2] == b"*":
            continue
        line, end = content[star:at].rstrip(), at
        while line.endswith(b",") and end < len(content):
            stop = content.find(b"\n", end)
            stop = stop + 1 if stop >= 0 else len(content)
            following = content[end:stop]
            if DATA.match(following):  # CalculiX does not mind a comma too many
                break
            end = stop
            if not following.lstrip().startswith(b"**"):
                line = (line + following).rstrip()
        at = end
        name, _, rest = line.decode("utf-8", "replace")[1:].partition(",")
        yield KeywordLine(keyword := spelled(name), _parameters(keyword, rest), start, end)


def _parameters(keyword: str, text: str) -> dict[str, str]:
    """Parameters of a keyword line: name in capitals -> value as written."""
    found = {}
    for each in PARAMETER.findall(text):
        name, _, value = each.partition("=")
        if name.strip():
            found[spelled_parameter(keyword, name)] = value.strip()
    return found


def deck_files(main: Path, path: Path, content: bytes) -> Iterator[Path]:
    """The files that a deck, or one that a main deck includes, takes lines from."""
    for head in keyword_lines(content):
        if head.file:
            yield included_file(main, path, head.file)
