"""Reference conditions and bases: what the elastic coordinates of the body mean."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from preprocessing.reduction.basis import BasisChoice, ElasticShapes, InterfaceShapes, ModeShapes, ReductionBasis
from preprocessing.reduction.boundary import (
    Boundary,
    ChordBoundary,
    chord_boundary,
    clamped_boundary,
    coordinates_of,
    free_boundary,
    most_across,
    with_points,
)
from preprocessing.reduction.constrained_pencil import ConstrainedPencil, constrained_pencil, constraint_modes
from preprocessing.reduction.normal_modes import (
    NormalModes,
    count_by_frequency,
    count_by_static_error,
    normal_modes,
    refuse_cut_cluster,
    slowest_left_out,
)
from toolkit.foundation.errors import InputError
from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.value_types import Matrix
from toolkit.reduced_model.model import MEAN_AXES, Chord

REGULAR_CONDITION = 1e-6
"""Reciprocal condition of the rows on the coordinates that follow, below which two points share their nodes."""


@dataclass(frozen=True, eq=False)
class PinnedCoordinates:
    """Coordinates u_p = -R_p^-1 R_f u_f that follow from rows R of the chord, as many as it has."""

    rows: np.ndarray  # (m, n)
    pinned: np.ndarray  # (m,) numbers of coordinates

    follows_matrices: ClassVar[bool] = False

    @cached_property
    def columns(self) -> np.ndarray:
        """Shapes on the nodal coordinates, (n, n - m)."""
        n = self.rows.shape[1]
        free = np.delete(np.arange(n), self.pinned)
        shapes = np.eye(n)[:, free]
        shapes[self.pinned] = -np.linalg.solve(self.rows[:, self.pinned], self.rows[:, free])
        return shapes

    def rates(self, d_pencils: Sequence[ConstrainedPencil]) -> np.ndarray:
        """Derivatives (n, n - m, n_x) of the shapes: R dPsi = -dR Psi, in the coordinates that follow."""
        found = np.zeros((*self.columns.shape, len(d_pencils)))
        for k, each in enumerate(d_pencils):
            found[self.pinned, :, k] = -np.linalg.solve(self.rows[:, self.pinned], each.rows @ self.columns)
        return found


def pinned_coordinates(boundary: ChordBoundary) -> PinnedCoordinates:
    """Coordinates that follow the others: those of the nodes nearest to both points, as far as they lie across the chord.

    Raises
    ------
    InputError
        Both points have the same nearest node, or the rows do not hold the body there.
    """
    m, e = boundary.per_point, boundary.e
    across = most_across(e)
    one, other = (m * _nearest(boundary.interface_rows[name], m) for name in boundary.chord)
    turn = [] if len(e) == 2 else [one + 3 + next(k for k in range(3) if k not in across)]
    pinned = np.array([*(one + np.arange(len(e))), *turn, *(other + across)])
    found = PinnedCoordinates(boundary.rows[:m], pinned)
    if one == other or not 1 / np.linalg.cond(found.rows[:, pinned]) > REGULAR_CONDITION:
        raise InputError(
            f"chord: the points {boundary.chord.first!r} and {boundary.chord.second!r} are nearest to one node, so that the line through "
            "them turns with a single element. Choose points that are apart, or use more elements."
        )
    return found


def _nearest(rows: np.ndarray, m: int) -> int:
    """Number of the node that moves a point most."""
    weight = np.abs(rows[0].reshape(-1, m)[:, 0])
    for axis in range(1, m // 3 + 1):
        weight = weight + np.abs(rows[axis].reshape(-1, m)[:, axis])
    return first_largest(weight)


IDENTITY = "differentiated: identity on the free coordinates, the same at every design"

DEPENDENT_SHAPES = 1e-11
"""Smallest eigenvalue of the mass matrix of frame and basis, scaled to a unit diagonal; the runtime refuses bodies below a tenth of it."""


def undeformed(nodes: np.ndarray) -> np.ndarray:
    """Undeformed shape xi (n,): node positions (n_nodes, d) on the translations, zero on rotations of straight elements."""
    return np.column_stack([nodes, np.zeros((len(nodes), per_node(nodes) - nodes.shape[1]))]).ravel()


def per_node(nodes: np.ndarray) -> int:
    """Number of coordinates of a node, of nodes (n_nodes, d): three in the plane, six in space."""
    return 3 if nodes.shape[1] == 2 else 6


def tangent_frame(nodes: np.ndarray, node: int | Sequence[int], name: str) -> ReductionBasis:
    """Basis with all nodal coordinates but those of one node, or of several, that the frame is tied to; nothing is reduced.

    The frame keeps the axes and the origin of the nodes' coordinates and moves with the clamped node as with a rigid wall.
    """
    n = per_node(nodes) * len(nodes)
    free = np.delete(np.arange(n), coordinates_of(node, len(nodes), per_node(nodes)))
    psi = np.eye(n)[:, free]
    return ReductionBasis(
        np.column_stack([undeformed(nodes), psi]),
        clamped_in_tangent_frame(name),
        IDENTITY,
    )


def clamped_in_tangent_frame(name: str) -> str:
    """Reference condition of a body whose frame is tied to one of its nodes."""
    return f"tangent frame: the nodal coordinates of {name} are clamped in the frame of the undeformed shape"


def reduced_basis(
    choice: BasisChoice,
    mass: Matrix,
    stiffness: Matrix,
    nodes: np.ndarray,
    node: int | Sequence[int],
    name: str,
    interface_rows: Mapping[str, np.ndarray],
) -> ReductionBasis:
    """Chosen basis at one design.

    Parameters
    ----------
    mass, stiffness : (n, n)
        M and K on all n = 3 n_nodes nodal coordinates, in space 6 n_nodes.
    nodes : (n_nodes, d)
    node, name : int or several, str
        The node that is clamped (unless the boundary is free, or there is a chord), and what to call it.
    interface_rows : name -> (3, n), in space (6, n)
        Rows that give displacement and rotation of an interface point from the nodal coordinates.

    Raises
    ------
    InputError
        The choice asks for what the mesh or its interface points cannot give.
    """
    chord = None if choice.chord is None else Chord(*choice.chord)
    if choice.kind == "full":
        return tangent_frame(nodes, node, name) if chord is None else _chord_frame(choice, chord, nodes, interface_rows)
    pencil = constrained_pencil(stiffness, mass)
    boundary = _boundary(choice, chord, pencil.mass, nodes, node, interface_rows)
    every = normal_modes(ConstrainedPencil(pencil.stiffness, pencil.mass, boundary.rows))
    interface, modes = _interface_shapes(choice, pencil, boundary), _modes(choice, every, interface_rows)
    parts: list[ElasticShapes] = [*interface, *(ModeShapes(found) for found in modes if found.count)]
    psi = np.column_stack([part.columns for part in parts])
    psi[boundary.still] = 0
    _refuse_dependent(np.column_stack([motions_of_the_frame(nodes), psi]), pencil.mass, boundary)
    return ReductionBasis(
        np.column_stack([undeformed(nodes), psi]),
        chord.condition if chord else MEAN_AXES if choice.boundary == "free" else clamped_in_tangent_frame(name),
        _description(choice, boundary, modes),
        np.concatenate([found.frequencies for found in modes] or [np.zeros(0)]),
        slowest_left_out(modes[0].discarded if modes else every.eigenvalues, bool(boundary.points)),
        boundary,
        every.beyond(modes[0].count if modes else 0),
        tuple(parts) if choice.derivative == "differentiated" else (),
    )


def _chord_frame(
    choice: BasisChoice, chord: Chord, nodes: np.ndarray, interface_rows: Mapping[str, np.ndarray]
) -> ReductionBasis:
    """Basis with all nodal coordinates but as many as the chord holds; nothing is reduced."""
    boundary = chord_boundary(chord, interface_rows, undeformed(nodes))
    shapes = pinned_coordinates(boundary)
    return ReductionBasis(
        np.column_stack([undeformed(nodes), shapes.columns]),
        chord.condition,
        f"{choice.derivative}: all coordinates that the chord leaves free",
        boundary=boundary,
        parts=(shapes,) if choice.derivative == "differentiated" else (),
    )


def _boundary(
    choice: BasisChoice,
    chord: Chord | None,
    mass: np.ndarray,
    nodes: np.ndarray,
    node: int | Sequence[int],
    interface_rows: Mapping[str, np.ndarray],
) -> Boundary:
    """Boundary of what holds the body and, unless only its modes are asked for, of its interface points."""
    points = choice.kind != "eigenmodes"
    if chord is not None:
        return chord_boundary(chord, interface_rows, undeformed(nodes), mass if points else None)
    if choice.boundary == "free":
        return free_boundary(len(mass))
    clamped = clamped_boundary(len(mass), node, per_node(nodes))
    return with_points(clamped, interface_rows, mass) if points else clamped


def _interface_shapes(choice: BasisChoice, pencil: ConstrainedPencil, boundary: Boundary) -> list[ElasticShapes]:
    if choice.kind == "eigenmodes":
        return []
    if not boundary.points:
        raise InputError(
            f"a {choice.kind} basis needs an interface point away from the clamped node; got {', '.join(boundary.on_clamp) or 'none'}."
        )
    return [InterfaceShapes(constraint_modes(pencil.stiffness, boundary.rows), boundary.n_clamp)]


def _modes(choice: BasisChoice, every: NormalModes, interface_rows: Mapping[str, np.ndarray]) -> list[NormalModes]:
    """Modes that the choice asks for: one set, or none for a static basis."""
    if choice.kind == "static":
        return []
    kept = every.lowest(_count(choice, every, interface_rows))
    if choice.derivative == "differentiated":
        refuse_cut_cluster(kept)
    return [kept]


def _count(choice: BasisChoice, every: NormalModes, interface_rows: Mapping[str, np.ndarray]) -> int:
    if choice.frequency is not None:
        return count_by_frequency(every, choice.frequency, least=1 if choice.kind == "eigenmodes" else 0)
    if choice.beside_frozen:
        return min(choice.count or 0, every.count)
    if choice.static_error is not None:
        rows = np.vstack([np.zeros((0, len(every.shapes))), *interface_rows.values()])
        return count_by_static_error(every, rows, choice.static_error)
    return choice.count or 0


def motions_of_the_frame(nodes: np.ndarray) -> np.ndarray:
    """Nodal coordinates of the unit translations and rotations, (n, 3) or (n, 6)."""
    if nodes.shape[1] == 3:
        return spatial_motions(nodes)
    motions = np.tile(np.eye(3, dtype=nodes.dtype), (len(nodes), 1))
    motions[0::3, 2], motions[1::3, 2] = -nodes[:, 1], nodes[:, 0]
    return motions


def spatial_motions(nodes: np.ndarray) -> np.ndarray:
    """Nodal coordinates of the unit translations along and rotations about x, y and z, (6 n_nodes, 6), for nodes (n_nodes, 3)."""
    motions = np.zeros((len(nodes), 6, 6), nodes.dtype)
    motions[:] = np.eye(6)
    motions[:, :3, 3:] = np.cross(np.eye(3)[None, :, :], nodes[:, None, :]).swapaxes(1, 2)
    return motions.reshape(-1, 6)


def _refuse_dependent(motions: np.ndarray, mass: np.ndarray, boundary: Boundary) -> None:
    inertia = motions.T @ mass @ motions
    scale = 1 / np.sqrt(np.diag(inertia))
    smallest = np.linalg.eigvalsh(scale[:, None] * inertia * scale)[0]
    if smallest <= DEPENDENT_SHAPES:
        raise InputError(
            f"the motions of the frame and of the interface points {', '.join(boundary.points) or '(none)'} cannot be told apart "
            f"(smallest eigenvalue of their mass matrix {smallest:.0e}). Move points apart that share an element, use more elements, "
            "or fewer modes."
        )


def _description(choice: BasisChoice, boundary: Boundary, modes: list[NormalModes]) -> str:
    shapes = []
    if boundary.points:
        shapes.append(
            f"{len(boundary.rows) - boundary.n_clamp} constraint modes of the interface points {', '.join(boundary.points)}"
        )
    fixed = "fixed-interface" if boundary.points else "pinned" if choice.chord else choice.boundary
    shapes += [f"{found.count} {fixed} eigenmodes up to {found.frequencies[-1]:.6g} Hz" for found in modes if found.count]
    return f"{choice.derivative}: {choice.kind}, {' and '.join(shapes)}"
