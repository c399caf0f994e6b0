"""The elements of a mesh cut into triangles or tetrahedra, from their centre to their sides: neighbours fit wherever their nodes do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from preprocessing.mesh.faces import element_faces, mirrored_elements
from preprocessing.mesh.outline import CORNERS, edges_of

CENTRE = {
    "triangle": (1 / 3, 0), "triangle6": (-1 / 9, 4 / 9), "quad": (1 / 4, 0), "quad8": (-1 / 4, 1 / 2), "tetra": (1 / 4, 0),
    "tetra10": (-1 / 8, 1 / 4), "hexahedron": (1 / 8, 0), "hexahedron20": (-1 / 4, 1 / 4), "wedge": (1 / 6, 0),
    "wedge15": (-2 / 9, [2 / 9] * 6 + [1 / 3] * 3),
}  # fmt: skip
"""Shape functions of corners and of middles of edges in the centre of an element; quad9 and hexahedron27 have a node there, their last."""
ALL_CORNERS = {
    **CORNERS,
    "tetra": 4,
    "tetra10": 4,
    "hexahedron": 8,
    "hexahedron20": 8,
    "hexahedron27": 8,
    "wedge": 6,
    "wedge15": 6,
}


class Sides(NamedTuple):
    """Sides of elements, edges in the plane and faces in space, in the order of the elements."""

    element: np.ndarray  # (n,) number of the element
    key: np.ndarray  # (n, 4) corners in rising order, filled up with -1
    turn: np.ndarray  # (n,) +1 or -1: which way round the corners follow one another, seen from outside the element
    n_elements: int


class Simplices(NamedTuple):
    """Triangles or tetrahedra whose first corner is the centre of their element, and the others on one of its sides."""

    element: np.ndarray  # (n,)
    side: np.ndarray  # (n,) number of the side
    corners: np.ndarray  # (n, d + 1, d)


def cut(nodes: np.ndarray, blocks: Mapping[str, np.ndarray]) -> tuple[Sides, Simplices]:
    """Sides and simplices of all elements, block by block; nodes (n_nodes, d)."""
    sides, simplices, elements, n_sides = [], [], 0, 0
    for kind, block in blocks.items():
        centre, mirrored = _centres(kind, nodes[block]), _mirrored(nodes[block])
        for corners, outer in _sides(nodes, kind, block):
            numbers = elements + np.arange(len(block))
            sides.append(Sides(numbers, _key(corners), _turn(corners) * np.where(mirrored, -1, 1), 0))
            apexes = np.broadcast_to(centre[:, None, None], (*outer.shape[:2], 1, nodes.shape[1]))
            each = np.concatenate([apexes, outer], axis=2)
            own = [np.repeat(first + np.arange(len(block)), outer.shape[1]) for first in (elements, n_sides)]
            simplices.append(Simplices(own[0], own[1], each.reshape(-1, *each.shape[2:])))
            n_sides += len(block)
        elements += len(block)
    element, key, turn = (np.concatenate(parts) for parts in list(zip(*sides, strict=True))[:3])
    return Sides(element, key, turn, elements), Simplices(*(np.concatenate(parts) for parts in zip(*simplices, strict=True)))


def _sides(nodes: np.ndarray, kind: str, block: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Corners (n_e, 2 to 4) of every side, and the simplices' corners on it (n_e, n_simplices, d, d)."""
    if nodes.shape[1] == 2:
        for each in np.moveaxis(edges_of(kind, block).reshape(len(block), -1, 3), 1, 0):
            line = each[:, [0, 1]] if each[0, 2] < 0 else each[:, [0, 2, 1]]
            yield each[:, :2], np.stack([nodes[line[:, :-1]], nodes[line[:, 1:]]], axis=2)
        return
    for face, places in element_faces(kind):
        members, n = block[:, places], CORNERS[face]
        around = np.stack([members[:, :n], members[:, n : 2 * n]], axis=2).reshape(len(block), -1) if len(places) > n else members
        polygon = nodes[around]
        middle = np.broadcast_to(_centres(face, nodes[members])[:, None], polygon.shape)
        yield members[:, :n], np.stack([middle, polygon, np.roll(polygon, -1, axis=1)], axis=2)


def _centres(kind: str, places: np.ndarray) -> np.ndarray:
    """Images (n_e, d) of the centres of elements or faces, from the places of their nodes (n_e, n_local, d)."""
    if kind in ("quad9", "hexahedron27"):
        return places[:, -1]
    corner, middle = CENTRE[kind]
    n = ALL_CORNERS[kind]
    weights = np.full(places.shape[1], corner)
    weights[n:] = middle
    return np.einsum("k,ekd->ed", weights, places)


def _mirrored(places: np.ndarray) -> np.ndarray:
    """Which elements (n_e, n_local, d) have their corners in the order of a mirror image."""
    if places.shape[2] == 3:
        return mirrored_elements(places)
    along = places[:, 1:3] - places[:, [0]]
    return np.linalg.det(along) < 0


def _key(corners: np.ndarray) -> np.ndarray:
    found = np.full((len(corners), 4), -1)
    found[:, : corners.shape[1]] = np.sort(corners, axis=1)
    return found


def _turn(corners: np.ndarray) -> np.ndarray:
    """Sense of rotation, +1 where the corner after the smallest is smaller than the one before it.

    Of an edge, where it begins with the smaller one.
    """
    if corners.shape[1] == 2:
        return np.where(corners[:, 0] < corners[:, 1], 1, -1)
    first, rows = corners.argmin(axis=1), np.arange(len(corners))
    n = corners.shape[1]
    return np.where(corners[rows, (first + 1) % n] < corners[rows, (first - 1) % n], 1, -1)
