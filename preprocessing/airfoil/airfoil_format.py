"""Recognise the format of an airfoil table and bring its rows into one loop."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.safe_files import meant_path, read_start
from toolkit.foundation.units import LARGEST

LARGEST_FILE = 1_000_000
"""Bytes; the most rows that are accepted have some 100 kB."""
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([EeDd][+-]?\d+)?")
_NOT_FINITE = re.compile(r"[+-]?(nan|inf|infinity)|\*+", re.IGNORECASE)  # asterisks: overflow of a Fortran format
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+")


@dataclass(frozen=True)
class TextTable:
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


def split_table(text: str) -> TextTable:
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
    return TextTable(tuple(header), tuple(rows), tuple(lines), repairs)


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


@dataclass(frozen=True, eq=False)
class Loop:
    """Contour rows (n, 2) from trailing edge to trailing edge, their lines in the file, and the repairs made."""

    points: np.ndarray
    lines: np.ndarray
    format: str
    name: str = ""
    repairs: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    def take(self, rows, *repairs: str) -> Loop:
        """Loop with the selected rows, and the repairs that this means."""
        return replace(self, points=self.points[rows], lines=self.lines[rows], repairs=self.repairs + repairs)


def recognise(table: TextTable) -> Loop:
    """The loop of a table in one of the formats Selig, XFOIL plain, Lednicer (with or without header), OpenVSP, MSES, OpenFAST.

    The formats differ in their first lines and in where x falls back from the trailing to the leading edge:
    nowhere in a loop, once between the two blocks of Lednicer and OpenVSP files.

    Raises
    ------
    InputError
        Several elements, counts that do not agree with the rows, one surface only, numbers that are not finite.
    """
    _refuse_elements(table)
    loop = _coordinates(table)
    vsp_counts = _openvsp_counts(table.header)
    if vsp_counts:
        return _joined(replace(loop, format="OpenVSP", name=table.header[min(1, len(table.header) - 1)]), vsp_counts, "header")
    if openfast_count := _openfast_count(table.header):
        return _oriented_from_tail(_without_reference(loop, openfast_count))
    if _has_mses_domain(table):
        note = f"line {loop.lines[0]}: grid domain of an MSES file, not needed"
        return _oriented_from_tail(replace(loop, format="MSES").take(slice(1, None), note))
    counts = _count_line(loop)
    if counts:
        return _joined(replace(loop.take(slice(1, None)), format="Lednicer"), counts, f"line {loop.lines[0]}")
    return _oriented_from_tail(_without_numeric_title(loop))


def _coordinates(table: TextTable) -> Loop:
    points = np.array([row[:2] for row in table.rows])
    lines = np.array(table.lines)
    bad = np.flatnonzero(~(np.abs(points) <= LARGEST).all(axis=1))
    if bad.size:
        raise InputError(
            f"line {lines[bad[0]]}: a coordinate is not finite or beyond {LARGEST:g}. Replace it by its value or remove the row."
        )
    _refuse_counting_column(table)
    domain = _has_mses_domain(table)
    wide = [line for row, line in zip(table.rows[domain:], table.lines[domain:], strict=True) if len(row) > 2]
    warnings = (f"line {wide[0]}: more than two columns in {len(wide)} rows, only the first two are used",) if wide else ()
    name = table.header[0] if table.header else ""
    return Loop(points, lines, "Selig" if name else "XFOIL plain", name, table.repairs, warnings)


def _has_mses_domain(table: TextTable) -> bool:
    """Whether a table begins with the domain of an MSES file.

    This is a row of four or five numbers, of a grid, ahead of rows of two.
    """
    return len(table.rows[0]) >= 4 and len(table.rows) > 1 and len(table.rows[1]) == 2


def _refuse_counting_column(table: TextTable) -> None:
    """Refuse a first column 1, 2, 3, ... ahead of x and y."""
    first = np.array([row[0] for row in table.rows])
    if len(first) > 1 and min(map(len, table.rows)) > 2 and np.all(np.diff(first) == 1):
        raise InputError(
            f"line {table.lines[0]}: the first column only counts the rows ({first[0]:g}, {first[1]:g}, ...). Remove it; the first "
            "two columns must be x and y."
        )


def _refuse_elements(table: TextTable) -> None:
    """Refuse ISES and MSES files of several elements, which a row `999. 999.` separates."""
    for row, line in zip(table.rows, table.lines, strict=True):
        if row[:2] == (999.0, 999.0):
            raise InputError(
                f"line {line}: '999. 999.' separates the elements of an ISES/MSES file with several elements; one closed section "
                "is needed. Copy one element into a file of its own."
            )


def _openvsp_counts(header: tuple[str, ...]) -> tuple[int, int] | None:
    """Counts of an OpenVSP header, whose lines hold a number and its meaning."""
    text = "\n".join(header)
    if re.search(r"^1\s+Sym Flag", text, re.MULTILINE):
        raise InputError("OpenVSP file with symmetry flag 1 (one surface only). Export it with both surfaces.")
    counts = re.findall(r"^(\d{1,9})\s+Num Pnts", text, re.MULTILINE)
    return (int(counts[0]), int(counts[1])) if len(counts) == 2 else None


def _openfast_count(header: tuple[str, ...]) -> str | None:
    """The field ahead of `NumCoords` in a file of OpenFAST, by whose manual it counts the rows; None in other files."""
    found = re.search(r"^(\S+)\s+NumCoords\b", "\n".join(header), re.MULTILINE | re.IGNORECASE)
    return found and found[1]


def _without_reference(loop: Loop, count: str) -> Loop:
    """The contour of a file of OpenFAST, whose first row is the point of the section that sits on the blade's pitch axis."""
    if not count.isdecimal() or len(count) > 9 or int(count) == 0:
        raise InputError(
            "NumCoords is not the number of rows that follow: this is a file of polars, and its coordinates are left out or stand in "
            "another file. Give the file of coordinates, whose first line is their number and NumCoords."
        )
    if int(count) != len(loop.points):
        raise InputError(
            f"NumCoords announces {int(count)} rows, one of them the reference point, but {len(loop.points)} follow. Fix the number or "
            "complete the rows."
        )
    note = f"line {loop.lines[0]}: reference point of an OpenFAST file, no part of the contour"
    return replace(loop, format="OpenFAST", name="").take(slice(1, None), note)


