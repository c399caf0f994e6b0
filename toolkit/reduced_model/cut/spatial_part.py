"""A part of a chain of elements in space.

Its elastic coordinates are the rotations of the first node across the chord, all coordinates of the nodes between, of the last node its
displacement along the chord and its rotations across it, and the twist: the rotation of the last node about the chord, by which the first
one turns back. So the frame rolls as the mean of its ends.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from toolkit.kinematics.beam_elements import BeamElements, at_place
from toolkit.kinematics.orientation import axes_along
from toolkit.reduced_model.cut.craig_bampton import PartShapes
from toolkit.reduced_model.cut.part import Part, Sums, chord_of_part, part_nodes, symmetric
from toolkit.reduced_model.parts import PAIRS, PieceLoads, Pieces, SpatialElements, SpatialInvariants, Surface, SurfaceLoad


class SpatialPart(Part):
    """Part of a spatial chain, whose nodes have displacements along and rotations about x, y and z."""

    per_node: ClassVar[int] = 6
    ends: ClassVar[tuple[int, int]] = (2, 4)

    def axes(self) -> np.ndarray:
        """Unit vectors as columns: two across the chord, then one along it."""
        return axes_along(chord_of_part(self.nodes, self.first, self.last))

    @staticmethod
    def functions(ends: np.ndarray, ratio: Any) -> tuple[np.ndarray, np.ndarray]:
        """Shape functions of a point of a beam: displacement (3, 12) and rotation (3, 12)."""
        across = axes_along(chord_of_part(ends, 0, 1))[:, 0]  # bending is alike about all axes across the element
        own = BeamElements.in_space(ends[None], across[None])
        return at_place(own.shape[0], ratio), at_place(own.rotation[0], ratio)

    def picture(self, whole: Any) -> dict[str, Any]:
        """Surface points of pieces, or fibres with stress, each at the same offset from its node as in the whole body."""
        if whole.pieces is not None:
            rows = rows_of_pieces(whole.pieces, self.first, self.last)
            start = 6 * (whole.pieces.element[rows] - self.first)
            ends = np.real(self.recovery)[start[:, None] + np.arange(12)]
            position = np.einsum("pdk,pkf->pdf", whole.pieces.position[rows, :, 1:], ends)
            position[:, :, 0] = whole.pieces.position[rows, :, 0]
            return {"surface": Surface(position, np.zeros((0, 3), int), np.zeros((0, 2), int))}
        if whole.surface is None or whole.stress is None or whole.surface.lines.size != len(whole.stress.element):
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
