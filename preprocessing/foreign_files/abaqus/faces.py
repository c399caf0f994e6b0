"""Faces of elements by their numbers in Abaqus, S1 to S6, with their middle nodes."""

from __future__ import annotations

import re

import numpy as np

TETRA = ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0))
HEXAHEDRON = ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0))
WEDGE = ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0))
CORNERS = {
    "tetra": TETRA, "tetra10": TETRA, "hexahedron": HEXAHEDRON, "hexahedron20": HEXAHEDRON, "wedge": WEDGE, "wedge15": WEDGE,
    "triangle": ((0, 1), (1, 2), (2, 0)), "triangle6": ((0, 1), (1, 2), (2, 0)),
    "quad": ((0, 1), (1, 2), (2, 3), (3, 0)), "quad8": ((0, 1), (1, 2), (2, 3), (3, 0)),
}  # fmt: skip
"""Kind of element -> corners of its faces S1, S2 and so on."""
MIDDLES = {
    "tetra10": ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)),
    "hexahedron20": ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)),
    "wedge15": ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)),
    "triangle6": ((0, 1), (1, 2), (2, 0)),
    "quad8": ((0, 1), (1, 2), (2, 3), (3, 0)),
}
"""Kind of element -> corners of the edges whose middle nodes follow the corners."""
FLAT = {"triangle": 3, "quad": 4, "triangle6": 6, "quad8": 8, "quad9": 9}
NAMES = {2: "line", 3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8"}


SIDE = re.compile(r"([SE])([1-6])")
BOTH_SIDES = ("SPOS", "SNEG")
"""The two sides of a shell or membrane, which have the same nodes."""


def side_of(kind: str, name: str) -> tuple[str, list[int]] | None:
    """Kind of a side by its name in Abaqus, and the places of its nodes among those of the element; None of one that is not read."""
    flat = not kind.startswith(("tetra", "wedge", "hexahedron"))
    if name in BOTH_SIDES and kind in FLAT:
        return kind, [*range(FLAT[kind])]
    found = SIDE.fullmatch(name)
    return face_of(kind, int(found[2]) - 1) if found and (flat or found[1] == "S") else None


def face_of(kind: str, number: int) -> tuple[str, list[int]] | None:
    """Kind of a face, from 0 for S1 on, and the places of its nodes among those of the element; None where there is no such face."""
    if kind not in CORNERS or not 0 <= number < len(CORNERS[kind]):
        return None
    corners = CORNERS[kind][number]
    if kind not in MIDDLES:
        return NAMES[len(corners)], [*corners]
    first = 1 + max(max(edge) for edge in MIDDLES[kind])
    middle = {frozenset(edge): first + k for k, edge in enumerate(MIDDLES[kind])}
    if len(corners) == 2:
        return "line3", [*corners, middle[frozenset(corners)]]
    around = [middle[frozenset(pair)] for pair in zip(corners, corners[1:] + corners[:1], strict=True)]
    return NAMES[2 * len(corners)], [*corners, *around]


def lie_on_solids(kind: str, elements: np.ndarray, solids: list[tuple[str, np.ndarray]]) -> np.ndarray:
    """Which elements of lower dimension (n_e, n_local) are faces, or between nodes, of solids of these kinds and nodes."""
    n_corners = {"line": 2, "line3": 2, "triangle": 3, "triangle6": 3}.get(kind, 4)
    wanted = np.sort(elements[:, :n_corners], axis=1)
    if n_corners == 2:
        ends: np.ndarray = np.isin(wanted, np.concatenate([block.ravel() for _, block in solids]))
        return ends[:, 0] & ends[:, 1]
    marked, found = np.unique(wanted), [np.zeros((0, n_corners), np.int64)]
    for solid, block in solids:
        near = block[np.isin(block, marked).sum(axis=1) >= n_corners]
        found += [np.sort(near[:, list(face)], axis=1) for face in CORNERS[solid] if len(face) == n_corners]
    faces = np.concatenate(found)
    _, number = np.unique(np.concatenate([faces, wanted]), axis=0, return_inverse=True)
    number = number.ravel()
    return np.isin(number[len(faces) :], number[: len(faces)])
