"""Spatial beams at one design: matrices, interface points and what pictures need, for the reduction.

Psi holds nodal coordinates only; the offset of `spatial_beam`, one at rest and never displaced, is added where the matrices are contracted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from preprocessing.assembly.energies import energies
from preprocessing.assembly.interface import interface_point
from preprocessing.assembly.spatial_assembly import PER_NODE, BeamMesh, SpatialPatch, first_rows
from preprocessing.assembly.spatial_invariants import SpatialParts, contract, contract_derivative, polynomials
from preprocessing.elements.section_shape import SectionShape, value_of
from toolkit.reduced_model.dependence import Polynomial
from toolkit.reduced_model.model import InterfacePoint, StressPoints
from toolkit.reduced_model.spatial_model import SpatialInvariants, Surface


@dataclass(frozen=True, eq=False)
class SpatialDiscretisation:
    """Finite elements of spatial beams; complex where a parameter made a complex step.

    Interface points lie at arc lengths along a chain of elements, or at nodes of a frame.
    """

    mesh: BeamMesh
    patches: Sequence[SpatialPatch]
    parts: SpatialParts
    places: Mapping[str, Any]  # interface point -> its arc length
    arc_lengths: np.ndarray | None = None  # (n_nodes,) of a chain
    at_nodes: Mapping[str, int] | None = None  # interface point of a frame -> its node
    target: np.ndarray | None = None  # (n_nodes, 2)

    @property
    def nodes(self) -> np.ndarray:
        """Undeformed positions, (n_nodes, 3)."""
        return self.mesh.nodes

    @property
    def stress_points(self) -> StressPoints:
        """Element by element, fibre by fibre, of each its two ends."""
        fibres = {int(k): each.shape.fibres for each in self.patches for k in each.patch.elements}
        rows = [(k, end, fibre.side) for k in sorted(fibres) for fibre in fibres[k] for end in (0, 1)]
        return StressPoints(*np.array(rows).T)

    def interfaces(self, z: np.ndarray) -> dict[str, InterfacePoint]:
        """The interface points for Z = [xi, Psi] (n, 1 + n_f)."""
        if self.arc_lengths is not None:
            return {name: interface_point(self.mesh, self.arc_lengths, z, place) for name, place in self.places.items()}
        return {name: node_point(z, node) for name, node in (self.at_nodes or {}).items()}

    def interface_rows(self) -> dict[str, np.ndarray]:
        """Interface point -> rows (6, n) that give its displacement and its rotation from the nodal coordinates."""
        every = self.interfaces(np.eye(self.mesh.n))
        return {name: np.vstack([point.position[0], point.rotation[0]]) for name, point in every.items()}

    def items(self, z: np.ndarray) -> dict[str, np.ndarray]:
        """Arrays of the reduced model, besides the invariants, that can depend on the design."""
        keys = ("arc_length", "position", "rotation")
        found = {f"interfaces.{name}.{key}": getattr(point, key) for name, point in self.interfaces(z).items() for key in keys}
        if self.target is not None:
            found |= {"shape.position": positions(z)[:, :2], "shape.target": self.target}
        return found

    def nodal(self, matrix: Any) -> Any:
        """The matrix without the offset."""
        return matrix[: self.mesh.n, : self.mesh.n]

    def contract(self, values: Mapping[str, Any], z: np.ndarray) -> SpatialInvariants:
        """Invariants at values of the parameters for Z = [xi, Psi]."""
        complete = with_offset(z)
        found = contract(self.parts.at(values), complete, self._translations())
        own = {name: energies(self.parts, values, name, complete[:, 1:]) for name in ("stiffness", "damping")}
        return replace(found, **own)

    def contract_derivative(self, matrices: Any, d_matrices: Any, z: np.ndarray, d_z: np.ndarray) -> SpatialInvariants:
        """Their derivative from those of the matrices and of Z."""
        d_complete = np.vstack([d_z, np.zeros(d_z.shape[1])])
        return contract_derivative(matrices, d_matrices, with_offset(z), self._translations(), d_complete)

    def polynomials(self, parameters: Sequence[str], z: np.ndarray, computed: bool) -> dict[str, Polynomial]:
        """Their exact dependence on the parameters for a constant Z."""
        return polynomials(self.parts, parameters, with_offset(z), self._translations(), computed)

    def surface(self, z: np.ndarray, values: Mapping[str, Any]) -> Surface:
        """Every fibre whose stress is told as a line, at the dimensions `values` of the sections."""
        position = np.zeros((int(first_rows(self.mesh, self.patches)[-1]), 3, z.shape[1]))
        first, triad = first_rows(self.mesh, self.patches), self.mesh.axes
        for each in self.patches:
            dimensions = {quantity: values[name] for quantity, name in each.patch.parameters.items()}
            for element in each.patch.elements:
                offsets = _offsets(each.shape, dimensions) @ triad[element, 1:]
                for number, (k, node) in enumerate(
                    (k, node) for k in range(len(offsets)) for node in self.mesh.connectivity[element]
                ):
                    position[first[element] + number] = _moved(z, node, offsets[k])
        return Surface(position, np.zeros((0, 3), int), np.arange(len(position)).reshape(-1, 2))

    def _translations(self) -> np.ndarray:
        found = np.zeros((self.mesh.n + 1, 3))
        for axis in range(3):
            found[axis : self.mesh.n : PER_NODE, axis] = 1
        return found


def node_point(z: np.ndarray, node: int) -> InterfacePoint:
    """A node of a frame, which lies on no curve: its arc length is 0 and cannot change."""
    rows = z[PER_NODE * node : PER_NODE * (node + 1)]
    return InterfacePoint(np.zeros(()), np.zeros(2), rows[None, :3], rows[None, 3:])


def with_offset(z: np.ndarray) -> np.ndarray:
    """Z (n, 1 + n_f) with the row of the offset, which is one at rest: (n + 1, 1 + n_f)."""
    return np.vstack([z, np.eye(1, z.shape[1], dtype=z.dtype)])


def positions(z: np.ndarray) -> np.ndarray:
    """The rows of Z that give the nodes' positions, (n_nodes, 3, 1 + n_f)."""
    return z.reshape(-1, PER_NODE, z.shape[1])[:, :3]


def _offsets(shape: SectionShape, dimensions: Mapping[str, Any]) -> np.ndarray:
    """y_2, y_3 of every fibre, (n_fibres, 2)."""
    return np.array([[value_of(fibre.second, dimensions), value_of(fibre.third, dimensions)] for fibre in shape.fibres])


def _moved(z: np.ndarray, node: int, offset: np.ndarray) -> np.ndarray:
    """Place (3, 1 + n_f) of a point beside a node, at the offset (3,) when undeformed."""
    rows = z[PER_NODE * node : PER_NODE * (node + 1)]
    place = rows[:3] + np.cross(rows[3:], offset[:, None], axis=0)
    place[:, 0] += offset
    return place
