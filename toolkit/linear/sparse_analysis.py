"""Analysis of a sparsity pattern, once per model: order of elimination, fill, and the list of updates that `sparse_lu` runs through."""

from __future__ import annotations

from heapq import heapify, heappop, heappush
from typing import NamedTuple

import numpy as np

from toolkit.foundation.errors import InputError

WAITING_MULTIPLIER_DEGREE, CHANGING_UNKNOWN_DEGREE = 1 << 40, 1 << 39
"""Added to the degree of a multiplier whose coordinates are not all gone, and of an unknown whose equation changes."""


def minimum_degree(
    indptr: np.ndarray, indices: np.ndarray, n_q: int, moving: np.ndarray | None = None
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Order by smallest degree, and for each pivot the later unknowns that it couples to; those that are `moving` (n,) come last.

    Eliminating an unknown connects all its neighbours with each other. A multiplier waits until its last coordinate is gone. Ties go to
    the lower index, which keeps a band a band and a body together. Unknowns that couple to the same ones, as the elastic coordinates of
    a body do, are eliminated one after the other, and counted as one here: time and memory follow the entries, not the square of n.
    """
    moving = np.zeros(len(indptr) - 1, bool) if moving is None else moving
    members = _coupled_alike(indptr, indices, n_q, moving)
    number = np.zeros(len(indptr) - 1, np.int64)
    for s, each in enumerate(members):
        number[each] = s
    weight = [len(each) for each in members]
    neighbours = [set(number[indices[indptr[each[0]] : indptr[each[0] + 1]]].tolist()) - {s} for s, each in enumerate(members)]
    degree = [weight[s] - 1 + sum(weight[t] for t in each) for s, each in enumerate(neighbours)]
    coordinate = [bool(each[0] < n_q) for each in members]
    late = [CHANGING_UNKNOWN_DEGREE if moving[each[0]] else 0 for each in members]
    waits = [0 if coordinate[s] else sum(coordinate[t] for t in each) for s, each in enumerate(neighbours)]
    ties = [[t for t in each if not coordinate[t]] if coordinate[s] else [] for s, each in enumerate(neighbours)]

    def key(s: int) -> tuple[int, int, int]:
        return degree[s] + late[s] + (WAITING_MULTIPLIER_DEGREE if waits[s] else 0), int(members[s][0]), s

    queue, gone = [key(s) for s in range(len(members))], [False] * len(members)
    heapify(queue)
    order: list[np.ndarray] = []
    below: list[np.ndarray] = []
    while queue:
        entry = heappop(queue)
        s = entry[2]
        if gone[s] or entry != key(s):
            continue
        gone[s], clique = True, neighbours[s]
        later = np.concatenate([members[s], *(members[t] for t in clique)])
        order.append(members[s])
        below += [later[k + 1 :] for k in range(weight[s])]
        for t in ties[s]:
            waits[t] -= 1
        for t in clique:
            new = clique - neighbours[t]
            new.discard(t)
            degree[t] += sum(weight[u] for u in new) - weight[s]
            neighbours[t] |= new
            neighbours[t].discard(s)
        for t in clique:
            heappush(queue, key(t))
        neighbours[s] = set()
    return np.concatenate([*order, np.zeros(0, np.int64)]), below


def _coupled_alike(indptr: np.ndarray, indices: np.ndarray, n_q: int, moving: np.ndarray) -> list[np.ndarray]:
    """Groups of unknowns that couple to the same ones and to each other, in the order of their first.

    Multipliers and what moves stand apart.
    """
    found: dict[tuple[bool, bool, bytes], list[int]] = {}
    for i in range(len(indptr) - 1):
        found.setdefault((i < n_q, bool(moving[i]), indices[indptr[i] : indptr[i + 1]].tobytes()), []).append(i)
    return [np.array(each, np.int64) for each in found.values()]


SHORTEST_RUN = 4
"""Length from which a run of neighbouring entries is updated as a slice, not entry by entry (measured on a beam)."""
PIVOTS_AT_ONCE = 4
"""Pivots that are eliminated together where they couple to the same unknowns: every entry behind them is then read and written once, not
four times, which halves the time of dense bodies."""


class LUPlan(NamedTuple):
    """Places of all entries in the factors; integer arrays only.

    "Position" is the place of an unknown in the order of elimination.

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
    together: (
        np.ndarray
    )  # (n,) at the first of PIVOTS_AT_ONCE pivots the number of runs of adjacent columns behind the last of them, otherwise 0
    run_first: np.ndarray  # of each such run the place of its first entry among those behind the last of the pivots
    run_length: np.ndarray
    destination: np.ndarray  # place in `lu` that each update hits, in the order of `factor`; of a run only the first
    still: np.ndarray  # (3,) how many pivots never change, and what they use of the updates and of the runs
    still_value: np.ndarray  # CSR values in their rows and columns
    later_value: np.ndarray  # all other CSR values
    own_value: np.ndarray  # (n - still[0],) CSR values on the diagonal of the later pivots


def analyse(indptr: np.ndarray, indices: np.ndarray, n_q: int, moving: np.ndarray | None = None) -> LUPlan:
    """Order of elimination, fill and list of updates for a pattern; once per model.

    Parameters
    ----------
    indptr, indices : (n + 1,), (nnz,) ints
        CSR pattern: symmetric, sorted, with a full diagonal (also where the value is zero, at the multipliers).
    n_q : int
        Number of coordinates; the unknowns after them are multipliers.
    moving : (n,) bools
        Unknowns whose entries between each other change from matrix to matrix, by default all; multipliers are among them. The others are
        eliminated first, and as long as their values stay the same only once.

    Raises
    ------
    InputError
        If the pattern is not symmetric, not sorted, or lacks a diagonal entry.
    """
    indptr, indices = np.asarray(indptr, dtype=np.int64), np.asarray(indices, dtype=np.int64)
    _check(indptr, indices)
    moving = np.ones(len(indptr) - 1, bool) if moving is None else moving
    order, below = minimum_degree(indptr, indices, n_q, moving)
    position = np.empty_like(order)
    position[order] = np.arange(len(order))
    row_of_value = np.repeat(position, np.diff(indptr))
    still = int(np.count_nonzero(~moving))
    return _plan(order, [np.sort(position[neighbours]) for neighbours in below], row_of_value, position[indices], still)


def _check(indptr: np.ndarray, indices: np.ndarray) -> None:
    """Refuse a pattern that is not sorted, lacks a diagonal entry, or is not symmetric."""
    n = len(indptr) - 1
    row = np.repeat(np.arange(n), np.diff(indptr))
    if np.any((np.diff(indices) <= 0) & (np.diff(row) == 0)):
        raise InputError("the column indices of a sparse row do not ascend; sort them and add up duplicates before the analysis.")
    diagonal = row[row == indices]
    if len(diagonal) < n:
        missing = int(np.setdiff1d(np.arange(n), diagonal)[0])
        raise InputError(f"row {missing} of the pattern has no diagonal entry; add it, with value 0 for a multiplier.")
    present, transposed = row * n + indices, indices * n + row
    if not np.array_equal(np.sort(transposed), present):
        i, j = divmod(int(np.setdiff1d(present, transposed)[0]), n)
        raise InputError(f"the pattern has the entry ({i}, {j}) but not ({j}, {i}); add it with value 0.")


def _plan(order: np.ndarray, upper: list[np.ndarray], value_row: np.ndarray, value_column: np.ndarray, still: int) -> LUPlan:
    """Storage of L + U and its updates.

    It is made from the columns of each row of U and the place of each CSR value (all as positions).

    The first pivots, so many as are `still`, never change.
    """
    n = len(order)
    pivot = np.arange(n)
    row, column = np.repeat(pivot, [len(u) for u in upper]), np.concatenate([*upper, pivot[:0]])
    entry = np.sort(np.concatenate([row * n + column, column * n + row, pivot * n + pivot]))  # row * n + column, ascending
    row, column = np.divmod(entry, max(n, 1))
    updates, of_still = _updates(upper, still), np.minimum(value_row, value_column) < still
    own, later = np.flatnonzero((value_row == value_column) & ~of_still), np.flatnonzero(~of_still)
    return LUPlan(
        order=order,
        row_start=np.searchsorted(row, np.arange(n + 1)),
        diagonal=np.searchsorted(entry, pivot * n + pivot),
        column=column.astype(np.uint32),
        mirror=np.searchsorted(entry, column * n + row).astype(np.uint32),
        place=np.searchsorted(entry, value_row * n + value_column).astype(np.uint32),
        run=updates.run,
        together=updates.together,
        run_first=updates.run_first,
        run_length=updates.run_length,
        destination=np.searchsorted(entry, updates.updated).astype(np.uint32),
        still=np.array([still, *updates.of_still]),
        still_value=np.flatnonzero(of_still),
        later_value=later,
        own_value=own[np.argsort(value_row[own])],
    )


class _Updates(NamedTuple):
    """Updates of a factorisation; fields as in `LUPlan`, with the updated entries as row * n + column."""

    run: np.ndarray
    together: np.ndarray
    run_first: np.ndarray
    run_length: np.ndarray
    updated: np.ndarray
    of_still: tuple[int, int]  # how many updates and runs the pivots that never change have


def _updates(upper: list[np.ndarray], still: int) -> _Updates:
    """Updates that each pivot, or each group of pivots, makes; from the columns of each row of U.

    A group ends with those that are `still`.
    """
    n, k, nothing = len(upper), 0, np.zeros(0, np.int64)
    run, together = np.zeros((2, n), np.int64)
    first, length, updated, of_still = [nothing], [nothing], [nothing], (0, 0)
    while k < n:
        if k == still:
            of_still = sum(map(len, updated)), sum(map(len, first))
        if _alike(upper, k) and not k < still < k + PIVOTS_AT_ONCE:
            behind = upper[k + PIVOTS_AT_ONCE - 1]
            starts = np.flatnonzero(np.diff(behind, prepend=-1) != 1)
            together[k] = len(starts)
            first.append(starts)
            length.append(np.diff(starts, append=len(behind)))
            updated.append(np.add.outer(behind * n, behind[starts]).ravel())
            k += PIVOTS_AT_ONCE
        else:
            run[k] = _run_length(k, upper[k])
            updated.append(np.add.outer(upper[k] * n, _first_of_run(upper[k], run[k])).ravel())
            k += 1
    return _Updates(run, together, np.concatenate(first), np.concatenate(length), np.concatenate(updated), of_still)


def _alike(upper: list[np.ndarray], pivot: int) -> bool:
    """Whether a pivot and those after it couple to each other and to the same unknowns, of which there are some."""
    last = pivot + PIVOTS_AT_ONCE - 1
    if last >= len(upper) or len(upper[last]) == 0:
        return False
    return all(len(upper[k]) == len(upper[last]) + last - k and upper[k][0] == k + 1 for k in range(pivot, last))


def _run_length(pivot: int, columns: np.ndarray) -> int:
    adjacent = int(np.count_nonzero(columns == pivot + 1 + np.arange(len(columns))))
    return adjacent if adjacent >= SHORTEST_RUN else 0


def _first_of_run(columns: np.ndarray, run: int) -> np.ndarray:
    return np.delete(columns, np.s_[1:run])
