"""Numbers that gmsh gives its kinds of elements, and the order in which it numbers their nodes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class GmshKind(NamedTuple):
    """Kind of element of gmsh."""

    kind: str  # in the words of meshio
    nodes: int
    dimension: int


KINDS = {
    15: GmshKind("vertex", 1, 0),
    1: GmshKind("line", 2, 1),
    8: GmshKind("line3", 3, 1),
    26: GmshKind("line4", 4, 1),
    27: GmshKind("line5", 5, 1),
    28: GmshKind("line6", 6, 1),
    2: GmshKind("triangle", 3, 2),
    9: GmshKind("triangle6", 6, 2),
    20: GmshKind("triangle9", 9, 2),
    21: GmshKind("triangle10", 10, 2),
    22: GmshKind("triangle12", 12, 2),
    23: GmshKind("triangle15", 15, 2),
    24: GmshKind("triangle15", 15, 2),
    25: GmshKind("triangle21", 21, 2),
    3: GmshKind("quad", 4, 2),
    10: GmshKind("quad9", 9, 2),
    16: GmshKind("quad8", 8, 2),
    36: GmshKind("quad16", 16, 2),
    37: GmshKind("quad25", 25, 2),
    38: GmshKind("quad36", 36, 2),
    39: GmshKind("quad12", 12, 2),
    40: GmshKind("quad16", 16, 2),
    41: GmshKind("quad20", 20, 2),
    4: GmshKind("tetra", 4, 3),
    11: GmshKind("tetra10", 10, 3),
    29: GmshKind("tetra20", 20, 3),
    30: GmshKind("tetra35", 35, 3),
    31: GmshKind("tetra56", 56, 3),
    5: GmshKind("hexahedron", 8, 3),
    12: GmshKind("hexahedron27", 27, 3),
    17: GmshKind("hexahedron20", 20, 3),
    92: GmshKind("hexahedron64", 64, 3),
    93: GmshKind("hexahedron125", 125, 3),
    6: GmshKind("wedge", 6, 3),
    13: GmshKind("wedge18", 18, 3),
    18: GmshKind("wedge15", 15, 3),
    90: GmshKind("wedge40", 40, 3),
    91: GmshKind("wedge75", 75, 3),
    7: GmshKind("pyramid", 5, 3),
    14: GmshKind("pyramid14", 14, 3),
    19: GmshKind("pyramid13", 13, 3),
    118: GmshKind("pyramid30", 30, 3),
    119: GmshKind("pyramid55", 55, 3),
}
"""Number in gmsh -> the kind; those of third order and above are known in order to be refused by name."""

ORDERS = {
    "tetra10": [0, 1, 2, 3, 4, 5, 6, 7, 9, 8],
    "hexahedron20": [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15],
    "hexahedron27": [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26],
    "wedge15": [0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11],
}
"""Kind -> place in gmsh of every node of the order that is used here, where the two differ."""

DIMENSIONS = ("point", "curve", "surface", "volume")
"""Words of gmsh for entities of dimension 0 to 3."""


def reordered(kind: str, nodes: np.ndarray) -> np.ndarray:
    """Nodes (n_e, n_local) of elements of gmsh in the order that is used here."""
    return nodes[:, ORDERS[kind]] if kind in ORDERS else nodes
