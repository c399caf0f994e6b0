"""Entries of a sparse matrix, whatever the format of its file: rows, columns and values, of which equal places add up."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from preprocessing.foreign_files.number_table import archive

MATRIX_MARKET = b"%%MatrixMarket"
SHORTEST_ENTRY = 2
"""Bytes of a line of Matrix Market: a digit and its end."""


def matrix_entries(path: str, n: str, dimension: str) -> dict[str, Any]:
    """Shape, rows, columns and values of SciPy's .npz, Matrix Market, or Abaqus' text for n coordinates of nodes in space."""
    file = Path(path)
    if file.suffix == ".npz":
        shape, row, column, value = of_archive(archive(file))
    elif (content := file.read_bytes()).startswith(MATRIX_MARKET):
        shape, row, column, value = of_matrix_market(content, file)
    else:
        shape, row, column, value = of_abaqus(file, int(n), int(dimension))
    return {"shape": [int(size) for size in shape], "row": row, "column": column, "value": value}


Entries = tuple[Any, np.ndarray, np.ndarray, np.ndarray]
"""Shape, rows, columns and values."""


def of_archive(arrays: dict[str, np.ndarray]) -> Entries:
    """Of what `scipy.sparse.save_npz` writes; raises ValueError if its parts do not fit together."""
    kind = arrays["format"].item()
    kind = kind.decode("ascii") if isinstance(kind, bytes) else kind
    shape = [int(size) for size in arrays["shape"].tolist()]
    if len(shape) != 2 or min(shape) < 0:
        raise ValueError(f"its shape is {shape} instead of rows and columns")
    if kind == "coo":
        return shape, _whole(arrays, "row"), _whole(arrays, "col"), arrays["data"]
    if kind == "dia":
        return shape, *_of_diagonals(_whole(arrays, "offsets"), arrays["data"], shape)
    if kind == "csc":
        column, row, value = _of_blocks(arrays, shape[::-1], arrays["data"][..., None, None])
    elif kind in ("csr", "bsr"):
        row, column, value = _of_blocks(arrays, shape, arrays["data"] if kind == "bsr" else arrays["data"][..., None, None])
    else:
        raise ValueError("its format is none of csr, csc, bsr, coo and dia")
    return shape, row, column, value


def _of_blocks(arrays: dict[str, np.ndarray], shape: list[int], blocks: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Row, column and value of compressed rows of blocks (n, height, width)."""
    indices, starts = _whole(arrays, "indices"), _whole(arrays, "indptr")
    if blocks.ndim != 3 or 0 in blocks.shape[1:] or shape[0] % blocks.shape[1] or shape[1] % blocks.shape[2]:
        raise ValueError(f"its blocks of shape {blocks.shape[1:]} do not divide its shape {shape}")
    n, count = shape[0] // blocks.shape[1], np.diff(starts)
    if len(starts) != n + 1 or starts[0] != 0 or np.any(count < 0) or np.any(starts > min(len(indices), len(blocks))):
        raise ValueError(f"its indptr does not rise from 0 to at most {min(len(indices), len(blocks))} in {n} steps")
    used = int(starts[-1])
    if np.any(indices[:used] < 0) or np.any(indices[:used] >= shape[1] // blocks.shape[2]):  # before products that could overflow
        raise ValueError(f"it has entries outside of its shape {shape}")
    down, across = np.indices(blocks.shape[1:])
    row = np.repeat(np.arange(n), count)[:, None, None] * blocks.shape[1] + down
    column = indices[:used, None, None] * blocks.shape[2] + across
    return row.ravel(), column.ravel(), blocks[:used].ravel()


def _whole(arrays: dict[str, np.ndarray], name: str) -> np.ndarray:
    """One line of whole numbers."""
    found = arrays[name]
    if found.dtype.kind not in "iu" or found.ndim != 1:
        raise ValueError(f"its {name} are no line of whole numbers")
    return found.astype(np.int64)


def _of_diagonals(offsets: np.ndarray, data: np.ndarray, shape: list[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Entry j of diagonal k stands in column j and row j - k."""
    if data.ndim != 2 or len(data) != len(offsets) or np.any(np.abs(offsets) > max(shape)):
        raise ValueError("its diagonals do not fit to their offsets")
    column = np.broadcast_to(np.arange(data.shape[1]), data.shape)
    row = column - offsets[:, None]
    inside = (column < shape[1]) & (row >= 0) & (row < shape[0])
    return row[inside], column[inside], data[inside]


def of_matrix_market(content: bytes, file: Path) -> Entries:
    """Of the exchange format of NIST; raises ValueError if its lines cannot hold what the first ones claim."""
    from scipy import io, sparse

    if b"\0" in content:
        raise ValueError("it holds zero bytes, and is no text")
    head = re.match(rb"%%MatrixMarket[^\n]*\n(?:[ \t\r]*\n|%[^\n]*\n)*[ \t]*(\d+)[ \t]+(\d+)(?:[ \t]+(\d+))?[ \t\r]*\n", content)
    if head is None:
        raise ValueError("it does not say how many rows and columns it has")
    rows, columns = int(head[1]), int(head[2])
    claimed = int(head[3]) if head[3] else rows * columns // 2
    if SHORTEST_ENTRY * claimed > len(content):
        raise ValueError(f"it claims {claimed} entries or more, and has {len(content)} bytes")
    found = sparse.coo_array(io.mmread(file))
    return found.shape, found.coords[0].astype(np.int64), found.coords[1].astype(np.int64), found.data


def of_abaqus(file: Path, n: int, d: int) -> Entries:
    """Lines `node, direction, node, direction, value`, of one triangle or of both."""
    lines = np.loadtxt(file, delimiter=",", ndmin=2, comments="*")
    known = len(lines) and lines.shape[1] == 5 and np.all(lines[:, :4] >= 1) and np.all(lines[:, :4] == np.floor(lines[:, :4]))
    if not known or np.any(lines[:, [1, 3]] > d) or np.any(lines[:, [0, 2]] > n // d):
        raise ValueError(f"lines of Abaqus are node, direction 1 to {d}, node, direction, value, with nodes from 1 to {n // d}")
    row, column = (d * (lines[:, [0, 2]].astype(np.int64) - 1) + lines[:, [1, 3]].astype(np.int64) - 1).T
    if np.any(row < column) and np.any(row > column):
        return (n, n), row, column, lines[:, 4]
    other = row != column
    value = np.concatenate([lines[:, 4], lines[other, 4]])
    return (n, n), np.concatenate([row, column[other]]), np.concatenate([column, row[other]]), value
