"""Which entries of the loop's matrices a joint fills, by the terms of its rows: in space no more than half of all between coordinates."""

from __future__ import annotations

import numpy as np

from toolkit.compilation.numbering import Numbering
from toolkit.compilation.patterns.pattern import block
from toolkit.joints.rows import Row
from toolkit.scene.resolution import ResolvedScene
from toolkit.scene.space import SPACE

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
