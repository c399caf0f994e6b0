"""The boundary of a reduced body: linear rows of nodal coordinates at the clamp, interface points and a chord.

What a chord takes from its two points and what it leaves them, in displacements and rotations along and across it.

The frame keeps its axes of the undeformed shape. With the unit vector e from the first point to the second, it is tied to the body by

    plane   u_1 = 0,   n . u_2 = 0
    space   u_1 = 0,   e . theta_1 = 0,   n_2 . u_2 = n_3 . u_2 = 0

so that no force between the two points, along the chord, ever turns it. In space the first point also says how the frame turns about
the chord.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.foundation.near_ties import first_smallest
from toolkit.reduced_model.model import Chord


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


def most_across(e: np.ndarray) -> np.ndarray:
    """Numbers (d - 1,) of the axes that lie most across the chord, in their order."""
    size = np.abs(np.real(e))
    return np.delete(np.arange(len(size)), first_smallest(-size + size.max()))


CLAMPED_POINT = 1e-9
"""Part of the rows of a point, relative to their size, that the clamped node does not determine, if the point sits on that node."""

INDEPENDENT_ROWS = 1e-8
"""Smallest part of the rows of a point that the rows before do not determine. It falls with the third power of the distance between
neighbours in one element, and round-off times its inverse is lost in the constraint modes."""


@dataclass(frozen=True, eq=False)
class Boundary:
    """Constraint rows R (n_r, n): those of the clamped nodes, if any, then three (in space six) of every named point."""

    rows: np.ndarray
    points: tuple[str, ...] = ()
    on_clamp: tuple[str, ...] = ()  # points without rows of their own
    per_point: int = 3

    @property
    def n_clamp(self) -> int:
        """Number of rows that belong to the clamped nodes."""
        return len(self.rows) - self.per_point * len(self.points)

    @property
    def still(self) -> np.ndarray:
        """Numbers of coordinates whose round-off in computed shapes is to be zero."""
        return np.zeros(0, int)

    @property
    def always_still(self) -> np.ndarray:
        """Numbers of those coordinates among `still` that are held at every design."""
        return np.zeros(0, int)

    def rates(self, d_interface_rows: Mapping[str, np.ndarray], d_xi: np.ndarray | None = None) -> np.ndarray:
        """Derivative dR (n_r, n) from those (3 or 6, n) of the rows of points; points that are not named do not change.

        Nor do the clamped nodes with the undeformed shape, whose derivative is `d_xi` (n,).

        Raises
        ------
        InputError
            A point leaves the clamped node.
        """
        for name in self.on_clamp:
            if np.any(d_interface_rows.get(name, 0.0)):
                raise InputError(
                    f"interface point {name!r} sits on the clamped node, and moving it away adds coordinates to the basis, which has "
                    "no derivative. Place the point inside the skin, or leave its position out of the design."
                )
        still = np.zeros((self.per_point, self.rows.shape[1]))
        return np.vstack([np.zeros_like(self.rows[: self.n_clamp]), *(d_interface_rows.get(name, still) for name in self.points)])


def free_boundary(n: int, per_point: int = 3) -> Boundary:
    """Boundary without rows on n nodal coordinates."""
    return Boundary(np.zeros((0, n)), per_point=per_point)


def clamped_boundary(n: int, nodes: int | Sequence[int], per_node: int = 3) -> Boundary:
    """Boundary that holds all coordinates of one node (negative: from the end) or several, three of each, in space six."""
    return Boundary(np.eye(n)[coordinates_of(nodes, n // per_node, per_node)], per_point=per_node)


def coordinates_of(nodes: int | Sequence[int], n_nodes: int, per_node: int) -> np.ndarray:
    """Numbers of all coordinates of one node (negative: from the end) or of several."""
    return (np.arange(per_node) + per_node * (np.atleast_1d(np.asarray(nodes, int)) % n_nodes)[:, None]).ravel()


def with_points(clamped: Boundary, interface_rows: Mapping[str, np.ndarray], mass: np.ndarray) -> Boundary:
    """Boundary of the clamped node and the interface points; a point on the clamped node adds no rows.

    Parameters
    ----------
    interface_rows : name -> (3, n), in space (6, n)
    mass : (n, n), whose diagonal makes displacements and rotations comparable

    Raises
    ------
    InputError
        The rows of a point depend on those before: two names for one place, or more than two points in one element.
    """
    rows = clamped.rows
    points: list[str] = []
    on_clamp: list[str] = []
    for name, own in interface_rows.items():
        if _new_part(clamped.rows, own, mass).max() <= CLAMPED_POINT:
            on_clamp.append(name)
            continue
        if _new_part(rows, own, mass).min() <= INDEPENDENT_ROWS:
            raise InputError(
                f"interface point {name!r} cannot move independently of "
                f"{', '.join(repr(point) for point in points) or 'the clamped node'}: give every place one name, keep points apart, "
                "and have at most two in one element (use more elements)."
            )
        rows = np.vstack([rows, own])
        points.append(name)
    return Boundary(rows, tuple(points), tuple(on_clamp), clamped.per_point)


def _new_part(rows: np.ndarray, own: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """Singular values of a point's own rows, scaled to length one, without their part in the span of `rows`."""
    scale = 1 / np.sqrt(np.diag(mass))
    known, _ = np.linalg.qr((rows * scale).T)
    scaled = own * scale
    scaled = scaled / np.linalg.norm(scaled, axis=1, keepdims=True)
    return np.linalg.svd(scaled - scaled @ known @ known.T, compute_uv=False)


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


def refuse_unknown(chord: Chord, names: Collection[str]) -> None:
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


def _unit(chord: Chord, rows: Mapping[str, np.ndarray], xi: np.ndarray) -> np.ndarray:
    d = _dimension(rows)
    return along(rows[chord.first][:d] @ xi, rows[chord.second][:d] @ xi)


def _rows(chord: Chord, rows: Mapping[str, np.ndarray], xi: np.ndarray, points: tuple[str, ...]) -> np.ndarray:
    e = _unit(chord, rows, xi)
    both = np.vstack([rows[chord.first], rows[chord.second]])
    others = [rows[name] for name in points if name not in chord]
    return np.vstack([taken(e) @ both, *([left(e) @ both, *others] if points else [])])


def _alone(rows: np.ndarray) -> np.ndarray:
    """Numbers of the coordinates that are the only one of a row."""
    found: np.ndarray = np.argmax(rows != 0, axis=1)[np.count_nonzero(rows, axis=1) == 1]
    return found
