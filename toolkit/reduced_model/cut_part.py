"""A part of a chain of elements with a frame of its own through both of its ends, in the plane and in space.

A part of a chain of elements with a frame of its own, which goes through both of its ends.

The first node of a part stays in its place in the frame, and the last one on the line through both: the chord. The elastic coordinates are
what this leaves of its nodal coordinates. With the matrix C that gives the nodal coordinates from these, and all sums over the elements of
the part,

    N = (sum N_e) C,   G = C^T (sum G_e) C,   H = C^T (sum H_e) C,   K = C^T (sum K_e) C,   stress operator = B C

and in space Q_ab as G. All axes and the origin are those of the whole undeformed body. A reduced part has the columns of C times those of
its Craig-Bampton shapes in the place of C.

A part of a chain of elements in the plane.

Its elastic coordinates are the rotation of the first node, all coordinates of the nodes between, and of the last node its displacement
along the chord and its rotation.

A part of a chain of elements in space.

Its elastic coordinates are the rotations of the first node across the chord, all coordinates of the nodes between, of the last node its
displacement along the chord and its rotations across it, and the twist: the rotation of the last node about the chord, by which the first
one turns back. So the frame rolls as the mean of its ends.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, TypedDict

import numpy as np
import scipy

from toolkit.foundation.errors import InputError
from toolkit.foundation.kinematics.beam_elements import BeamElements, at_place
from toolkit.foundation.kinematics.orientation import axes_along
from toolkit.reduced_model.cut_chain import ChainPlace, PartShapes, nodes_of_part
from toolkit.reduced_model.dependence import is_sparse, sparing
from toolkit.reduced_model.model import Chord, InterfacePoint, Invariants, Mesh, ReducedModel, StressPoints
from toolkit.reduced_model.parts import (
    PAIRS,
    Elements,
    PieceLoads,
    Pieces,
    SpatialElements,
    SpatialInvariants,
    Surface,
    SurfaceLoad,
)

if TYPE_CHECKING:
    from toolkit.foundation.value_types import Matrix, Scalar

SHORTEST_CHORD = 1e-3
"""Distance of the ends of a part in parts of its length, below which no chord leads from one to the other."""
SEARCHED_MATRIX_SIZE = 10_000
"""Numbers of a matrix C that is worth the search for those that are not zero: it stands on both sides of many sums."""


class PartPicture(TypedDict, total=False):
    """Fields of a reduced model that pictures of a part need."""

    mesh: Mesh
    surface: Surface


@dataclass(frozen=True)
class ChainPart(ABC):
    """Part of a chain: its elements from `first` up to, but without, `last`."""

    first: int
    last: int
    nodes: np.ndarray  # (n_nodes, d) of the part, undeformed
    recovery: np.ndarray  # (n, 1 + n_f) Z on the nodal coordinates of the part
    invariants: Any
    stress_rows: np.ndarray  # numbers of its stress points among those of the body

    per_node: ClassVar[int]
    """Coordinates of a node: displacements, then rotations."""
    ends: ClassVar[tuple[int, int]]
    """Elastic coordinates of the first and of the last node, where nothing is reduced."""

    @classmethod
    def kept(cls, count: int, nodes: Sequence[int]) -> np.ndarray:
        """Numbers of the elastic coordinates at both ends and at some nodes between, in order, of a part of `count` nodes."""
        first, last = cls.ends
        size = first + cls.per_node * (count - 2) + last
        inner = first + cls.per_node * (np.array(nodes, int)[:, None] - 1) + np.arange(cls.per_node)
        return np.unique(np.concatenate([np.arange(first), inner.ravel(), np.arange(size - last, size)]))

    @property
    def n_f(self) -> int:
        """Number of elastic coordinates."""
        return self.recovery.shape[1] - 1

    def at(self, place: ChainPlace) -> tuple[np.ndarray, np.ndarray]:
        """Shape functions Z_P (d, 1 + n_f) and T_P (1 + n_f,), in space (3, 1 + n_f), at a point of an element."""
        start, n, d = place.element - self.first, self.per_node, self.nodes.shape[1]
        local = self.recovery[n * start : n * (start + 2)]
        if place.ratio in (0.0, 1.0):
            rows = local[:n] if place.ratio == 0 else local[n:]
            return rows[:d], rows[d] if n == d + 1 else rows[d:]
        shape, turn = self.functions(self.nodes[start : start + 2], place.ratio)
        return shape @ local, turn @ local

    @abstractmethod
    def axes(self) -> np.ndarray:
        """Unit vectors along and across the chord, (d, d)."""

    @staticmethod
    @abstractmethod
    def functions(ends: np.ndarray, ratio: Scalar) -> tuple[np.ndarray, np.ndarray]:
        """Displacement (d, 2 per_node) and rotation of a point of a beam per coordinate of its ends."""

    @abstractmethod
    def picture(self, whole: ReducedModel) -> PartPicture:
        """Fields of a reduced model that pictures of the part need, from the reduced model of the whole body."""


@dataclass(frozen=True)
class Sums:
    """Sums over some elements of a chain, on elastic coordinates that a matrix C (n, n_f) maps to the nodal ones."""

    own: slice  # elements
    nodes: np.ndarray  # (n_nodes, d)
    psi: np.ndarray  # C
    per_node: int

    @property
    def z(self) -> np.ndarray:
        """Matrix [[1, 0], [0, C]] with the undeformed shape as a coordinate of its own."""
        found = np.zeros((1 + len(self.psi), 1 + self.psi.shape[1]), self.psi.dtype)
        found[0, 0], found[1:, 1:] = 1, self.psi
        return found

    @property
    def where(self) -> np.ndarray:
        """Numbers of the nodal coordinates of every element, (n_elements, 2 per_node)."""
        return self.per_node * np.arange(len(self.nodes) - 1)[:, None] + np.arange(2 * self.per_node)

    @property
    def whole(self) -> np.ndarray:
        """Numbers of the undeformed shape, 0, and of the nodal coordinates of every element, (n_elements, 1 + 2 per_node)."""
        return np.column_stack([np.zeros(len(self.nodes) - 1, int), 1 + self.where])

    def reduced(self, shapes: PartShapes | None, stiffness: np.ndarray) -> Sums:
        """Sums on fewer coordinates, by the blocks of the stiffness at this design; on the same ones without shapes."""
        return self if shapes is None else replace(self, psi=self.psi @ shapes.columns(self.square(stiffness)))

    def moment(self, blocks: np.ndarray) -> np.ndarray:
        """Sum of blocks (n_e, 1 + 2 per_node, ..) on the undeformed shape and the elastic coordinates."""
        return _between(sparing(self.z, SEARCHED_MATRIX_SIZE), blocks[self.own], self.whole)

    def square(self, blocks: np.ndarray) -> np.ndarray:
        """Sum of symmetric blocks (n_e, 2 per_node, ..) on the elastic coordinates, symmetric."""
        return symmetric(_between(sparing(self.psi, SEARCHED_MATRIX_SIZE), blocks[self.own], self.where))

    def first_moment(self, blocks: np.ndarray) -> np.ndarray:
        """Sum of blocks (n_e, d, 1 + 2 per_node) on the undeformed shape and the elastic coordinates."""
        columns: np.ndarray = np.zeros((blocks.shape[1], 1 + len(self.psi)), blocks.dtype)
        for block, places in zip(blocks[self.own], self.whole, strict=True):
            columns[:, places] += block
        return columns @ self.z

    def stress(self, rows: np.ndarray, element: np.ndarray) -> np.ndarray:
        """Rows of the stress operator on the elastic coordinates, from rows (n_s, 2 per_node) on those of elements."""
        return np.einsum("sl,slf->sf", rows, self.psi[self.where[element]])

    @property
    def recovery(self) -> np.ndarray:
        """Matrix Z on the nodal coordinates: undeformed places, then C."""
        turns = np.zeros((len(self.nodes), self.per_node - self.nodes.shape[1]))
        return np.column_stack([np.column_stack([self.nodes, turns]).ravel(), self.psi])


def chord_of_part(nodes: np.ndarray, first: int, last: int) -> np.ndarray:
    """Unit vector (d,) from the first to the last of the nodes (n, d) of a part.

    Raises
    ------
    InputError
        No chord leads from one to the other.
    """
    chord, sides = nodes[-1] - nodes[0], np.real(np.diff(nodes, axis=0))
    length = np.sqrt(chord @ chord)
    if np.real(length) <= SHORTEST_CHORD * np.sqrt((sides * sides).sum(axis=1)).sum():
        raise InputError(
            f"the part of a flexible body from node {first} to node {last} begins where it ends, so that its frame has no chord to "
            "turn with. Write other `frames`."
        )
    found: np.ndarray = chord / length
    return found


def part_nodes(elements: Elements | SpatialElements, first: int, last: int) -> np.ndarray:
    """Undeformed positions (n, d) of the nodes of a part."""
    found: np.ndarray = elements.nodes[nodes_of_part(elements.connectivity, first, last)]
    return found


def _between(shapes: Matrix, blocks: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Product C^T A C of shapes C (n, ..), sparse or dense; A (n, n) sums blocks (n_e, k, k) at places (n_e, k)."""
    where, size = (places[:, :, None], places[:, None, :]), (shapes.shape[0], shapes.shape[0])
    if is_sparse(shapes):
        row, column = (each.ravel() for each in np.broadcast_arrays(*where))
        found: np.ndarray = (shapes.T @ scipy.sparse.coo_array((blocks.ravel(), (row, column)), size).tocsr() @ shapes).toarray()
        return found
    placed = np.zeros(size, blocks.dtype)
    np.add.at(placed, where, blocks)
    return shapes.T @ placed @ shapes