def _count_line(loop: Loop) -> tuple[int, int] | None:
    """Counts of a Lednicer file: two whole numbers above 1.5, followed by a row at the leading edge."""
    first, rest = loop.points[0], loop.points[1:]
    if len(rest) < 2 or not np.all((first > 1.5) & (first == np.round(first))):
        return None
    return (int(first[0]), int(first[1])) if rest[0, 0] < 0.5 * rest[:, 0].max() else None


def _without_numeric_title(loop: Loop) -> Loop:
    """Loop without a title such as "63 412" that reads like a row; whole numbers that dwarf all coordinates give it away."""
    first, rest = loop.points[0], loop.points[1:]
    if len(rest) and not loop.name and np.all(first == np.round(first)) and first.max() > 1.5 >= np.abs(rest).max():
        name = f"{first[0]:g} {first[1]:g}"
        note = f"line {loop.lines[0]}: numbers {name} far off the other rows, taken as the title"
        return replace(loop, format="Selig", name=name).take(slice(1, None), note)
    return loop


def _joined(loop: Loop, counts: tuple[int, int], where: str) -> Loop:
    """Loop from an upper and a lower block that both start at the leading edge, whose row is kept once."""
    upper, lower = counts
    if upper + lower != len(loop.points):
        raise InputError(
            f"{where} announces {upper} + {lower} rows, but {len(loop.points)} follow. Fix the counts or complete the rows."
        )
    x = loop.points[:, 0]
    if x[upper - 1] < 0.5 * x.max() or x[upper] > 0.5 * x.max():
        raise InputError(
            f"{where} announces {upper} upper rows, but line {loop.lines[upper]} (x = {x[upper]:g}) starts no second block "
            "at the leading edge. Fix the counts or list both blocks from the leading to the trailing edge."
        )
    shared = bool(np.all(loop.points[0] == loop.points[upper]))
    return loop.take(np.r_[np.arange(upper)[::-1], upper + shared : upper + lower])


def _oriented_from_tail(loop: Loop) -> Loop:
    """The loop itself if it starts at the trailing edge, else made to: two blocks are joined, a loop is turned."""
    x = loop.points[:, 0]
    middle = 0.5 * x.max()
    falls = np.flatnonzero(np.diff(x) < -middle)
    if x[0] > middle and x[-1] > middle:
        return loop
    if x[0] <= middle and x[-1] > middle and len(falls) == 1:
        split = int(falls[0]) + 1
        name = "Lednicer without counts" if loop.name else "headless Lednicer"
        return _joined(replace(loop, format=name), (split, len(x) - split), f"line {loop.lines[split]}")
    if x[0] <= middle and x[-1] <= middle and not len(falls):
        return _turned(loop)
    raise InputError(
        f"x runs from {x[0]:g} (line {loop.lines[0]}) to {x[-1]:g} (line {loop.lines[-1]}) and falls back to the leading edge "
        f"{len(falls)} times: a surface is missing or there are several sections. Give one loop trailing edge, upper side, "
        "leading edge, lower side, trailing edge."
    )


def _turned(loop: Loop) -> Loop:
    """Loop turned to start at the trailing edge, whose row then stands at both ends, from one that starts at the leading edge."""
    x = loop.points[:, 0]
    tail, n = int(np.argmax(x)), len(x)
    closed = int(np.all(loop.points[0] == loop.points[-1]))
    # An open trailing edge has two rows there: the loop is cut between them.
    start = tail + 1 if tail + 1 < n and abs(x[tail + 1] - x[tail]) < 1e-3 * x[tail] else tail
    note = f"line {loop.lines[0]}: loop started at the leading edge, turned to start at line {loop.lines[start]}"
    return loop.take(np.r_[start:n, closed : tail + 1], note)
