"""The quadratic wedge of 15 nodes, which scikit-fem lacks: shape functions and mesh.

With the triangle's coordinates L_0 = 1 - x - y, L_1 = x, L_2 = y and the height z from 0 to 1 (Zienkiewicz and Taylor, The Finite Element
Method, vol. 1, serendipity prisms),

    corners below and above         L_i (1 - z) (2 L_i - 1 - 2 z)    and   L_i z (2 L_i - 3 + 2 z)
    middles of their edges          4 L_i L_j (1 - z)                and   4 L_i L_j z
    middles of the upright edges    4 L_i z (1 - z)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import skfem
from skfem.element import ElementH1
from skfem.refdom import RefWedge

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]], float)
"""Corners of the reference wedge, in the order of mesh files and of scikit-fem."""
EDGES = ((0, 1), (1, 2), (0, 2), (3, 4), (4, 5), (3, 5), (0, 3), (1, 4), (2, 5))
"""Corners of every edge, in the order of the nodes in their middles, which is the same in mesh files and in scikit-fem."""
SLOPES = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
"""Derivatives of L_0, L_1, L_2 by x and y."""


class ElementWedge15(ElementH1):
    """Serendipity element with a node at every corner and in the middle of every edge."""

    nodal_dofs = 1
    edge_dofs = 1
    maxdeg = 4
    dofnames = ("u", "u")
    doflocs = np.vstack([CORNERS, [CORNERS[list(edge)].mean(axis=0) for edge in EDGES]])
    refdom = RefWedge

    def lbasis(self, X: np.ndarray, i: int) -> tuple[np.ndarray, np.ndarray]:
        """Shape function i and its gradient at the points X (3, ...)."""
        parts, z = np.stack([1 - X[0] - X[1], X[0], X[1]]), X[2]
        if i < 6:
            return _at_corner(parts[i % 3], z, SLOPES[:, i % 3], i >= 3)
        first, last = EDGES[i - 6]
        if last == first + 3:
            part, bump = parts[first], 4 * z * (1 - z)
            return part * bump, np.stack([*(slope * bump for slope in SLOPES[:, first]), part * (4 - 8 * z)])
        height, rate = (z, 1.0) if first >= 3 else (1 - z, -1.0)
        (one, other), slopes = parts[[first % 3, last % 3]], SLOPES[:, [first % 3, last % 3]]
        return 4 * one * other * height, np.stack(
            [*(4 * (a * other + one * b) * height for a, b in slopes), 4 * one * other * rate]
        )


def _at_corner(part: np.ndarray, z: np.ndarray, slopes: np.ndarray, above: bool) -> tuple[np.ndarray, np.ndarray]:
    """Shape function of a corner and its gradient, where L_i is `part`; above it is that below seen from the other end."""
    height, rate = (z, 1.0) if above else (1 - z, -1.0)
    value = part * height * (2 * part - 3 + 2 * height)
    along = height * (4 * part - 3 + 2 * height)
    return value, np.stack([*(slope * along for slope in slopes), rate * part * (2 * part - 3 + 4 * height)])


@dataclass(repr=False)
class MeshWedge15(skfem.MeshWedge1):
    """Mesh of wedges with curved edges and faces: their map is that of the 15 nodes."""

    elem: type = ElementWedge15
