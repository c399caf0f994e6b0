"""Lines of numbers in text files, read whole: every field is a number, or an error says in which line it is none."""

from __future__ import annotations

import re
from collections.abc import Collection
from io import BytesIO

import numpy as np

NUMBER = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
"""A number after `D` of Fortran's exponents became `E`."""
PLAIN = bytes((9, 10, *range(32, 127)))
"""Bytes that a text of numbers may hold."""
FORTRAN = bytes.maketrans(b"dD", b"EE")
"""Fortran writes the exponent of double precision with D; no word that is a number otherwise has one."""
BYTE_ORDER_MARK = b"\xef\xbb\xbf"


def plain_text(content: bytes) -> bytes:
    """The content with one kind of line ends and without a mark of its encoding; raises ValueError if it holds zero bytes."""
    if b"\0" in content:
        raise ValueError("it holds zero bytes, and is no text of one byte for each character")
    return content.removeprefix(BYTE_ORDER_MARK).replace(b"\r\n", b"\n").replace(b"\r", b"\n")


def without_comments(text: bytes, mark: bytes) -> bytes:
    """The text with every line that begins with a mark left empty, so that the lines keep their numbers."""
    return re.sub(rb"(?m)^[ \t]*" + re.escape(mark) + rb"[^\n]*", b"", text) if mark in text else text


def number_lines(text: bytes, widths: Collection[int], separator: str | None = None, before: int = 0) -> np.ndarray:
    """The numbers of all lines that are not blank, (n, width).

    Parameters
    ----------
    widths : how many fields a line may have, the same in all lines
    separator : a comma, or None for blanks
    before : number of lines of the file ahead of the text, for errors

    Raises
    ------
    ValueError
        It names the first line that has another number of fields, or a field that is no finite number.
    """
    text = text.translate(FORTRAN)
    if not text.strip():
        return np.zeros((0, min(widths)))
    try:
        found = (
            np.loadtxt(BytesIO(text), delimiter=separator, comments=None, ndmin=2) if not text.translate(None, PLAIN) else None
        )
    except ValueError:
        found = None
    if found is None or found.shape[1] not in widths or not np.all(np.isfinite(found)):
        raise ValueError(_first_wrong(text, widths, separator, before))
    return found


def line_of(text: bytes, row: int, before: int = 0) -> int:
    """Number of the line of the file that holds a row of numbers, which counts from 0 and leaves blank lines out."""
    for number, line in enumerate(text.split(b"\n"), before + 1):
        if line.strip():
            row -= 1
        if row < 0:
            return number
    return before


def _first_wrong(text: bytes, widths: Collection[int], separator: str | None, before: int) -> str:
    """Complaint about the first wrong line, in words that quote nothing of it."""
    width = 0
    for number, line in enumerate(text.split(b"\n"), before + 1):
        if not line.strip():
            continue
        fields = line.split(separator.encode() if separator else None)
        if complaint := _complaint(line, fields, {width} if width else widths, separator):
            return f"line {number} {complaint}"
        width = len(fields)
    return "it holds other things than lines of numbers"


def _complaint(line: bytes, fields: list[bytes], widths: Collection[int], separator: str | None) -> str:
    """Complaint about one line; empty if nothing is wrong."""
    if line.translate(None, PLAIN):
        return "holds characters that are neither digits nor letters of plain text"
    if b";" in line:
        return "holds a semicolon; write a comma between two numbers, and a point in them"
    if separator is None and b"," in line:
        return "holds a comma among numbers that blanks separate; write decimal points"
    if len(fields) not in widths:
        meant = " or ".join(map(str, sorted(widths))) if len(widths) < 4 else f"at most {max(widths)}"
        return f"has {len(fields)} fields instead of {meant}"
    for place, field in enumerate(fields, 1):
        if NUMBER.fullmatch(field.strip()) is None:
            return f"has a field, number {place}, that is no finite real number"
        if not np.isfinite(float(field)):
            return f"has a number, in field {place}, beyond 1e308"
    return ""
