"""The text of an airfoil file split into title, rows of numbers and what follows; no meaning given to the numbers yet."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.meant_path import meant_path
from toolkit.foundation.files.regular_file import read_start

LARGEST_FILE = 1_000_000
"""Bytes; the most rows that are accepted have some 100 kB."""
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([EeDd][+-]?\d+)?")
_NOT_FINITE = re.compile(r"[+-]?(nan|inf|infinity)|\*+", re.IGNORECASE)  # asterisks: overflow of a Fortran format
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+")


@dataclass(frozen=True)
class Table:
    """Rows that hold numbers only, each with its line in the file, between the text ahead of them and the text behind."""

    header: tuple[str, ...]
    rows: tuple[tuple[float, ...], ...]
    lines: tuple[int, ...]
    repairs: tuple[str, ...]


def read_text(path: Path) -> str:
    """Text of the file without a byte-order mark; titles in Latin-1 are accepted, a binary file is not.

    Raises
    ------
    InputError
        The file cannot be read, or is no text.
    """
    try:
        content = read_start(path, LARGEST_FILE + 1)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}{meant_path(path, error)}. Check the path {str(path)!r}.") from error
    if len(content) > LARGEST_FILE:
        raise InputError(
            f"has more than {LARGEST_FILE} bytes. Give a file of coordinates, of which one section has a few hundred."
        )
    if b"\0" in content:
        raise InputError("is not a text file (it holds zero bytes). Save the coordinates as plain text, UTF-8 or ASCII.")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def split_table(text: str) -> Table:
    """Rows of the file: a line counts only if all its fields are numbers; the first text behind them ends the data.

    Raises
    ------
    InputError
        A row is invalid; names the line.
    """
    header: list[str] = []
    rows: list[tuple[float, ...]] = []
    lines: list[int] = []
    end = 0
    for line, content in enumerate(re.split(r"\r\n|\r|\n", text), start=1):
        content = content.strip()
        if not content or content[0] in "#!":
            continue
        numbers = _numbers(content, line)
        if not rows and (numbers is None or len(numbers) == 1):
            header.append(content)
        elif numbers is None:
            end = end or line
        elif end:
            _refuse_resumed(numbers, line, end)
        else:
            _refuse_single(numbers, line)
            rows.append(numbers)
            lines.append(line)
    if not rows:
        raise InputError("holds no row of coordinates. Expected lines with two numbers x and y, for example '1.000 0.000'.")
    repairs = (f"line {end}: text behind the coordinates, read no further",) if end else ()
    return Table(tuple(header), tuple(rows), tuple(lines), repairs)


def _numbers(content: str, line: int) -> tuple[float, ...] | None:
    """The numbers of a line, or None if any field is text; blanks, tabs, commas and semicolons separate fields."""
    content = re.split(r"[#!]", content)[0].strip()
    columns = [column.rstrip(",") for column in re.split(r"[;\s]+", content)]
    if len(columns) > 1 and all(_DECIMAL_COMMA.fullmatch(column) for column in columns):
        raise InputError(f"line {line}: decimal commas. Write decimal points.")
    values = [_number(field) for field in re.split(r"\s*[,;]\s*|\s+", content.strip(",; "))]
    return tuple(value for value in values if value is not None) if None not in values else None


def _number(field: str) -> float | None:
    if _NUMBER.fullmatch(field):
        return float(field.upper().replace("D", "E"))
    return float("nan") if _NOT_FINITE.fullmatch(field) else None


def _refuse_single(numbers: tuple[float, ...], line: int) -> None:
    if len(numbers) == 1:
        raise InputError(f"line {line}: one number where x and y were expected. Complete or remove the line.")


def _refuse_resumed(numbers: tuple[float, ...], line: int, end: int) -> None:
    if len(numbers) > 1:
        raise InputError(
            f"line {end} is no row of coordinates, but line {line} holds {len(numbers)} numbers again. Fix line {end}, or "
            "remove what does not belong to this one section."
        )
