"""The common sparsity pattern of all derivatives by the state: entries of bodies, markers and joints, which move, which stay.

Entries of bodies and markers that the scene needs: what is not zero at its numbers, or has a derivative that was asked for.

A model could fill more for other values of its parameters; what nothing asks for is neither stored nor read from its file.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from toolkit.components.bodies.kernels.constant_kernel import HALVES
from toolkit.components.joints.rows import Row
from toolkit.scene.resolution import ResolvedScene
from toolkit.scene.space import SPACE
from toolkit.system.numbering import Numbering, ints
from toolkit.system.quantities import GROUPS, Quantities


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


VECTORS = 4
"""Vectors of a pose in space: its position, and three axes that no translation moves."""
Entries = list[tuple[np.ndarray, np.ndarray]]


def joint_entries(
    scene: ResolvedScene, numbering: Numbering, name: str, rows: tuple[Row, ...], markers: list[int], columns: list[np.ndarray]
) -> Entries:
    """Rows and columns of all entries of a joint that is stated by these `rows`.

    `columns` are the coordinates that its markers feel.
    """
    numbers, both = numbering.row[name] + np.arange(len(rows)), np.concatenate(columns)
    grips = [numbering.markers[m][:2] for m in markers]
    if scene.space is SPACE:
        return _in_space(numbers, rows, columns, [scene.body(scene.piece(*grip)).moves for grip in grips])
    if scene.joints[name].curved:
        return [block(numbers, both), block(both, both)]
    framed = [scene.body(body).has_frame for body, _ in grips]
    felt = _felt(rows, columns, framed)
    return [
        *((np.full(len(each), number), each) for number, each in zip(numbers, felt, strict=True)),
        *(block(own[2:3], own[2:]) for own, turns in zip(columns, framed, strict=True) if turns),
    ]


def _felt(rows: tuple[Row, ...], columns: list[np.ndarray], framed: list[bool]) -> list[np.ndarray]:
    """Coordinates that each row of a flat planar joint feels: translations of a frame only where they stand in the row."""
    found = []
    for row in rows:
        places = {place for form in row.forms for place, _ in form.linear}
        kept = [
            np.array([c >= 2 or not framed[side] or 3 * side + c in places for c in range(len(own))], bool)
            for side, own in enumerate(columns)
        ]
        found.append(np.concatenate([own[felt] for own, felt in zip(columns, kept, strict=True)]))
    return found


def _in_space(numbers: np.ndarray, rows: tuple[Row, ...], columns: list[np.ndarray], moves: list[int]) -> Entries:
    """Entries of a joint in space.

    Each row has those of what it feels, its force those of what moves the vectors that are multiplied, and of what bends the
    pose.
    """
    found: Entries = [block(own[first:], own[first:]) for own, first in zip(columns, moves, strict=True)]
    for number, row in zip(numbers, rows, strict=True):
        pairs = [pair[:2] for form in row.forms for pair in form.pairs]
        linear = [place for form in row.forms for place, _ in form.linear]
        felt = np.concatenate([_felt_of(side, linear, pairs, columns[side], moves[side]) for side in range(2)])
        found.append((np.full(len(felt), number), felt))
        if row.law is not None:
            found.append(block(felt, felt))
        found += [_multiplied(pair, columns, moves) for pair in pairs]
    return found


def _felt_of(side: int, linear: list[int], pairs: list[tuple[int, int]], columns: np.ndarray, moves: int) -> np.ndarray:
    """Coordinates of one marker that a row feels: translations only where the position is multiplied or stands in the row."""
    vectors = {place // 3 for place in linear} | {vector for pair in pairs for vector in pair}
    if not any(vector // VECTORS == side for vector in vectors):
        return columns[:0]
    position = VECTORS * side
    multiplied = any(position in pair for pair in pairs)
    return columns[[c >= moves or multiplied or 3 * position + c in linear for c in range(len(columns))]]


def _multiplied(pair: tuple[int, int], columns: list[np.ndarray], moves: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Entries of a product of two vectors.

    Translations do not move axes, and only components of the same direction meet.
    """
    (side, axis), (other, second) = (divmod(vector, VECTORS) for vector in pair)
    own, theirs = (np.arange(moves[s] if a else 0, len(columns[s])) for s, a in ((side, axis), (other, second)))
    i, k = block(own, theirs)
    met = (i >= moves[side]) | (k >= moves[other]) | (i == k)
    return columns[side][i[met]], columns[other][k[met]]


def moving_unknowns(numbering: Numbering, values: Quantities, felt: np.ndarray) -> np.ndarray:
    """Unknowns (n,) that joints, loads or the frame of a body act on, so that entries between two of them may change.

    `felt` are the coordinates that markers feel.
    """
    moving = np.ones(numbering.n, bool)
    edges = [*numbering.first.values(), numbering.n_q]
    for b in values.constant:
        if b not in values.floating:
            moving[edges[b] : edges[b + 1]] = False
    moving[felt] = True
    return moving


COMPENSATED_PART = 1e-8
"""Part of the largest comparable entry from which an entry is summed in twice the precision. What is smaller leaves a round-off that is
smaller by as much, while the softest motion of a skin of 600 elements is 1e12 times softer than the stiffest. (With 1e-2, which leaves
out what couples displacements with rotations, corrections from 300 elements on never fell below 1e-10.)"""


class StiffEntries(NamedTuple):
    """Arrays of the stiffness entries that are summed in twice the precision, and of all others; fields as in `Constant`."""

    soft: np.ndarray
    stiff_row: np.ndarray
    stiff_start: np.ndarray
    stiff_column: np.ndarray
    stiff_high: np.ndarray
    stiff_low: np.ndarray


def stiff_entries(
    row: np.ndarray, column: np.ndarray, stiffness: np.ndarray, weights: np.ndarray, body: np.ndarray, bodies: int
) -> StiffEntries:
    """Stiff entries row by row, for `constant_kernel`, and before them the stiffness without them.

    Entries of one `body`, whose number each has, are compared as |K_ik| / (w_i w_k): the work of a motion by the model size, free of
    units.
    """
    size = np.abs(np.real(stiffness)) / (weights[row] * weights[column])
    largest = np.zeros(bodies)
    np.maximum.at(largest, body, size)
    chosen = np.flatnonzero((size > 0) & (size >= COMPENSATED_PART * largest[body]))
    chosen = chosen[np.argsort(row[chosen], kind="stable")]
    stiff_row, start = np.unique(row[chosen], return_index=True)
    soft, stiff = stiffness.copy(), stiffness[chosen]
    soft[chosen] = 0
    high = HALVES * stiff - (HALVES * stiff - stiff)
    return StiffEntries(soft, stiff_row, ints([start, [len(chosen)]]), column[chosen], high, stiff - high)


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
