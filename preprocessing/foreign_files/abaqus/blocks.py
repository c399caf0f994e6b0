"""Blocks of a deck: a keyword line with its parameters, and the data lines below it, with what is included in their place.

A line that begins with one star is a keyword line, with two a comment. A keyword line that ends with a comma goes on in the next line. Case
does not count, nor do blanks, but within quotation marks. Files are mapped into memory, so that large ones are never copied as a whole.
"""

from __future__ import annotations

import mmap
import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BufferedReader, RawIOBase, TextIOWrapper
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from preprocessing.foreign_files.abaqus.vocabulary import spelled, spelled_parameter
from preprocessing.foreign_files.contents import included_file
from toolkit.foundation.errors import InputError

if TYPE_CHECKING:
    from _typeshed import WriteableBuffer

COMMENT = re.compile(rb"^[ \t]*\*\*", re.MULTILINE)


@dataclass(frozen=True, eq=False)
class Text:
    """Content of one file as bytes."""

    file: Path
    content: bytes | mmap.mmap  # of the whole file, or the file mapped into memory

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
        content: bytes | mmap.mmap = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) if path.stat().st_size else b""
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise InputError(f"{str(path)!r} is written in UTF-16. Save it as plain text in UTF-8.")
    if content.find(b"\0") >= 0:
        raise InputError(f"{str(path)!r} holds zero bytes, and is no text. Give an input deck of Abaqus or CalculiX.")
    if content.find(b"\r") >= 0 and content.find(b"\n") < 0:  # lines end as on old computers
        content = bytes(content).replace(b"\r", b"\n")
    return Text(path, content)


@dataclass(frozen=True)
class BlockPiece:
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

    def __init__(self, piece: BlockPiece) -> None:
        self._view, self._at, self._end = memoryview(piece.text.content), piece.start, piece.end

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: WriteableBuffer) -> int:
        target = memoryview(buffer)
        size = min(len(target), self._end - self._at)
        target[:size] = self._view[self._at : self._at + size]
        self._at += size
        return size


PARAMETER = re.compile(r"""((?:"[^"]*"|[^,"])*)(?:,|\Z)""")
DATA = re.compile(rb"\s*[0-9+.-]")
"""Beginning of a data line of numbers, as no parameter begins."""
WITH_FILES = ("INCLUDE", "NODE", "ELEMENT", "NSET", "ELSET")
"""Keywords whose parameter INPUT names a file with data lines of nodes and elements."""


@dataclass(frozen=True)
class KeywordBlock:
    """Keyword line with its data lines."""

    keyword: str  # in capitals, without its star; empty of lines ahead of the first keyword
    parameters: dict[str, str]  # name in capitals -> value as it is written; empty where it has none
    text: Text
    start: int
    pieces: list[BlockPiece] = field(default_factory=list)

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


def blocks_of(path: Path) -> list[KeywordBlock]:
    """All blocks of a deck in their order; the lines of an included file stand in the place of the line that includes it.

    Raises
    ------
    InputError
        A file is no text or missing, or the deck has no keyword.
    """
    found: list[KeywordBlock] = []
    _read(path, path, found)
    if not any(block.keyword for block in found):
        raise InputError(f"{str(path)!r} has no keyword line. Give an input deck of Abaqus or CalculiX.")
    return found


def _read(path: Path, main: Path, found: list[KeywordBlock]) -> None:
    """Append the blocks of a file, and the lines ahead of its first keyword to the block before it."""
    text = read_text(path)
    at = 3 if text.content[:3] == b"\xef\xbb\xbf" else 0
    for head in keyword_lines(text.content):
        _append(found, BlockPiece(text, at, head.start))
        if head.keyword != "INCLUDE":
            found.append(KeywordBlock(head.keyword, head.parameters, text, head.start))
        if name := head.file:
            _read(included_file(main, path, name), main, found)
        at = head.end
    _append(found, BlockPiece(text, at, len(text.content)))


def _append(found: list[KeywordBlock], piece: BlockPiece) -> None:
    """Append lines to the last block; those ahead of all keywords make a block without a keyword."""
    if piece.start >= piece.end:  # also where a byte order mark is all that stands ahead of the first keyword
        return
    if not found and not piece.blank:
        found.append(KeywordBlock("", {}, piece.text, piece.start))
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


def keyword_lines(content: bytes | mmap.mmap) -> Iterator[KeywordLine]:
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


WHOLE = re.compile(r"[+-]?[0-9]+", re.ASCII)
NUMBER = re.compile(r"([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))(?:[EeDd]([+-]?[0-9]+))?", re.ASCII)
UNIT_NORMAL_TOLERANCE = 1e-2
"""Difference of the square of a normal's length from one: decks write few digits of it."""
LARGEST_LABEL = 999_999_999
"""The largest number of a node or element that Abaqus allows."""


def whole(text: str, place: str) -> int:
    """Whole number from a text.

    Raises
    ------
    InputError
        The field is none.
    """
    if not WHOLE.fullmatch(text) or len(text) > 18:
        raise InputError(f"{place}: a field is no whole number. Fix it, or export the deck again.")
    return int(text)


