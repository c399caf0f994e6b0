"""Lines of the bulk data section, with those of included files in the place of the INCLUDE that names them."""

from __future__ import annotations

import os
import re
from bisect import bisect
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from preprocessing.foreign_files.bounds import LARGEST_FILE
from preprocessing.foreign_files.inclusion import included_file
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.regular_file import read_whole

STATEMENT = re.compile(rb"[ \t]*include(?=[\s='\"]|$)[ \t]*=?", re.IGNORECASE)
ANY_STATEMENT = re.compile(rb"^[ \t]*include", re.IGNORECASE | re.MULTILINE)
BEGIN = re.compile(rb"[ \t]*begin\b[ \t]*(.*)", re.IGNORECASE)
CASE_PARAMETER = re.compile(rb"[ \t]*param[ \t]*[, \t]", re.IGNORECASE)
CASE_CONTROL = re.compile(rb"[ \t]*cend[ \t]*(\$.*)?", re.IGNORECASE)
DEEPEST, MOST = 20, 1000
"""Files that include each other in a row, and files in all, that a bulk file is made of."""


@dataclass
class Lines:
    """Lines of several files after one another, and where each of them stands."""

    main: Path
    texts: list[bytes] = field(default_factory=list)
    pieces: list[tuple[int, Path, int]] = field(default_factory=list)  # first line here, file, its number there less one

    def add(self, texts: list[bytes], path: Path, before: int) -> None:
        """Append lines of a file that follow so many others there."""
        self.pieces.append((len(self.texts), path, before))
        self.texts.extend(texts)

    def place(self, line: int) -> str:
        """Position of a line, in words."""
        start, path, before = self.pieces[bisect([first for first, _, _ in self.pieces], line) - 1]
        return f"{str(path)!r}, line {before + line - start + 1}"

    def error(self, line: int, what: str) -> InputError:
        """Error saying that something is wrong with a line."""
        return InputError(f"{self.place(line)}: {what}")


def bulk_lines(path: Path) -> tuple[Lines, list[int]]:
    """All lines of a file and those that it includes, and which of them are bulk data; PARAM of case control counts as such.

    Raises
    ------
    InputError
        A file cannot be read, is no text, or includes itself; or the bulk data section is not to be found.
    """
    found = Lines(path)
    _append(path, found, (os.path.realpath(path),), [0])
    begins = [(k, match[1]) for k, line in enumerate(found.texts) if line[:1] in b" \tbB" and (match := BEGIN.match(line))]
    for k, rest in begins:
        if k != begins[0][0] or rest.partition(b"$")[0].split() not in ([], [b"BULK"], [b"bulk"], [b"Bulk"]):
            raise found.error(k, "BEGIN begins a superelement or another part, and one BEGIN BULK is read. Write one model.")
    start = begins[0][0] + 1 if begins else 0
    if not begins:
        for k, line in enumerate(found.texts):
            if CASE_CONTROL.fullmatch(line):
                raise found.error(k, "CEND is not followed by BEGIN BULK. Add that line ahead of the first card.")
    parameters = [k for k in range(start) if CASE_PARAMETER.match(found.texts[k])]
    return found, [*parameters, *range(start, len(found.texts))]


def _append(path: Path, found: Lines, chain: tuple[str, ...], count: list[int]) -> None:
    """Append the lines of a file, and of all that it includes."""
    count[0] += 1
    if len(chain) > DEEPEST + 1 or count[0] > MOST:
        raise InputError(
            f"{str(found.main)!r} includes more than {MOST} files, or more than {DEEPEST} in a row. Write the mesh in one file."
        )
    content, at = text_of(path), 0
    texts = content.splitlines()
    for first, after, name in statements(texts) if ANY_STATEMENT.search(content) else ():
        found.add(texts[at:first], path, at)
        named, at = included_file(found.main, path, name), after
        place = os.path.realpath(named) if "\0" not in name else name
        if place in chain:
            raise InputError(f"{str(path)!r} includes {str(named)!r}, which includes it in turn. Take one of the two lines out.")
        _append(named, found, (*chain, place), count)
    found.add(texts[at:], path, at)


def text_of(path: Path) -> bytes:
    """The content of a file, whose lines end as under Linux.

    Raises
    ------
    InputError
        It cannot be read, or is no text.
    """
    try:
        content = read_whole(path, LARGEST_FILE)
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be read ({error.strerror}). Fix the path, or give a regular file.") from error
    if b"\0" in content:
        raise InputError(f"{str(path)!r} is no bulk data: it holds zero bytes. Save it as plain text in ASCII or UTF-8.")
    content = content.removeprefix(b"\xef\xbb\xbf")
    return content.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in content else content


def statements(texts: list[bytes]) -> Iterator[tuple[int, int, str]]:
    """Every INCLUDE: its first line, the line after its last one, and the name of the file, which quotes may spread over several lines."""
    after = 0
    for k, line in enumerate(texts):
        if k >= after and line[:1] in b" \tiI" and (match := STATEMENT.match(line)):
            name, after = _name(texts, k, line[match.end() :].strip())
            yield k, after, os.fsdecode(name).replace("\\", "/")  # files are named as under Windows, too


def _name(texts: list[bytes], k: int, rest: bytes) -> tuple[bytes, int]:
    """The name that begins with the rest of line k, and the line after its end."""
    quote = rest[:1]
    if quote not in (b"'", b'"'):
        return rest.partition(b"$")[0].strip(), k + 1
    name, end = rest[1:], k + 1
    while quote not in name and end < min(len(texts), k + DEEPEST):
        name, end = name + texts[end].strip(), end + 1
    return (name.partition(quote)[0], end) if quote in name else (rest[1:].partition(b"$")[0].strip(), k + 1)


def named_files(main: Path, path: Path, content: bytes) -> Iterator[Path]:
    """The files that one of the files of a bulk file includes."""
    if ANY_STATEMENT.search(content.replace(b"\r", b"\n")):
        for _, _, name in statements(content.splitlines()):
            yield included_file(main, path, name)
