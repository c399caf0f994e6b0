"""The finite elements behind a planar reduced model, one by one: from them the runtime makes parts with floating frames of their own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

LOCAL = 6
"""Coordinates of an element: displacements x, y and the rotation of its first node, then of its second, in the axes of the model."""


@dataclass(frozen=True)
class Elements:
    """The invariants of every element on its own coordinates: those of any set of elements are their sums.

    With Z_e = [xi_e, 1] of an element, xi_e the undeformed places of its nodes, and otherwise as the invariants of the whole body. A model
    has them that keeps all nodal coordinates.
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
