"""Analysis of a sparsity pattern, once per model: order of elimination, fill, and the list of updates that `sparse_lu` runs through."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.foundation.errors import InputError

SHORTEST_RUN = 4
"""Length from which a run of neighbouring entries is updated as a slice, not entry by entry (measured on a beam)."""


class LUPlan(NamedTuple):
    """Where every entry goes; integer arrays only. "Position" is the place of an unknown in the order of elimination.

    L (its unit diagonal is not stored), the inverse pivots and U share one array `lu` in rows of the permuted matrix. Index lists
    are unsigned because numba then skips the test for indices counted from the end, a quarter of the time.
    """

    order: np.ndarray  # (n,) original index of the unknown at each position
    row_start: np.ndarray  # (n + 1,) rows of `lu`; the last entry is the length of `lu`
    diagonal: np.ndarray  # (n,) place of the inverse pivot in `lu`: L to its left, U to its right
    column: np.ndarray  # (n_lu,) position of the column of each entry of `lu`, ascending in each row
    mirror: np.ndarray  # (n_lu,) place in `lu` of the transposed entry
    place: np.ndarray  # (nnz,) place in `lu` of each CSR value
    run: np.ndarray  # (n,) how many entries of U right behind the diagonal have adjacent columns, 0 if too few
    destination: np.ndarray  # place in `lu` that each update hits, in the order of `factor`; of a run only the first


def analyse(indptr: np.ndarray, indices: np.ndarray, n_q: int) -> LUPlan:
    """Order of elimination, fill and list of updates for a pattern; once per model.

    Parameters
    ----------
    indptr, indices : (n + 1,), (nnz,) ints
        CSR pattern: symmetric, sorted, with a full diagonal (also where the value is zero, at the multipliers).
    n_q : int
        Number of coordinates; the unknowns after them are multipliers.

    Raises
    ------
    InputError
        If the pattern is not symmetric, not sorted, or lacks a diagonal entry.
    """
    indptr, indices = np.asarray(indptr, dtype=np.int64), np.asarray(indices, dtype=np.int64)
    connected = _adjacency(indptr, indices)
    order, below = _minimum_degree(connected, n_q)
    position = np.empty_like(order)
    position[order] = np.arange(len(order))
    row_of_value = np.repeat(position, np.diff(indptr))
    return _plan(order, [np.sort(position[neighbours]) for neighbours in below], row_of_value, position[indices])


def _adjacency(indptr: np.ndarray, indices: np.ndarray) -> np.ndarray:
    """Checked pattern as a boolean matrix (n, n)."""
    n = len(indptr) - 1
    row = np.repeat(np.arange(n), np.diff(indptr))
    if np.any((np.diff(indices) <= 0) & (np.diff(row) == 0)):
        raise InputError("the column indices of a sparse row do not ascend; sort them and add up duplicates before the analysis.")
    connected = np.zeros((n, n), dtype=bool)
    connected[row, indices] = True
    missing = np.flatnonzero(~connected.diagonal())
    if missing.size:
        raise InputError(f"row {missing[0]} of the pattern has no diagonal entry; add it, with value 0 for a multiplier.")
    lonely = np.argwhere(connected & ~connected.T)
    if lonely.size:
        i, j = lonely[0]
        raise InputError(f"the pattern has the entry ({i}, {j}) but not ({j}, {i}); add it with value 0.")
    return connected


def _minimum_degree(connected: np.ndarray, n_q: int) -> tuple[np.ndarray, list[np.ndarray]]:
    """Order by smallest degree, and for each pivot the later unknowns that it couples to.

    Eliminating an unknown connects all its neighbours with each other. A multiplier waits until its last coordinate is gone.
    Ties go to the lower index, which keeps a band a band and a body together.
    """
    n = len(connected)
    ties = connected[:n_q, n_q:]
    fill = connected & ~np.eye(n, dtype=bool)
    degree = fill.sum(axis=1)
    waits_for = np.concatenate([np.zeros(n_q, dtype=np.int64), ties.sum(axis=0)])
    key = np.where(waits_for > 0, 2 * n, degree)
    order, below = [], []
    for _ in range(n):
        pivot = int(np.argmin(key))
        neighbours = np.flatnonzero(fill[pivot])
        fill[neighbours, pivot] = False
        clique = np.ix_(neighbours, neighbours)
        degree[neighbours] += len(neighbours) - 2 - fill[clique].sum(axis=1)
        fill[clique] = True
        fill[neighbours, neighbours] = False
        if pivot < n_q:
            waits_for[n_q:] -= ties[pivot]
        key[neighbours] = np.where(waits_for[neighbours] > 0, 2 * n, degree[neighbours])
        key[pivot] = 3 * n
        order.append(pivot)
        below.append(neighbours)
    return np.array(order, dtype=np.int64), below


def _plan(order: np.ndarray, upper: list[np.ndarray], value_row: np.ndarray, value_column: np.ndarray) -> LUPlan:
    """Storage of L + U and its updates, from the columns of each row of U and the place of each CSR value (all as positions)."""
    n = len(order)
    pivot = np.arange(n)
    row, column = np.repeat(pivot, [len(u) for u in upper]), np.concatenate([*upper, pivot[:0]])
    entry = np.sort(np.concatenate([row * n + column, column * n + row, pivot * n + pivot]))  # row * n + column, ascending
    row, column = np.divmod(entry, max(n, 1))
    run = np.array([_run_length(k, upper[k]) for k in range(n)], dtype=np.int64)
    updated = [np.add.outer(u * n, _first_of_run(u, length)).ravel() for u, length in zip(upper, run, strict=True)]
    return LUPlan(
        order=order,
        row_start=np.searchsorted(row, np.arange(n + 1)),
        diagonal=np.searchsorted(entry, pivot * n + pivot),
        column=column.astype(np.uint32),
        mirror=np.searchsorted(entry, column * n + row).astype(np.uint32),
        place=np.searchsorted(entry, value_row * n + value_column).astype(np.uint32),
        run=run,
        destination=np.searchsorted(entry, np.concatenate([*updated, pivot[:0]])).astype(np.uint32),
    )


def _run_length(pivot: int, columns: np.ndarray) -> int:
    adjacent = int(np.count_nonzero(columns == pivot + 1 + np.arange(len(columns))))
    return adjacent if adjacent >= SHORTEST_RUN else 0


def _first_of_run(columns: np.ndarray, run: int) -> np.ndarray:
    return np.delete(columns, np.s_[1:run])
