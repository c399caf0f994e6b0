"""Element types of Ansys Mechanical APDL, and what a solid becomes whose corners fall together."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.meshes.wrong_file import wrong_file

SOLIDS = {**dict.fromkeys((45, 64, 65, 185), 8), **dict.fromkeys((95, 186), 20), **dict.fromkeys((92, 187), 10), 285: 4}
"""Type of structural solid -> its number of nodes."""
PLANES = {**dict.fromkeys((42, 182), 4), **dict.fromkeys((82, 183), 8), 2: 6}
"""Type of structural element of the plane -> its number of nodes."""
USED = SOLIDS | PLANES
NAMES = {
    3: "BEAM3", 4: "BEAM4", 8: "LINK8", 10: "LINK10", 14: "COMBIN14", 21: "MASS21", 39: "COMBIN39", 40: "COMBIN40", 43: "SHELL43",
    63: "SHELL63", 93: "SHELL93", 152: "SURF152", 153: "SURF153", 154: "SURF154", 156: "SURF156", 169: "TARGE169", 170: "TARGE170",
    173: "CONTA173", 174: "CONTA174", 175: "CONTA175", 176: "CONTA176", 177: "CONTA177", 180: "LINK180", 181: "SHELL181",
    184: "MPC184", 188: "BEAM188", 189: "BEAM189", 190: "SOLSH190", 200: "MESH200", 214: "COMBI214", 250: "COMBI250", 281: "SHELL281",
}  # fmt: skip
"""Types that are often beside solids; others are called by their number."""
LINEAR = {"hexahedron": list(range(8)), "wedge": [0, 1, 2, 4, 5, 6], "tetra": [0, 1, 2, 4], "pyramid": [0, 1, 2, 3, 4]}
QUADRATIC = {
    "hexahedron20": list(range(20)),
    "wedge15": [0, 1, 2, 4, 5, 6, 8, 9, 11, 12, 13, 15, 16, 17, 18],
    "tetra10": [0, 1, 2, 4, 8, 9, 11, 16, 17, 18],
    "pyramid13": [0, 1, 2, 3, 4, 8, 9, 10, 11, 16, 17, 18, 19],
}
"""Kind -> those of the nodes of a brick that it keeps, where others fall on them."""
REMEDY = "Write it again with CDWRITE,DB from Ansys."


def element_name(number: int) -> str:
    """Name of an element type, for example SHELL181."""
    return NAMES.get(number, f"type {number}")


class Shape(NamedTuple):
    """Elements of one kind among those of a type."""

    kind: str
    own: np.ndarray  # (n_e,) rows of the table
    columns: list[int]  # places of their nodes in a row


def shapes(path: Path, number: int, nodes: np.ndarray) -> list[Shape]:
    """The kinds of elements of one type; `nodes` (n_e, n) holds labels, 0 for nodes that are not given.

    Raises
    ------
    InputError
        Some of the nodes between corners are missing, or corners fall together in a way that gives no element.
    """
    most = USED[number]
    corners = {20: 8, 10: 4, 6: 3}.get(most, 4 if number in PLANES else most)
    given = np.count_nonzero(nodes, axis=1)
    rows = {n: np.flatnonzero(given == n) for n in np.unique(given).tolist()}
    if any(not np.all(nodes[own, :n]) or not _possible(number, n, corners) for n, own in rows.items()):
        raise wrong_file(
            path, f"an element of {element_name(number)} lacks some of its nodes", "Mesh the body with all middle nodes, or none."
        )
    found = [each for n, own in rows.items() for each in _of_one_size(path, nodes, own, n, number in PLANES)]
    return [each for each in found if len(each.own)]


def _possible(number: int, n: int, corners: int) -> bool:
    """Whether an element of a type may have so many nodes: all of them, its corners, or six as a triangle of the plane."""
    return n in (USED[number], corners) or (n == 6 and number in (82, 183))


def _of_one_size(path: Path, nodes: np.ndarray, own: np.ndarray, n: int, plane: bool) -> list[Shape]:
    """Kinds of elements of n nodes."""
    whole = {(4, False): "tetra", (10, False): "tetra10", (3, True): "triangle", (6, True): "triangle6"}.get((n, plane))
    found = [Shape(whole, own, list(range(n)))] if whole else (_plane if plane else _bricks)(path, nodes, own, n)
    for each in found:
        rising = np.sort(nodes[each.own][:, each.columns], axis=1)
        if np.any(rising[:, 1:] == rising[:, :-1]):
            raise wrong_file(path, f"a {each.kind} has a node twice", REMEDY)
    return found


def _plane(_path: Path, nodes: np.ndarray, own: np.ndarray, n: int) -> list[Shape]:
    """Quadrilaterals of the plane, and triangles where K = L in the letters of Ansys."""
    flat = nodes[own, 2] == nodes[own, 3]
    if n == 4:
        return [Shape("quad", own[~flat], [0, 1, 2, 3]), Shape("triangle", own[flat], [0, 1, 2])]
    return [Shape("quad8", own[~flat], list(range(8))), Shape("triangle6", own[flat], [0, 1, 2, 4, 5, 7])]


def _bricks(path: Path, nodes: np.ndarray, own: np.ndarray, n: int) -> list[Shape]:
    """Bricks, wedges (K = L, O = P), tetrahedra (K = L, M = N = O = P) and pyramids (M = N = O = P)."""
    low = nodes[own, 2] == nodes[own, 3]
    high = nodes[own, 6] == nodes[own, 7]
    top = high & (nodes[own, 4] == nodes[own, 5]) & (nodes[own, 4] == nodes[own, 6])
    which = [~low & ~high, low & high & ~top, low & top, ~low & top]
    if not np.all(np.sum(which, axis=0) == 1):
        raise wrong_file(path, "corners of a brick fall together in a way that gives no wedge, tetrahedron or pyramid", REMEDY)
    kinds = LINEAR if n == 8 else QUADRATIC
    return [Shape(kind, own[here], columns) for here, (kind, columns) in zip(which, kinds.items(), strict=True)]
