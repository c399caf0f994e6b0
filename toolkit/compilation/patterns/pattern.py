"""The common sparsity pattern of all derivatives by the state, and where every component's local entries are stored."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Pattern:
    """Compressed rows with ascending columns and a full diagonal."""

    indptr: np.ndarray
    indices: np.ndarray
    keys: np.ndarray  # row * n + column, ascending

    @classmethod
    def of(cls, indptr: np.ndarray, indices: np.ndarray) -> Pattern:
        """Pattern of compressed rows, from their starts and their columns."""
        n = len(indptr) - 1
        return cls(indptr, indices, np.repeat(np.arange(n), np.diff(indptr)) * n + indices)

    def find(self, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Places of the entries (row, column), flattened; -1 where the pattern has none."""
        n = len(self.indptr) - 1
        wanted = (np.asarray(rows) * n + np.asarray(columns)).ravel()
        found = np.searchsorted(self.keys, wanted).clip(max=len(self.keys) - 1)
        return np.where(self.keys[found] == wanted, found, -1)


def block(rows: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns of all entries of a dense local block, row by row."""
    return np.repeat(rows, len(columns)), np.tile(columns, len(rows))


def build_pattern(n: int, entries: list[tuple[np.ndarray, np.ndarray]]) -> Pattern:
    """Union of entries, made symmetric, with the diagonal."""
    rows = np.concatenate([np.arange(n), *(r for r, _ in entries), *(c for _, c in entries)]).astype(np.int64)
    columns = np.concatenate([np.arange(n), *(c for _, c in entries), *(r for r, _ in entries)]).astype(np.int64)
    keys = np.sort(rows * n + columns)
    keys = keys[np.diff(keys, prepend=-1) > 0]  # np.unique hashes millions of numbers, which takes ten times as long
    indptr = np.searchsorted(keys, np.arange(n + 1) * n).astype(np.int64)
    return Pattern(indptr, keys % n, keys)
