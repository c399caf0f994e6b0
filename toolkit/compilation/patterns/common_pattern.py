"""Entries of bodies and markers that the scene needs: what is not zero at its numbers, or has a derivative that was asked for.

A model could fill more for other values of its parameters; what nothing asks for is neither stored nor read from its file.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from toolkit.compilation.quantities import Quantities

SHARED = ("mass", "damping", "stiffness", "inertia", "gyroscopic", "second", "stiffening")
"""Matrices of a body that share their entries."""
SMALLEST_SQUARE = 8
"""Rows from which matrices are worked with as a whole, if at least half of their entries can differ from zero."""


def on_common_pattern(values: Quantities, derivatives: list[Quantities]) -> None:
    """Give each body and each marker the same entries in the values and in all derivatives."""
    everything = [values, *derivatives]
    for b in values.constant:
        _spread([each.constant for each in everything if b in each.constant], b, _squared)
    for b in values.floating:
        _spread([each.floating for each in everything if b in each.floating], b)
    for b in values.drag:
        _spread([each.drag for each in everything if b in each.drag], b)
    for m in values.markers:
        _widen([each.markers for each in everything if m in each.markers], m)


def square_size(row: np.ndarray, column: np.ndarray) -> int:
    """Rows of the square that a body's entries fill, row by row; 0 if they fill none that is worth it."""
    n = int(np.sqrt(len(row)))
    if n < SMALLEST_SQUARE or n * n != len(row):
        return 0
    rows, columns = np.divmod(np.arange(n * n), n)
    return n if np.array_equal(row, row[0] + rows) and np.array_equal(column, row[0] + columns) else 0


def _squared(keys: np.ndarray, size: int) -> np.ndarray:
    """Entries row * size + column, or all of the square that they lie in, if they are at least half of it."""
    if not len(keys):
        return keys
    row, column = keys // size, keys % size
    first, last = min(row.min(), column.min()), max(row.max(), column.max())
    n = last - first + 1
    return (
        np.add.outer(np.arange(first, last + 1) * size, np.arange(first, last + 1)).ravel()
        if n >= SMALLEST_SQUARE and 2 * len(keys) >= n * n
        else keys
    )


def _spread(tables: list, owner: int, completed: Callable[[np.ndarray, int], np.ndarray] = lambda keys, _size: keys) -> None:
    """Bring the matrices of one body, in all tables, to the union of their entries or to more."""
    parts = [table[owner] for table in tables]
    size = 1 + max(int(max(part.row.max(initial=0), part.column.max(initial=0))) for part in parts)
    keys = [part.row * size + part.column for part in parts]
    union = completed(np.unique(np.concatenate(keys)), size)
    for table, part, key in zip(tables, parts, keys, strict=True):
        place = np.searchsorted(union, key)
        names = [
            name for name in SHARED if name in part._fields and np.ndim(getattr(part, name))
        ]  # not the mass of a floating body
        spread = {name: placed(getattr(part, name), place, len(union)) for name in names}
        table[owner] = part._replace(row=union // size, column=union % size, **spread)


def _widen(tables: list, owner: int) -> None:
    """Bring one marker, in all tables, to the union of the coordinates that it feels."""
    parts = [table[owner] for table in tables]
    union = np.unique(np.concatenate([part.columns for part in parts]))
    for table, part in zip(tables, parts, strict=True):
        place = np.searchsorted(union, part.columns)
        table[owner] = part._replace(columns=union, shape=placed(part.shape, place, len(union)))


def placed(values: np.ndarray, place: np.ndarray, size: int) -> np.ndarray:
    """Array of a size that holds the values at their places, and zeros elsewhere."""
    wide = np.zeros((size, *np.shape(values)[1:]), np.asarray(values).dtype)
    wide[place] = values
    return wide
