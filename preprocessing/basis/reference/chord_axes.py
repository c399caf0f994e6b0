"""What a chord takes from its two points and what it leaves them, in displacements and rotations along and across it.

The frame keeps its axes of the undeformed shape. With the unit vector e from the first point to the second, it is tied to the body by

    plane   u_1 = 0,   n . u_2 = 0
    space   u_1 = 0,   e . theta_1 = 0,   n_2 . u_2 = n_3 . u_2 = 0

so that no force between the two points, along the chord, ever turns it. In space the first point also says how the frame turns about
the chord.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.foundation.near_ties import first_smallest


def along(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Unit vector e (d,) from one place to the other, real or with a complex step."""
    side = other - one
    return side / np.sqrt(side @ side)


def taken(e: np.ndarray) -> np.ndarray:
    """Rows (m, 2 m) of the motions of both points that the frame does not feel, m = 3 in the plane and 6 in space."""
    d, across, m = len(e), _across(e), 3 * len(e) - 3
    rows = np.zeros((m, 2 * m), np.result_type(e))
    rows[:d, :d] = np.eye(d)
    if d == 3:
        rows[3, 3:6] = e
    rows[-len(across) :, m : m + d] = across
    return rows


def left(e: np.ndarray) -> np.ndarray:
    """Rows (m, 2 m) of all other motions of both points."""
    d, m = len(e), 3 * len(e) - 3
    rows = np.zeros((m, 2 * m), np.result_type(e))
    turns = _across(e) if d == 3 else np.eye(1)
    rows[: len(turns), d:m] = turns
    rows[len(turns), m : m + d] = e
    rows[len(turns) + 1 :, m + d :] = np.eye(m - d)
    return rows


def _across(e: np.ndarray) -> np.ndarray:
    """Unit vectors (d - 1, d) across the chord; in space the first is also across the axis that the chord is farthest from."""
    if len(e) == 2:
        return np.array([[-e[1], e[0]]])
    second = np.cross(np.eye(3)[first_smallest(np.abs(np.real(e)))], e)
    second = second / np.sqrt(second @ second)
    return np.array([second, np.cross(e, second)])


def most_across(e: Any) -> np.ndarray:
    """Numbers (d - 1,) of the axes that lie most across the chord, in their order."""
    size = np.abs(np.real(e))
    return np.delete(np.arange(len(size)), first_smallest(-size + size.max()))
