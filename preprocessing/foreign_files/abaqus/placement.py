"""Where nodes are put: local coordinate systems of *SYSTEM and *NODE, SYSTEM=, and the translation and rotation of instances."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.abaqus.blocks import Block
from preprocessing.foreign_files.abaqus.numbers import number

SHORT = 1e-12
"""Length of an axis, in parts of the coordinates that make it, below which it has no direction."""


class Placement(NamedTuple):
    """Affine map x -> A x + b."""

    rotation: np.ndarray  # A (3, 3)
    shift: np.ndarray  # b (3,)

    def applied(self, places: np.ndarray) -> np.ndarray:
        """Places (n, 3) moved by the map."""
        return places @ self.rotation.T + self.shift


def from_cylindrical(places: np.ndarray) -> np.ndarray:
    """Coordinates x, y, z from cylindrical ones: r, angle in degrees, z."""
    angle = np.deg2rad(places[:, 1])
    return np.column_stack([places[:, 0] * np.cos(angle), places[:, 0] * np.sin(angle), places[:, 2]])


def local_system(block: Block) -> Placement | None:
    """Map from the coordinates of *SYSTEM to those of the deck; None without data lines, which end the local system.

    Its origin is a, its first axis runs through b, and c is in the plane of the first two axes.

    Without c the third axis is that of the deck, and the first one is projected on the plane of x and y. Without data lines there is no
    local system any more.
    """
    rows = [[number(text, place) for text in fields] for place, fields in block.rows()]
    if not rows:
        return None
    if len(rows) > 2 or len(rows[0]) > 6 or (rows[1:] and len(rows[1]) > 3):
        raise block.refuse("*SYSTEM has at most two lines, of 6 and 3 numbers. Fix them.")
    a, b = np.array([*rows[0], *6 * [0.0]][:6]).reshape(2, 3)
    if len(rows[0]) <= 3:
        return Placement(np.eye(3), a)
    first = b - a
    if rows[1:]:
        third = np.cross(first, np.array([*rows[1], 0.0, 0.0][:3]) - a)
    else:
        first, third = first * [1, 1, 0], np.array([0.0, 0.0, 1.0])
    return Placement(_axes(block, first, third), a)


def _axes(block: Block, first: np.ndarray, third: np.ndarray) -> np.ndarray:
    """Columns of unit axes, of which the first and the third have these directions."""
    scale = max(np.abs(first).max(), np.finfo(float).tiny)
    if np.linalg.norm(first) == 0 or np.linalg.norm(third) <= SHORT * scale * max(1.0, scale):
        raise block.refuse("the points of the local system are at one place or on one line. Give three that are apart.")
    x, z = first / np.linalg.norm(first), third / np.linalg.norm(third)
    return np.column_stack([x, np.cross(z, x), z])


def placement(block: Block) -> Placement:
    """Map of a translation, then a rotation by degrees about the axis from a to b: lines of *INSTANCE and *NCOPY, SHIFT."""
    rows = [[number(text, place) for text in fields] for place, fields in block.rows()]
    if len(rows) > 2 or (rows and len(rows[0]) > 3) or (rows[1:] and len(rows[1]) != 7):
        raise block.refuse(
            "a placement is a line with a translation, and one with points a and b of an axis and an angle. Fix it."
        )
    shift = np.array([*(rows[0] if rows else []), 0.0, 0.0, 0.0][:3])
    if not rows[1:]:
        return Placement(np.eye(3), shift)
    a, axis, angle = np.array(rows[1][:3]), np.array(rows[1][3:6]) - rows[1][:3], np.deg2rad(rows[1][6])
    if not np.linalg.norm(axis):
        raise block.refuse("the points a and b of its axis of rotation are the same. Give two.")
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turn = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return Placement(turn, turn @ (shift - a) + a)