def number(text: str, place: str) -> float:
    """Number from a text, also with Fortran's D instead of E; an empty field is zero.

    Raises
    ------
    InputError
        The field is none.
    """
    if not text:
        return 0.0
    found = NUMBER.fullmatch(text)
    if not found or not np.isfinite(value := float(f"{found[1]}e{found[2] or 0}")):
        raise InputError(f"{place}: a field is no number. Fix it, or export the deck again.")
    return value


def label(text: str, place: str) -> int:
    """Number of a node or element, from 1 on, from a text; raises as `whole`."""
    found = whole(text, place)
    if not 1 <= found <= LARGEST_LABEL:
        raise InputError(f"{place}: {found} is no number of a node or element; these go from 1 to {LARGEST_LABEL}.")
    return found


def node_rows(block: KeywordBlock) -> tuple[np.ndarray, np.ndarray]:
    """Labels (n,) and coordinates (n, 3) of the data lines of *NODE; what is missing or empty is zero.

    Raises
    ------
    InputError
        A field is no number; says which line.
    """
    if (found := _node_table(block)) is not None:
        return found
    rows = [_node_row(place, fields) for place, fields in block.rows()]
    table = np.array(rows, float).reshape(-1, 4)
    return table[:, 0].astype(np.int64), table[:, 1:]


def _node_table(block: KeywordBlock) -> tuple[np.ndarray, np.ndarray] | None:
    """Labels and coordinates at once, where every line has a label and two or three plain numbers; None elsewhere."""
    lines = block.data()
    first = next((line for line in lines if line.strip()), "")
    n = first.count(",")
    if n not in (2, 3):
        return None
    found = _table(chain([first], lines), np.dtype([("label", np.int64), ("place", np.float64, (n,))]))
    if found is None:
        return None
    labels, places = found["label"].copy(), np.zeros((len(found), 3))  # without the table, which else stays in memory
    places[:, :n] = found["place"]
    fine = np.all((labels >= 1) & (labels <= LARGEST_LABEL)) and np.all(np.isfinite(places))
    return (labels, places) if fine else None


def _table(lines: Iterator[str], kind: npt.DTypeLike) -> np.ndarray | None:
    """Table of lines with as many numbers each, read at once; None where there are none, or one is no plain number."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # that there are no data, or that a whole number is none
            return np.loadtxt(lines, kind, delimiter=",", comments=None, ndmin=2 if np.dtype(kind).names is None else 1)
    except (ValueError, Warning):
        return None


def _node_row(place: str, fields: list[str]) -> list[float]:
    """Label and coordinates of a line, which may go on with a normal that beams and shells use."""
    if not fields:
        raise InputError(f"{place}: a node needs a number. Fix the line.")
    values = [number(text, place) for text in fields[1:]]
    normal = values[3:]
    unit = len(normal) == 3 and abs(sum(x * x for x in normal) - 1) < UNIT_NORMAL_TOLERANCE
    if normal and not ((unit or not any(normal)) and any("." in text for text in fields)):
        raise InputError(
            f"{place}: a node has a number, three coordinates and at most a unit normal, and here are {len(fields)} fields. If commas are "
            "meant as decimal points, write points."
        )
    return [label(fields[0], place), *[*values, 0.0, 0.0, 0.0][:3]]


def element_rows(block: KeywordBlock, n_nodes: int) -> np.ndarray:
    """Label and nodes (n_e, 1 + n_nodes) of the data lines of *ELEMENT, each over as many lines as it needs.

    Raises
    ------
    InputError
        A field is no whole number, or an element has another number of nodes; says which line.
    """
    found = _element_table(block, 1 + n_nodes)
    return _element_rows(block, 1 + n_nodes) if found is None else found


def _element_table(block: KeywordBlock, width: int) -> np.ndarray | None:
    """Rows of elements read at once, where lines hold only whole numbers and all elements have as many lines; else None."""
    lines = block.data()
    first = next((line for line in lines if line.strip()), "")
    lines = chain([first], lines)
    if len(fields_of(first)) < width:
        lines = _joined(lines, width)
    found = _table((line.rstrip().rstrip(",") for line in lines) if first.rstrip().endswith(",") else lines, np.int32)
    fine = found is not None and found.shape[1] == width and found.min() >= 1 and found.max() <= LARGEST_LABEL
    return found if fine else None


def _joined(lines: Iterator[str], width: int) -> Iterator[str]:
    """Lines of elements that take several of them, put together until they have so many fields."""
    whole, count = [], 0
    for line in lines:
        if text := line.strip().rstrip(","):
            whole.append(text)
            count += 1 + text.count(",")
            if count >= width:
                yield ",".join(whole)
                whole, count = [], 0
    if whole:
        yield ",".join(whole)


def _element_rows(block: KeywordBlock, width: int) -> np.ndarray:
    """Rows of elements read line by line."""
    rows, row, began = list[list[int]](), list[int](), ""
    for place, line in block.lines():
        began = began if row else place
        row += [label(text, place) for text in fields_of(line)]
        if len(row) > width:
            raise InputError(
                f"{place}: an element of this type has {width - 1} nodes, and here are {len(row) - 1}. Fix the line."
            )
        if len(row) == width:
            rows.append(row)
            row = []
    if row:
        raise InputError(f"{began}: an element of this type has {width - 1} nodes, and here are {len(row) - 1}. Fix the line.")
    return np.array(rows, np.int32).reshape(-1, width)
