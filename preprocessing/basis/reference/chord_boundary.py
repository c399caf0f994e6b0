"""Rows of a boundary whose first ones tie the frame to a chord, and how they follow the places of its points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from preprocessing.basis.boundary import Boundary, free_boundary, with_points
from preprocessing.basis.reference.chord_axes import along, left, taken
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.chord_condition import Chord

STEP = 1e-30
"""Complex step through the axes of the chord."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ChordBoundary(Boundary):
    """Boundary of a chord: rows that tie the frame, then, for named points, other motions of both ends and all of the others."""

    chord: Chord
    xi: np.ndarray  # (n,), of the undeformed nodal coordinates
    interface_rows: Mapping[str, np.ndarray]

    @property
    def n_clamp(self) -> int:
        return self.per_point

    @property
    def e(self) -> np.ndarray:
        """Unit vector along the chord, (d,)."""
        return _unit(self.chord, self.interface_rows, self.xi)

    @property
    def still(self) -> np.ndarray:
        return _alone(self.rows[: self.per_point])

    @property
    def always_still(self) -> np.ndarray:
        return _alone(self.rows[: self.per_point // 3 + 1])

    def rates(self, d_interface_rows: Mapping[str, np.ndarray], d_xi: np.ndarray | None = None) -> np.ndarray:
        """Derivative dR (n_r, n) of the rows; the chord turns with its points."""
        rows = {name: row + 1j * STEP * d_interface_rows.get(name, 0.0) for name, row in self.interface_rows.items()}
        xi = self.xi + 1j * STEP * (0.0 if d_xi is None else d_xi)
        return np.imag(_rows(self.chord, rows, xi, self.points)) / STEP


def chord_boundary(
    chord: Chord, interface_rows: Mapping[str, np.ndarray], xi: np.ndarray, mass: np.ndarray | None = None
) -> ChordBoundary:
    """Boundary of a chord, with the rows of its points and of all others if there is a mass matrix.

    Parameters
    ----------
    interface_rows : name -> (3, n), in space (6, n)
    xi : (n,), of the undeformed nodal coordinates
    mass : (n, n), whose diagonal makes displacements and rotations comparable; None for the rows of the chord alone

    Raises
    ------
    InputError
        One of the two points does not exist, both are at one place, or the rows of a point depend on those before.
    """
    refuse_unknown(chord, interface_rows)
    refuse_short(chord, *(interface_rows[name][: _dimension(interface_rows)] @ xi for name in chord))
    names: tuple[str, ...] = ()
    if mass is not None:
        ordered = {name: interface_rows[name] for name in dict.fromkeys([*chord, *interface_rows])}
        names = with_points(free_boundary(len(xi), per_point(interface_rows)), ordered, mass).points
    rows = _rows(chord, interface_rows, xi, names)
    size = per_point(interface_rows)
    return ChordBoundary(rows, names, per_point=size, chord=chord, xi=xi, interface_rows=dict(interface_rows))


def refuse_unknown(chord: Chord, names: Mapping[str, Any]) -> None:
    """Refuse a chord between points that do not exist.

    Raises
    ------
    InputError
        It names those that do.
    """
    for name in chord:
        if name not in names:
            raise InputError(
                f"chord goes through interface points, but there is no {name!r}; there are {', '.join(names) or 'none'}. Name two of them."
            )


def refuse_short(chord: Chord, one: np.ndarray, other: np.ndarray) -> None:
    """Refuse two points (d,) that have no line through them.

    Raises
    ------
    InputError
        They are at one place.
    """
    if not np.linalg.norm(other - one) > 1e-9 * (np.abs(one) + np.abs(other)).max():
        raise InputError(f"chord: the points {chord.first!r} and {chord.second!r} are at one place; a chord needs two places.")


def per_point(interface_rows: Mapping[str, np.ndarray]) -> int:
    """Number of rows of a point, 3 in the plane and 6 in space."""
    return len(next(iter(interface_rows.values())))


def _dimension(interface_rows: Mapping[str, np.ndarray]) -> int:
    return per_point(interface_rows) // 3 + 1


def _unit(chord: Chord, rows: Mapping[str, np.ndarray], xi: Any) -> np.ndarray:
    d = _dimension(rows)
    return along(rows[chord.first][:d] @ xi, rows[chord.second][:d] @ xi)


def _rows(chord: Chord, rows: Mapping[str, np.ndarray], xi: Any, points: tuple[str, ...]) -> np.ndarray:
    e = _unit(chord, rows, xi)
    both = np.vstack([rows[chord.first], rows[chord.second]])
    others = [rows[name] for name in points if name not in chord]
    return np.vstack([taken(e) @ both, *([left(e) @ both, *others] if points else [])])


def _alone(rows: np.ndarray) -> np.ndarray:
    """Numbers of the coordinates that are the only one of a row."""
    found: np.ndarray = np.argmax(rows != 0, axis=1)[np.count_nonzero(rows, axis=1) == 1]
    return found
