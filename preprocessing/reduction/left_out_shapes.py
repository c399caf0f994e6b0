"""What unit loads on a body of beams do in the shapes that its basis leaves out."""

from __future__ import annotations

from typing import Any

import numpy as np

from preprocessing.assembly.assembly import Matrices
from preprocessing.basis.basis import Basis
from preprocessing.basis.reduction import per_node
from preprocessing.discretisation.discretisation import Discretisation
from toolkit.reduced_model.parts.left_out_shapes import LeftOutShapes


def left_out_shapes(nominal: Discretisation, matrices: Matrices, mass: Any, basis: Basis) -> LeftOutShapes | None:
    """Of a body at its nominal design, with the mass (n, n) of its nodal coordinates; None where nothing is left out."""
    if basis.beyond is None or not basis.beyond.count:
        return None
    rows = nominal.interface_rows()
    loads = np.column_stack(
        [*(rows[name].T for name in sorted(rows)), mass @ np.column_stack([pulls(nominal.nodes), basis.z[:, 1:]])]
    )
    shapes = basis.beyond.columns / np.sqrt(basis.beyond.eigenvalues)
    seen = shapes.T @ loads
    return LeftOutShapes(seen.T @ seen, matrices.stress @ matrices.coordinates.displacement(shapes @ seen))


def pulls(nodes: np.ndarray) -> np.ndarray:
    """Accelerations (n, d + d d) of nodes (n_nodes, d): along each axis a, and along a as the place along b, turning with their field."""
    count, d = nodes.shape
    found = np.zeros((count, per_node(nodes), d + d * d))
    for a in range(d):
        found[:, a, a] = 1.0
        for b in range(d):
            found[:, a, d + d * a + b] = nodes[:, b]
            if a != b and d == 2:
                found[:, 2, d + d * a + b] = (a - b) / 2
            elif a != b:
                found[:, 3 + 3 - a - b, d + d * a + b] = (1 if (a - b) % 3 == 1 else -1) / 2
    return found.reshape(-1, d + d * d)
