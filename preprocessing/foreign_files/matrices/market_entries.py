"""Entries of a matrix in the exchange format of NIST, Matrix Market: dense or sparse, real, whole or one triangle of a symmetric one."""

from __future__ import annotations

import re

import numpy as np

from preprocessing.foreign_files.matrices.archive_entries import Entries
from preprocessing.foreign_files.matrices.number_lines import line_of, number_lines, without_comments
from preprocessing.foreign_files.matrices.triangles import both_triangles

MATRIX_MARKET = b"%%MatrixMarket"
SHORTEST_ENTRY = 2
"""Bytes of a line: a digit and its end."""
HEAD = re.compile(rb"%%MatrixMarket[ \t]+matrix[ \t]+(\w+)[ \t]+([\w-]+)[ \t]+([\w-]+)[ \t]*\n", re.IGNORECASE)
SIZE = re.compile(rb"(?:[ \t]*\n|%[^\n]*\n)*[ \t]*(\d{1,18})[ \t]+(\d{1,18})(?:[ \t]+(\d{1,18}))?[ \t]*\n")
READ = ({b"coordinate", b"array"}, {b"real", b"double", b"integer"}, {b"general", b"symmetric"})
"""The words of the first line whose matrices are those of elastic bodies."""
NOT_MEANT = (b"complex", b"pattern", b"hermitian", b"skew-symmetric")
"""The other words of the format."""


def of_matrix_market(text: bytes) -> Entries:
    """Entries of a matrix from a file's text; raises ValueError if it is not what its first lines claim."""
    head = HEAD.match(text)
    if head is None:
        raise ValueError("its first line is not: %%MatrixMarket matrix coordinate real symmetric, or the like")
    layout, kind, symmetry = words = [word.lower() for word in head.groups()]
    _refuse_words(words)
    size = SIZE.match(text, head.end())
    if size is None or (size[3] is None) != (layout == b"array"):
        raise ValueError("it does not say how many rows and columns, and if sparse how many entries, it has")
    rows, columns = int(size[1]), int(size[2])
    if symmetry == b"symmetric" and rows != columns:
        raise ValueError(f"it claims a symmetric matrix of {rows} rows and {columns} columns")
    claimed = _claimed(rows, columns, size[3], symmetry, len(text))
    body, before = without_comments(text[size.end() :], b"%"), text.count(b"\n", 0, size.end())
    found = number_lines(body, (3,) if layout == b"coordinate" else (1,), None, before)
    if len(found) != claimed:
        raise ValueError(f"it claims {claimed} entries, and holds {len(found)}")
    if kind == b"integer":
        _refuse_fractions(found[:, -1:], body, before)
    row, column = _places(found, (rows, columns), body, before) if layout == b"coordinate" else _dense(rows, columns, symmetry)
    if symmetry == b"general":
        return (rows, columns), row, column, found[:, -1]
    return (rows, columns), *both_triangles(row, column, found[:, -1], rows, "it claims to be symmetric, and")


def _refuse_words(words: list[bytes]) -> None:
    """Refuse matrices that no elastic body has."""
    for word, known in zip(words, READ, strict=True):
        if word not in known:
            called = f"it is {word.decode()}" if word in NOT_MEANT else "its first line has a word that the format does not know"
            raise ValueError(f"{called}; real matrices are needed, coordinate or array, general or symmetric")


def _claimed(rows: int, columns: int, entries: bytes | None, symmetry: bytes, size: int) -> int:
    """Number of entries that the lines must hold."""
    dense = rows * columns if symmetry == b"general" else rows * (rows + 1) // 2
    claimed, least = (int(entries),) * 2 if entries else (dense, rows * columns // 2)
    if SHORTEST_ENTRY * least > size:
        raise ValueError(f"it claims {least} entries or more, and has {size} bytes")
    return claimed


def _dense(rows: int, columns: int, symmetry: bytes) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns of dense entries, which stand column by column; of symmetric ones those from the diagonal down."""
    column, row = np.divmod(np.arange(rows * columns), max(rows, 1))
    below = row >= column if symmetry == b"symmetric" else slice(None)
    return row[below], column[below]


def _places(found: np.ndarray, shape: tuple[int, int], body: bytes, before: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns from 0 of sparse entries, which count from 1."""
    _refuse_fractions(found[:, :2], body, before)
    wrong = np.flatnonzero(np.any((found[:, :2] < 1) | (found[:, :2] > shape), axis=1))
    if len(wrong):
        raise ValueError(f"line {line_of(body, wrong[0], before)} is outside of its {shape[0]} rows and {shape[1]} columns")
    return tuple(found[:, :2].T.astype(np.int64) - 1)  # type: ignore[return-value]


def _refuse_fractions(numbers: np.ndarray, body: bytes, before: int) -> None:
    """Refuse what should be whole numbers and are none."""
    wrong = np.flatnonzero(np.any(numbers != np.floor(numbers), axis=1))
    if len(wrong):
        raise ValueError(f"line {line_of(body, wrong[0], before)} has a fraction where the format has a whole number")