def symmetric(matrix: np.ndarray) -> np.ndarray:
    """Symmetric part of a matrix that is symmetric but for round-off."""
    return (matrix + matrix.T) / 2


class PlanarPart(ChainPart):
    """Part of a planar chain, whose nodes have two displacements and a rotation."""

    per_node: ClassVar[int] = 3
    ends: ClassVar[tuple[int, int]] = (1, 2)

    def axes(self) -> np.ndarray:
        """Unit vectors along and across the chord, as columns."""
        x, y = chord_of_part(self.nodes, self.first, self.last)
        return np.array([[x, -y], [y, x]])

    @staticmethod
    def functions(ends: np.ndarray, ratio: Scalar) -> tuple[np.ndarray, np.ndarray]:
        """Shape functions of a point of a beam: displacement (2, 6) and rotation (6,)."""
        own = BeamElements.in_plane(ends[None])
        return at_place(own.shape[0], ratio), at_place(own.rotation[0], ratio)

    def picture(self, whole: ReducedModel) -> PartPicture:
        """Mesh of the part, for pictures."""
        outline = np.zeros((0, 2)) if whole.mesh is None else whole.mesh.target_outline
        connectivity = np.arange(len(self.nodes) - 1)[:, None] + np.arange(2)
        return {"mesh": Mesh(np.real(self.nodes), connectivity, np.real(self.recovery), np.real(self.nodes), outline)}


