"""Numbers of a scene on the entries that the same scene had at other numbers, if these are enough."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.compilation.patterns.common_pattern import SHARED, placed
from toolkit.compilation.quantities import GROUPS, Quantities


class NewEntryError(Exception):
    """Error of a number that is not zero any more where the pattern has no entry."""


def renew(old: Quantities, new: Quantities, entries: Quantities, changed: set[str]) -> Quantities:
    """Old numbers of a scene with new ones in their places.

    Parameters
    ----------
    old
        All numbers of a scene, or all derivatives by one variable.
    new
        Some of them, of the same scene at other numbers.
    entries
        Numbers on the entries that are there: the values of the old scene.
    changed
        Groups that differ; those found here are added.

    Raises
    ------
    NewEntryError
        There is no place for one of the new numbers.
    """
    parts: dict[str, Any] = {}
    if not np.array_equal(old.gravity, new.gravity):
        changed.add("gravity")
    for group in GROUPS:
        before, known, given = getattr(old, group), getattr(entries, group), getattr(new, group)
        if not given:
            parts[group] = before
            continue
        found = {owner: _on(part, known[owner]) for owner, part in given.items()}
        parts[group] = {**before, **found}
        if group not in changed and not all(_equal(before[owner], part) for owner, part in found.items()):
            changed.add(group)
    return Quantities(**parts, gravity=new.gravity)


def _on(part: Any, known: Any) -> Any:
    """Part of the quantities, on the entries of a known one."""
    fields = getattr(part, "_fields", ())
    if "row" in fields and _same(part.row, known.row) and _same(part.column, known.column):
        return part
    if "row" in fields:
        size = 1 + max(int(max(each.row.max(initial=0), each.column.max(initial=0))) for each in (part, known))
        place = _places(known.row * size + known.column, part.row * size + part.column)
        shared = [name for name in SHARED if name in fields and np.ndim(getattr(part, name))]
        return part._replace(
            row=known.row, column=known.column, **{name: placed(getattr(part, name), place, len(known.row)) for name in shared}
        )
    if "columns" in fields and not _same(part.columns, known.columns):
        place = _places(known.columns, part.columns)
        return part._replace(columns=known.columns, shape=placed(part.shape, place, len(known.columns)))
    return part


def _same(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two arrays are equal, as `np.array_equal` tells, in half of the time."""
    return one.shape == other.shape and bool((one == other).all())


def _places(known: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Places of the wanted keys among the known ones, which ascend."""
    found = np.searchsorted(known, wanted)
    if (not len(known) and len(wanted)) or not np.array_equal(known[found.clip(max=len(known) - 1)], wanted):
        raise NewEntryError
    return found


def _equal(one: Any, other: Any) -> bool:
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(_equal, one, other))
    return np.array_equal(one, other) if isinstance(one, np.ndarray | float | complex) else bool(one == other)
