"""Order of elimination of a sparse symmetric pattern: by smallest degree, coordinates before the multipliers that tie them."""

from __future__ import annotations

from heapq import heapify, heappop, heappush

import numpy as np

WAITING, MOVING = 1 << 40, 1 << 39
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
    members = _alike(indptr, indices, n_q, moving)
    number = np.zeros(len(indptr) - 1, np.int64)
    for s, each in enumerate(members):
        number[each] = s
    weight = [len(each) for each in members]
    neighbours = [set(number[indices[indptr[each[0]] : indptr[each[0] + 1]]].tolist()) - {s} for s, each in enumerate(members)]
    degree = [weight[s] - 1 + sum(weight[t] for t in each) for s, each in enumerate(neighbours)]
    coordinate = [bool(each[0] < n_q) for each in members]
    late = [MOVING if moving[each[0]] else 0 for each in members]
    waits = [0 if coordinate[s] else sum(coordinate[t] for t in each) for s, each in enumerate(neighbours)]
    ties = [[t for t in each if not coordinate[t]] if coordinate[s] else [] for s, each in enumerate(neighbours)]

    def key(s: int) -> tuple[int, int, int]:
        return degree[s] + late[s] + (WAITING if waits[s] else 0), int(members[s][0]), s

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


def _alike(indptr: np.ndarray, indices: np.ndarray, n_q: int, moving: np.ndarray) -> list[np.ndarray]:
    """Groups of unknowns that couple to the same ones and to each other, in the order of their first.

    Multipliers and what moves stand apart.
    """
    found: dict[tuple[bool, bool, bytes], list[int]] = {}
    for i in range(len(indptr) - 1):
        found.setdefault((i < n_q, bool(moving[i]), indices[indptr[i] : indptr[i + 1]].tobytes()), []).append(i)
    return [np.array(each, np.int64) for each in found.values()]
