"""Where numbers of nodes and elements stand in a list of them."""

from __future__ import annotations

import numpy as np

SPARSE = 8
"""Times as many as there are numbers, up to which the largest of them may be for a table of all numbers below it."""


class Lookup:
    """Lookup of numbers in a list without repetitions, by a table where they are dense, else by bisection."""

    def __init__(self, numbers: np.ndarray) -> None:
        self.numbers = numbers
        self._rises = rises(numbers)
        largest = int(numbers.max(initial=0))
        self._table: np.ndarray | None = None
        if largest < SPARSE * len(numbers) + 1000:
            self._table = np.full(largest + 2, -1)
            self._table[numbers] = np.arange(len(numbers))
        self._order = np.arange(0) if self._table is not None or self._rises else np.argsort(numbers, kind="stable")

    def places(self, wanted: np.ndarray) -> np.ndarray:
        """Places of some numbers, which are positive; -1 where there is none."""
        if self._table is not None:
            found: np.ndarray = self._table.take(wanted, mode="clip")
            return found
        at = np.searchsorted(self.numbers, wanted, sorter=None if self._rises else self._order).clip(max=len(self.numbers) - 1)
        at = at if self._rises else self._order[at]
        return np.where(self.numbers[at] == wanted, at, -1)


def rises(numbers: np.ndarray) -> bool:
    """Whether numbers grow from one to the next."""
    return bool(np.all(numbers[1:] > numbers[:-1]))


def last_of(numbers: np.ndarray) -> np.ndarray:
    """Whether each of the numbers is the last one of its value."""
    kept = np.ones(len(numbers), bool)
    if not rises(numbers):
        kept[:] = False
        kept[len(numbers) - 1 - np.unique(numbers[::-1], return_index=True)[1]] = True
    return kept
