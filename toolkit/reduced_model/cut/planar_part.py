"""A part of a chain of elements in the plane.

Its elastic coordinates are the rotation of the first node, all coordinates of the nodes between, and of the last node its displacement
along the chord and its rotation.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from toolkit.kinematics.beam_elements import BeamElements, at_place
from toolkit.reduced_model.cut.craig_bampton import PartShapes
from toolkit.reduced_model.cut.part import Part, Sums, chord_of_part, part_nodes, symmetric
from toolkit.reduced_model.model import Invariants, Mesh
from toolkit.reduced_model.parts import Elements


class PlanarPart(Part):
    """Part of a planar chain, whose nodes have two displacements and a rotation."""

    per_node: ClassVar[int] = 3
    ends: ClassVar[tuple[int, int]] = (1, 2)

    def axes(self) -> np.ndarray:
        """Unit vectors along and across the chord, as columns."""
        x, y = chord_of_part(self.nodes, self.first, self.last)
        return np.array([[x, -y], [y, x]])

    @staticmethod
    def functions(ends: np.ndarray, ratio: Any) -> tuple[np.ndarray, np.ndarray]:
        """Shape functions of a point of a beam: displacement (2, 6) and rotation (6,)."""
        own = BeamElements.in_plane(ends[None])
        return at_place(own.shape[0], ratio), at_place(own.rotation[0], ratio)

    def picture(self, whole: Any) -> dict[str, Any]:
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
    every = Sums(slice(first, last), nodes, _coordinates(nodes, chord_of_part(nodes, first, last)), PlanarPart.per_node)
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


def _coordinates(nodes: np.ndarray, chord: np.ndarray) -> np.ndarray:
    """Nodal coordinates per elastic coordinate, (3 n_nodes, n_f)."""
    n = 3 * len(nodes)
    found = np.zeros((n, n - 3), chord.dtype)
    found[2, 0] = 1
    found[3 : n - 3, 1 : n - 5] = np.eye(n - 6)
    found[n - 3 : n - 1, n - 5] = chord
    found[n - 1, n - 4] = 1
    return found
