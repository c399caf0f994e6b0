"""Arrays of numbers from .npy, .npz or text, read whole, or an error that says what is wrong."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Collection
from io import BytesIO
from math import prod
from pathlib import Path

import numpy as np
from scipy import sparse

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


UNPACKED, UNPACKED_PER_BYTE = 2**28, 50
"""Most bytes that an archive may unpack to: the first, and this many for each of its bytes; numbers of places pack ten to one."""
LONGEST_HEADER = 10_000
"""Bytes of the text in a .npy file that says what it holds."""


MOST_FIELDS = 10_000
"""Most fields of a line of a text; a table of nodes has three."""
NAMES = re.compile(rb"\s*\"?x\"?\s*,\s*\"?y\"?\s*(?:,\s*\"?z\"?\s*)?", re.IGNORECASE)
"""The only first line of words whose meaning is plain: the names of the coordinates."""


def number_table(path: str) -> np.ndarray:
    """The array of a .npy file, the only one of a .npz archive, or the numbers of a text with commas."""
    file = Path(path)
    if file.suffix == ".npy":
        return array_of(file.read_bytes())
    if file.suffix == ".npz":
        return _only_one(archive(file))
    return table_of(file.read_bytes())


def table_of(content: bytes) -> np.ndarray:
    """The numbers of a text with a comma between two of them, or blanks where there is no comma at all.

    What follows # is a comment, and the first line may name the coordinates.

    Raises
    ------
    ValueError
        It names the first line that is none of numbers.
    """
    text = re.sub(rb"#[^\n]*", b"", plain_text(content))
    first, _, rest = text.partition(b"\n")
    body, before = (rest, 1) if NAMES.fullmatch(first) else (text, 0)
    return number_lines(body, range(1, MOST_FIELDS), "," if b"," in body else None, before)


def _only_one(arrays: dict[str, np.ndarray]) -> np.ndarray:
    """The array of an archive that holds no other, so that none is taken by chance."""
    if len(arrays) > 1:
        raise ValueError(f"it holds {len(arrays)} arrays, and it is not clear which of them is meant; keep one")
    return next(iter(arrays.values()))


def archive(path: Path) -> dict[str, np.ndarray]:
    """All arrays of a .npz file; raises ValueError if there is none, or they are larger than the file can mean."""
    with zipfile.ZipFile(path) as packed:
        members = packed.infolist()
        unpacked, most = sum(each.file_size for each in members), UNPACKED + UNPACKED_PER_BYTE * path.stat().st_size
        if unpacked > most:
            raise ValueError(f"its {path.stat().st_size} bytes unpack to {unpacked}, and no more than {most} are meant")
        found = {each.filename.removesuffix(".npy"): array_of(packed.read(each)) for each in members}
    if not found:
        raise ValueError("it holds no array")
    return found


def array_of(content: bytes) -> np.ndarray:
    """The array of a .npy file's content; raises ValueError if it claims another size than it has, or holds objects."""
    stream = BytesIO(content)
    version = np.lib.format.read_magic(stream)
    read_header = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, dtype = read_header(stream, max_header_size=LONGEST_HEADER)
    claimed, held = prod(shape) * dtype.itemsize, len(content) - stream.tell()
    if dtype.hasobject or min(shape, default=0) < 0 or claimed != held:
        raise ValueError(f"it claims an array {shape} of {dtype.itemsize} bytes each, and holds {held} bytes")
    stream.seek(0)
    return np.lib.format.read_array(stream, allow_pickle=False, max_header_size=LONGEST_HEADER)


ROUND_OFF = 1e-9
"""Largest entry, relative to the largest of all, that may stand on one side of the diagonal alone where others stand on both."""


def both_triangles(
    row: np.ndarray, column: np.ndarray, value: np.ndarray, n: int, who: str = "it", one_only: bool = True
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows, columns and values of both triangles of a symmetric matrix (n, n), of which one triangle may be given, in any order of rows.

    Where no entry has its mirror image, the file holds one triangle, whichever; where each has, it holds both.

    Parameters
    ----------
    who : beginning of the sentence of an error
    one_only : whether both triangles are an error too

    Raises
    ------
    ValueError
        Some entries stand on both sides of the diagonal and some on one, so that it is not clear which are to be mirrored.
    """
    off = row != column
    if not np.any(off):
        return row, column, value
    entries = sparse.csr_array((np.ones(np.count_nonzero(off)), (row[off], column[off])), shape=(n, n))
    entries.data[:] = 1.0
    if entries.multiply(entries.T).nnz == 0:
        return np.concatenate([row, column[off]]), np.concatenate([column, row[off]]), np.concatenate([value, value[off]])
    if one_only:
        raise ValueError(f"{who} holds entries on both sides of the diagonal")
    _refuse_half(sparse.csr_array((value, (row, column)), shape=(n, n)), entries, who)
    return row, column, value


def _refuse_half(matrix: sparse.csr_array, entries: sparse.csr_array, who: str) -> None:
    """Refuse a matrix with both triangles, of which one lacks entries."""
    alone = entries - entries.multiply(entries.T)
    lacking = np.abs(matrix.multiply(alone).data) > ROUND_OFF * np.abs(matrix.data).max()
    if np.any(lacking):
        raise ValueError(
            f"{who} holds entries on both sides of the diagonal, but {np.count_nonzero(lacking)} of them on one side only; give one "
            "triangle, or both of them whole"
        )
