"""Entries of the sparse matrices that SciPy keeps in .npz archives, in each of its formats."""

from __future__ import annotations

from typing import Any

import numpy as np

Entries = tuple[Any, np.ndarray, np.ndarray, np.ndarray]
"""Shape, rows, columns and values; equal places add up."""


def of_archive(arrays: dict[str, np.ndarray]) -> Entries:
    """Entries of a matrix that `scipy.sparse.save_npz` wrote; raises ValueError if its parts do not fit together."""
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
    """Whole numbers of one line."""
    found = arrays[name]
    if found.dtype.kind not in "iu" or found.ndim != 1:
        raise ValueError(f"its {name} are no line of whole numbers")
    return found.astype(np.int64)


def _of_diagonals(offsets: np.ndarray, data: np.ndarray, shape: list[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Entries of a matrix stored by diagonals: entry j of diagonal k stands in column j and row j - k."""
    if data.ndim != 2 or len(data) != len(offsets) or np.any(np.abs(offsets) > max(shape)):
        raise ValueError("its diagonals do not fit to their offsets")
    column = np.broadcast_to(np.arange(data.shape[1]), data.shape)
    row = column - offsets[:, None]
    inside = (column < shape[1]) & (row >= 0) & (row < shape[0])
    return row[inside], column[inside], data[inside]
