"""Area and volume of straight elements by their corners, for comparison."""

from __future__ import annotations

import numpy as np

SIMPLICES = {
    "triangle": [(0, 1, 2)],
    "quad": [(0, 1, 2), (0, 2, 3)],
    "tetra": [(0, 1, 2, 3)],
    "wedge": [(0, 1, 2, 3), (1, 2, 3, 4), (2, 3, 4, 5)],
    "hexahedron": [(0, 1, 3, 4), (1, 2, 3, 6), (1, 4, 5, 6), (3, 4, 6, 7), (1, 3, 4, 6)],
    "pyramid": [(0, 1, 2, 4), (0, 2, 3, 4)],
}
"""Kind -> simplices of its corners."""


def size(nodes: np.ndarray, blocks: dict[str, np.ndarray]) -> float:
    """Area or volume of all elements."""
    total = 0.0
    for kind, block in blocks.items():
        for corners in SIMPLICES[kind.rstrip("0123456789")]:
            places = nodes[block[:, corners]]
            edges = places[:, 1:] - places[:, :1]
            total += np.abs(np.linalg.det(edges)).sum() / (2 if edges.shape[1] == 2 else 6)
    return total