def planar_part(
    elements: Elements, first: int, last: int, stress_elements: np.ndarray, shapes: PartShapes | None = None
) -> PlanarPart:
    """Part of a planar chain from one of its elements up to, but without, another.

    Parameters
    ----------
    elements
        At one design, real or complex.
    stress_elements
        Element of every stress point, (n_stress,).
    shapes
        That its elastic coordinates are reduced to.

    Raises
    ------
    InputError
        No chord leads from its first node to its last.
    """
    nodes = part_nodes(elements, first, last)
    every = Sums(slice(first, last), nodes, _planar_coordinates(nodes, chord_of_part(nodes, first, last)), PlanarPart.per_node)
    sums = every.reduced(shapes, elements.stiffness)
    gyroscopic = sums.moment(elements.gyroscopic)
    rows = np.flatnonzero((stress_elements >= first) & (stress_elements < last))
    invariants = Invariants(
        mass=elements.mass[first:last].sum(),
        first_moment=sums.first_moment(elements.first_moment),
        inertia=symmetric(sums.moment(elements.inertia)),
        gyroscopic=(gyroscopic - gyroscopic.T) / 2,
        stiffness=sums.square(elements.stiffness),
        damping=sums.square(elements.damping),
        stress_operator=sums.stress(elements.stress_operator[rows], stress_elements[rows] - first),
    )
    return PlanarPart(first, last, nodes, sums.recovery, invariants, rows)


