"""The finite elements behind a reduced model, one by one: from them the runtime makes parts with floating frames of their own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

LOCAL = 6
"""Coordinates of an element: displacements x, y and the rotation of its first node, then of its second, in the axes of the model."""
SPATIAL_LOCAL = 12
"""The same in space: displacements along and rotations about x, y and z of its first node, then of its second."""
STILL = 1e-9
"""Part of the largest movement of a node below which it is round-off: clamped nodes of computed shapes move by some."""


@dataclass(frozen=True)
class Elements:
    """Invariants of every element on its own coordinates; those of a set of elements are their sums.

    With Z_e = [xi_e, 1] of an element, xi_e the undeformed places of its nodes, and otherwise as the invariants of the whole body. Models
    of beams have them whatever shapes their basis keeps.
    """

    nodes: np.ndarray  # (n_nodes, 2), undeformed
    connectivity: np.ndarray  # (n_elements, 2), first and second node
    mass: np.ndarray  # (n_elements,)
    first_moment: np.ndarray  # (n_elements, 2, 7)
    inertia: np.ndarray  # G (n_elements, 7, 7), symmetric
    gyroscopic: np.ndarray  # H (n_elements, 7, 7), antisymmetric
    stiffness: np.ndarray  # (n_elements, 6, 6)
    damping: np.ndarray  # (n_elements, 6, 6)
    stress_operator: np.ndarray  # (n_stress, 6), on the coordinates of the element that the stress point is in

    def held_nodes(self, mesh: Any) -> np.ndarray:
        """Numbers of the nodes that the frame of the whole body is tied to: those that no column of the mesh moves but by round-off."""
        if mesh is None:
            return np.zeros(0, int)
        moved: np.ndarray = mesh.recovery[:, 1:].reshape(len(mesh.nodes), -1)
        return np.flatnonzero(np.abs(moved).max(axis=1, initial=0.0) <= STILL * np.abs(moved).max(initial=0.0))

    def shapes(self, mesh: Any) -> np.ndarray | None:
        """Nodal coordinates per elastic coordinate of the whole body, (3 n_nodes, n_f); None if they were not stored."""
        return None if mesh is None else mesh.recovery[:, 1:]


@dataclass(frozen=True)
class SpatialElements:
    """Invariants of every element on its own coordinates, with Q[a, b] in the order of `SpatialInvariants`."""

    nodes: np.ndarray  # (n_nodes, 3), undeformed
    connectivity: np.ndarray  # (n_elements, 2), first and second node
    held: np.ndarray  # (n_held,) nodes that the frame of the whole body is tied to
    mass: np.ndarray  # (n_elements,)
    first_moment: np.ndarray  # (n_elements, 3, 13)
    second_moment: np.ndarray  # (n_elements, 6, 13, 13)
    stiffness: np.ndarray  # (n_elements, 12, 12)
    damping: np.ndarray  # (n_elements, 12, 12)
    stress_operator: np.ndarray  # (n_stress n_components, 12), on the coordinates of the element that the stress point is in

    def held_nodes(self, _mesh: Any) -> np.ndarray:
        """Numbers of the nodes that the frame of the whole body is tied to, as stored in `held`."""
        return self.held

    def shapes(self, _mesh: Any) -> np.ndarray | None:
        """Nodal coordinates per elastic coordinate, (6 n_nodes, n_f): all of nodes that are not held; None if none is held."""
        if not len(self.held):
            return None
        count = len(self.nodes)
        free = np.repeat(~np.isin(np.arange(count), self.held), SPATIAL_LOCAL // 2)
        found: np.ndarray = np.eye(len(free))[:, free]
        return found
