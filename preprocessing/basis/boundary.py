"""The boundary of a reduced body: linear rows of nodal coordinates at the clamped node and at the interface points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from toolkit.foundation.errors import InputError

ON_CLAMP = 1e-9
"""Part of the rows of a point, relative to their size, that the clamped node does not determine, if the point sits on that node."""

INDEPENDENT = 1e-8
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
        if _new_part(clamped.rows, own, mass).max() <= ON_CLAMP:
            on_clamp.append(name)
            continue
        if _new_part(rows, own, mass).min() <= INDEPENDENT:
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
