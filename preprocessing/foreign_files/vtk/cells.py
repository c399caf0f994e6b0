"""Cells of VTK by their types, and grids whose cells VTK does not list."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from preprocessing.foreign_files.contents import Elements
from preprocessing.foreign_files.meshes.wrong_file import wrong_file
from toolkit.foundation.errors import InputError

REMEDY = "Export it again, with cells such as VTK_TETRA, VTK_HEXAHEDRON or their quadratic kinds."
TYPES = {
    1: ("vertex", 1), 3: ("line", 2), 5: ("triangle", 3), 8: ("quad", 4), 9: ("quad", 4), 10: ("tetra", 4), 11: ("hexahedron", 8),
    12: ("hexahedron", 8), 13: ("wedge", 6), 14: ("pyramid", 5), 21: ("line3", 3), 22: ("triangle6", 6), 23: ("quad8", 8),
    24: ("tetra10", 10), 25: ("hexahedron20", 20), 26: ("wedge15", 15), 27: ("pyramid13", 13), 28: ("quad9", 9),
    29: ("hexahedron27", 27),
}  # fmt: skip
"""Number in VTK -> kind of element, and its number of nodes."""
ORDERS = {8: [0, 1, 3, 2], 11: [0, 1, 3, 2, 4, 5, 7, 6], 13: [0, 2, 1, 3, 5, 4]}
"""Number in VTK -> place there of every node, where it counts them otherwise: pixels, voxels, and wedges, whose base looks outward."""
EMPTY = 0
"""Number of a cell without nodes, which is none."""
OTHERS = {
    2: "VTK_POLY_VERTEX", 4: "VTK_POLY_LINE", 6: "VTK_TRIANGLE_STRIP", 7: "VTK_POLYGON", 15: "VTK_PENTAGONAL_PRISM",
    16: "VTK_HEXAGONAL_PRISM", 30: "VTK_QUADRATIC_LINEAR_QUAD", 31: "VTK_QUADRATIC_LINEAR_WEDGE", 32: "VTK_BIQUADRATIC_QUADRATIC_WEDGE",
    33: "VTK_BIQUADRATIC_QUADRATIC_HEXAHEDRON", 34: "VTK_BIQUADRATIC_TRIANGLE", 35: "VTK_CUBIC_LINE", 36: "VTK_QUADRATIC_POLYGON",
    37: "VTK_TRIQUADRATIC_PYRAMID", 41: "VTK_CONVEX_POINT_SET", 42: "VTK_POLYHEDRON", 68: "VTK_LAGRANGE_CURVE",
    69: "VTK_LAGRANGE_TRIANGLE", 70: "VTK_LAGRANGE_QUADRILATERAL", 71: "VTK_LAGRANGE_TETRAHEDRON", 72: "VTK_LAGRANGE_HEXAHEDRON",
    73: "VTK_LAGRANGE_WEDGE", 74: "VTK_LAGRANGE_PYRAMID", 75: "VTK_BEZIER_CURVE", 76: "VTK_BEZIER_TRIANGLE",
    77: "VTK_BEZIER_QUADRILATERAL", 78: "VTK_BEZIER_TETRAHEDRON", 79: "VTK_BEZIER_HEXAHEDRON", 80: "VTK_BEZIER_WEDGE",
    81: "VTK_BEZIER_PYRAMID",
}  # fmt: skip
"""Numbers and names of cells that are refused."""


def cells_by_type(path: Path, types: np.ndarray, ends: np.ndarray, connectivity: np.ndarray) -> Elements:
    """Elements by kind, of cells whose nodes stand one behind the other and end at given places.

    Raises
    ------
    InputError
        A cell is of a type that is not supported, or has another number of nodes than its type.
    """
    starts = np.append(0, ends[:-1])
    if len(types) != len(ends) or np.any(ends < starts) or (len(ends) and ends[-1] != len(connectivity)):
        raise wrong_file(path, "the numbers of its cells, types and nodes contradict each other", REMEDY)
    cells = []
    for number in np.unique(types).tolist():
        own = np.flatnonzero(types == number)
        kind, n = _kind(path, number, len(own))
        if np.any(ends[own] - starts[own] != n):
            raise wrong_file(path, f"a cell of type {number} has not the {n} nodes of its type", REMEDY)
        nodes = connectivity[starts[own, None] + np.arange(n)]
        if number != EMPTY:
            cells.append((kind, (nodes[:, ORDERS[number]] if number in ORDERS else nodes).astype(np.int64)))
    return cells


def _kind(path: Path, number: int, count: int) -> tuple[str, int]:
    """Kind and number of nodes of the cells of a type."""
    if number == EMPTY:
        return "", 0
    if number not in TYPES:
        name = OTHERS.get(number, "a type that VTK does not list")
        raise wrong_file(path, f"{count} of its cells are {name}, which is no element here", REMEDY)
    return TYPES[number]


def grid_cells(path: Path, dimensions: tuple[int, ...]) -> Elements:
    """Quadrilaterals or hexahedra of a grid of so many points along x, y and z, of which x counts fastest."""
    long = [k for k in range(3) if dimensions[k] > 1]
    if len(long) < 2:
        raise wrong_file(path, "its grid is a point or a line", REMEDY)
    strides = np.cumprod([1, *dimensions[:2]])
    first = np.zeros(1, np.int64)
    for k in long:
        first = (first[None, :] + strides[k] * np.arange(dimensions[k] - 1)[:, None]).ravel()
    a, b = strides[long[0]], strides[long[1]]
    base = first[:, None] + np.array([0, a, a + b, b])
    return [("quad", base) if len(long) == 2 else ("hexahedron", np.hstack([base, base + strides[2]]))]


def hidden(path: Path) -> InputError:
    """Error of a mesh with ghosts."""
    return wrong_file(path, "it marks cells as ghosts or hidden (vtkGhostType)", "Export the whole body without ghost cells.")