def _planar_coordinates(nodes: np.ndarray, chord: np.ndarray) -> np.ndarray:
    """Nodal coordinates per elastic coordinate, (3 n_nodes, n_f)."""
    n = 3 * len(nodes)
    found = np.zeros((n, n - 3), chord.dtype)
    found[2, 0] = 1
    found[3 : n - 3, 1 : n - 5] = np.eye(n - 6)
    found[n - 3 : n - 1, n - 5] = chord
    found[n - 1, n - 4] = 1
    return found


class SpatialPart(ChainPart):
    """Part of a spatial chain, whose nodes have displacements along and rotations about x, y and z."""

    per_node: ClassVar[int] = 6
    ends: ClassVar[tuple[int, int]] = (2, 4)

    def axes(self) -> np.ndarray:
        """Unit vectors as columns: two across the chord, then one along it."""
        return axes_along(chord_of_part(self.nodes, self.first, self.last))

    @staticmethod
    def functions(ends: np.ndarray, ratio: Scalar) -> tuple[np.ndarray, np.ndarray]:
        """Shape functions of a point of a beam: displacement (3, 12) and rotation (3, 12)."""
        across = axes_along(chord_of_part(ends, 0, 1))[:, 0]  # bending is alike about all axes across the element
        own = BeamElements.in_space(ends[None], across[None])
        return at_place(own.shape[0], ratio), at_place(own.rotation[0], ratio)

    def picture(self, whole: ReducedModel) -> PartPicture:
        """Surface points of pieces, or fibres with stress, each at the same offset from its node as in the whole body."""
        if whole.pieces is not None:
            rows = rows_of_pieces(whole.pieces, self.first, self.last)
            start = 6 * (whole.pieces.element[rows] - self.first)
            ends = np.real(self.recovery)[start[:, None] + np.arange(12)]
            position = np.einsum("pdk,pkf->pdf", whole.pieces.position[rows, :, 1:], ends)
            position[:, :, 0] = whole.pieces.position[rows, :, 0]
            return {"surface": Surface(position, np.zeros((0, 3), int), np.zeros((0, 2), int))}
        if (
            whole.elements is None
            or whole.surface is None
            or whole.stress is None
            or whole.surface.lines.size != len(whole.stress.element)
        ):
            return {}
        element, end = (each[self.stress_rows].astype(int) for each in (whole.stress.element, whole.stress.end))
        at = whole.elements.nodes[whole.elements.connectivity[element, end]]
        offset = whole.surface.position[whole.surface.lines.ravel()[self.stress_rows], :, 0] - at
        by_node = np.real(self.recovery).reshape(len(self.nodes), 6, -1)[element - self.first + end]
        position = by_node[:, :3] + np.cross(by_node[:, 3:], offset[:, :, None], axis=1)
        position[:, :, 0] += offset
        return {"surface": Surface(position, np.zeros((0, 3), int), np.arange(len(position)).reshape(-1, 2))}


def rows_of_pieces(pieces: Pieces, first: int, last: int) -> np.ndarray:
    """Numbers of the surface points that belong to elements from `first` up to, but without, `last`."""
    return np.flatnonzero((pieces.element >= first) & (pieces.element < last))


