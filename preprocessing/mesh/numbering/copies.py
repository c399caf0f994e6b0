"""Elements that stand twice in a mesh, and numbers that occur in arrays of nodes: in time that grows as the mesh does."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

GAMMA, FIRST, SECOND = (np.uint64(each) for each in (0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB))
"""Constants of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014)."""
DENSE = 16
"""Part of all numbers, one in so many, from which on a table of all of them is faster than sorting."""


def distinct(arrays: Sequence[np.ndarray], n: int) -> np.ndarray:
    """Numbers from 0 to n - 1 that occur in arrays, in rising order."""
    if DENSE * sum(each.size for each in arrays) < n:
        return np.unique(np.concatenate([np.zeros(0, np.int64), *(each.ravel() for each in arrays)]))
    there = np.zeros(n, bool)
    for each in arrays:
        there[each] = True
    return np.flatnonzero(there)


def joined(arrays: Sequence[np.ndarray]) -> np.ndarray:
    """Rows of all arrays, without a copy if there is a single one."""
    return arrays[0] if len(arrays) == 1 else np.concatenate(arrays)


class Renumbering(NamedTuple):
    """New numbers of nodes of which some were left out."""

    table: np.ndarray  # (n,) new number, or -1
    whole: bool  # whether none was left out

    def of(self, nodes: np.ndarray) -> np.ndarray:
        """New numbers of given nodes; where none was left out the array itself."""
        return nodes if self.whole else self.table[nodes]

    @classmethod
    def keeping(cls, used: np.ndarray, n: int) -> Renumbering:
        """Renumbering that keeps those of n nodes that are used, in their order."""
        table = np.full(n, -1)
        table[used] = np.arange(len(used))
        return cls(table, len(used) == n)


def first_of_copies(elements: np.ndarray) -> np.ndarray:
    """Which elements (n_e, n_local) have other nodes than all before them, in any order, (n_e,).

    Equal elements have equal sums of the scrambled numbers of their nodes. Of the few others that have these too, nodes are compared.
    """
    keys = _scrambled_sums(elements)
    rising = np.sort(keys)
    if not (rising[1:] == rising[:-1]).any():
        return np.ones(len(elements), bool)
    order = np.argsort(keys, kind="stable")
    begins = np.concatenate([[True], rising[1:] != rising[:-1]])
    start = np.maximum.accumulate(np.where(begins, np.arange(len(order)), 0))  # of the elements with one sum
    later = np.flatnonzero(~begins)
    alike = _in_order(elements, order[later]) == _in_order(elements, order[start[later]])
    found = np.ones(len(elements), bool)
    if not alike.all():
        return _compared(elements)
    found[order[later]] = False
    return found


def _scrambled_sums(elements: np.ndarray) -> np.ndarray:
    """Hash of 64 bits of the nodes of each element, whatever their order."""
    total = np.zeros(len(elements), np.uint64)
    for column in elements.T:
        total += _scrambled(column.astype(np.uint64))
    return total


def _scrambled(numbers: np.ndarray) -> np.ndarray:
    """Hash of every number by SplitMix64."""
    z = (numbers + np.uint64(1)) * GAMMA
    z = (z ^ (z >> np.uint64(30))) * FIRST
    z = (z ^ (z >> np.uint64(27))) * SECOND
    return z ^ (z >> np.uint64(31))


def _in_order(elements: np.ndarray, which: np.ndarray) -> np.ndarray:
    """Nodes of some elements in rising order."""
    return np.sort(elements[which], axis=1)


def _compared(elements: np.ndarray) -> np.ndarray:
    """First elements among copies, as `first_of_copies`, where different elements have one sum."""
    found = np.zeros(len(elements), bool)
    found[np.unique(np.sort(elements, axis=1), axis=0, return_index=True)[1]] = True
    return found
