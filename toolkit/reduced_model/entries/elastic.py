"""Square matrices of the elastic coordinates at one design, on the entries where any of them can differ from zero."""

from __future__ import annotations

from functools import reduce
from typing import Any, NamedTuple

import numpy as np

from toolkit.reduced_model.design_point import DesignPoint


class ElasticMatrices(NamedTuple):
    """Entries of several matrices of the elastic coordinates, row by row."""

    row: np.ndarray
    column: np.ndarray
    values: tuple[np.ndarray, ...]


def elastic_matrices(design: DesignPoint, *items: str) -> ElasticMatrices:
    """Invariants of some names on the elastic coordinates; an axis for the undeformed shape before these is left out.

    Raises
    ------
    InputError
        As `DesignPoint.some_invariants`.
    """
    design.check_extrapolated(items)
    found = [design.filled(item) for item in items]
    known, key = design.model.told, ("elastic", design.kind, items)
    if key not in known:
        n_f, sizes = design.model.n_f, [design.model.item(item).shape[0] for item in items]
        known[key] = _common(n_f, [_inside(here, n_f, size) for (here, _), size in zip(found, sizes, strict=True)])
    row, column, places = known[key]
    values = [_on(len(row), flat, *at) for (_, flat), at in zip(found, places, strict=True)]
    filled = reduce(np.logical_or, (value != 0 for value in values))
    if not filled.all():
        row, column, values = row[filled], column[filled], [value[filled] for value in values]
    return ElasticMatrices(row, column, tuple(values))


def _inside(here: np.ndarray | slice, n_f: int, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Entries between elastic coordinates: places in the flattened (n_f, n_f) matrix, and which of the given places they are."""
    row, column = (each - (size - n_f) for each in np.divmod(np.arange(size * size)[here], size))
    elastic = np.flatnonzero((row >= 0) & (column >= 0))
    return row[elastic] * n_f + column[elastic], elastic


def _common(n_f: int, parts: list[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray, list[Any]]:
    """Rows and columns of all matrices' entries, and for each matrix where its entries are among them and which they are."""
    every = np.sort(np.concatenate([place for place, _ in parts]), kind="stable")  # of sorted runs, which `unique` would hash
    union = every[np.diff(every, prepend=-1) > 0]
    return union // n_f, union % n_f, [(np.searchsorted(union, place), own) for place, own in parts]


def _on(size: int, flat: np.ndarray, to: np.ndarray, own: np.ndarray) -> np.ndarray:
    found = np.zeros(size, flat.dtype)
    found[to] = flat[own]
    return found