def spatial_part(
    elements: SpatialElements, first: int, last: int, stress_elements: np.ndarray, shapes: PartShapes | None = None
) -> SpatialPart:
    """Part of a spatial chain from one of its elements up to, but without, another; as `planar_part`.

    Raises
    ------
    InputError
        No chord leads from its first node to its last.
    """
    nodes = part_nodes(elements, first, last)
    every = Sums(slice(first, last), nodes, _coordinates(nodes, chord_of_part(nodes, first, last)), SpatialPart.per_node)
    sums = every.reduced(shapes, elements.stiffness)
    moments = [sums.moment(elements.second_moment[:, k]) for k in range(len(PAIRS))]
    rows = np.flatnonzero((stress_elements >= first) & (stress_elements < last))
    invariants = SpatialInvariants(
        mass=elements.mass[first:last].sum(),
        first_moment=sums.first_moment(elements.first_moment),
        second_moment=np.stack([symmetric(each) if a == b else each for each, (a, b) in zip(moments, PAIRS, strict=True)]),
        stiffness=sums.square(elements.stiffness),
        damping=sums.square(elements.damping),
        stress_operator=_stress(sums, elements.stress_operator, stress_elements, rows),
    )
    return SpatialPart(first, last, nodes, sums.recovery, invariants, rows)


def pressed(part: SpatialPart, loads: PieceLoads) -> SurfaceLoad:
    """Unit pressure on a part, as a surface load on its own coordinates."""
    force, every = loads.force[part.first : part.last].sum(axis=0), loads.moment[part.first : part.last]
    blocks, n = np.moveaxis(every.reshape(len(every), 9, -1), 1, 0), SpatialPart.per_node
    on_nodes: np.ndarray = np.zeros((9, len(part.recovery)), every.dtype)
    for k in range(len(every)):
        on_nodes[:, n * k : n * (k + 2)] += blocks[:, k, 1:]
    moment = np.column_stack([blocks[:, :, 0].sum(axis=1), on_nodes @ part.recovery[:, 1:]])
    return SurfaceLoad(force, moment.reshape(3, 3, -1))


def _stress(sums: Sums, operator: np.ndarray, elements: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Rows of the stress operator at some stress points, given the element of each point, (n, n_components, n_f)."""
    components = len(operator) // len(elements) if len(elements) else 1
    every = (components * rows[:, None] + np.arange(components)).ravel()
    found = sums.stress(operator[every], np.repeat(elements[rows], components) - sums.own.start)
    return found.reshape(len(rows), components, sums.psi.shape[1])


def _coordinates(nodes: np.ndarray, chord: np.ndarray) -> np.ndarray:
    """Nodal coordinates per elastic coordinate, (6 n_nodes, n_f)."""
    n, across = 6 * len(nodes), axes_along(chord)[:, :2]
    found = np.zeros((n, n - 6), chord.dtype)
    found[3:6, :2] = across
    found[6 : n - 6, 2 : n - 10] = np.eye(n - 12)
    found[n - 6 : n - 3, n - 10] = chord
    found[n - 3 :, n - 9 : n - 7] = across
    found[3:6, n - 7], found[n - 3 :, n - 7] = -chord, chord
    return found


FIRST, LAST = "first node", "last node"
"""Names of the interface points at the ends of a part."""


def part_model(part: ChainPart, whole: ReducedModel) -> ReducedModel:
    """Reduced model of a part at the design that the part was made at; it contains no dependence on the design."""
    ends = {FIRST: ChainPlace(part.first, 0.0), LAST: ChainPlace(part.last - 1, 1.0)}
    stress = None
    if whole.stress is not None:
        found = {name: array[part.stress_rows] for name, array in vars(whole.stress).items()}
        stress = StressPoints(**{**found, "element": found["element"] - part.first})
    return ReducedModel(
        dimension=whole.dimension,
        units=whole.units,
        reference_condition=Chord(FIRST, LAST).condition,
        basis=whole.basis,
        nominal=whole.nominal,
        nominal_units=whole.nominal_units,
        input_hash=whole.input_hash,
        writers=whole.writers,
        invariants=part.invariants,
        interfaces={name: _at(part, place) for name, place in ends.items()},
        stress=stress,
        path=whole.path,
        **part.picture(whole),
    )


def _at(part: ChainPart, place: ChainPlace) -> InterfacePoint:
    position, rotation = part.at(place)
    return InterfacePoint(np.array(place.station), np.full(2, place.station), position[None], rotation[None])
