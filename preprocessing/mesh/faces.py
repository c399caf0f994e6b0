"""The surface of a mesh: edges of plane meshes, faces of spatial ones, and elements cut into triangles or tetrahedra."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import skfem
from scipy import sparse
from skfem.quadrature import get_quadrature

from toolkit.foundation.errors import InputError

CORNERS = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 4}


@dataclass(frozen=True, eq=False)
class BoundaryLines:
    """Edges of the boundary, line by line; the body is to the left of every edge where its elements count anticlockwise."""

    nodes: np.ndarray  # (n_nodes, 2) of the whole mesh
    edges: np.ndarray  # (n_edges, 3) first, last and middle node; -1 for none in the middle

    @property
    def tangents(self) -> np.ndarray:
        """Unit vectors along the chords, (n_edges, 2)."""
        chords = self.nodes[self.edges[:, 1]] - self.nodes[self.edges[:, 0]]
        return chords / np.linalg.norm(chords, axis=1, keepdims=True)

    @property
    def points(self) -> np.ndarray:
        """Numbers of the nodes of the boundary, in order."""
        return np.unique(self.edges[self.edges >= 0])

    def between(self, nodes: np.ndarray) -> BoundaryLines:
        """Edges all of whose nodes are among the given ones."""
        inside = np.append(np.isin(np.arange(len(self.nodes)), nodes), True)  # the last one stands for no node in the middle
        return BoundaryLines(self.nodes, self.edges[inside[self.edges].all(axis=1)])

    def products(self) -> sparse.sparray:
        """Integrals int N_k N_l ds for nodes k and l, by Simpson's rule or half of a straight edge; (n_nodes, n_nodes)."""
        length = np.sqrt(((self.nodes[self.edges[:, 1]] - self.nodes[self.edges[:, 0]]) ** 2).sum(axis=1))
        straight = self.edges[:, 2] < 0
        ends, middle = np.where(straight, 1 / 2, 1 / 6) * length, np.where(straight, 0, 4 / 6) * length
        found = np.zeros(len(self.nodes) + 1, self.nodes.dtype)  # the last one stands for no node
        np.add.at(found, self.edges, np.column_stack([ends, ends, middle]))
        return sparse.diags_array(found[:-1], format="csr")


def outline_of(nodes: np.ndarray, blocks: Mapping[str, np.ndarray]) -> BoundaryLines:
    """Edges that belong to one element only.

    Parameters
    ----------
    blocks : kind of element -> (n_e, nodes of one element), corners first, then the middles of the edges
    """
    every = np.concatenate([edges_of(kind, block) for kind, block in blocks.items()])
    key = np.sort(every[:, :2], axis=1)
    _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    return BoundaryLines(nodes, _in_lines(every[np.sort(first[count == 1])]))


def edges_of(kind: str, block: np.ndarray) -> np.ndarray:
    """Edges of all elements, (n_e n_corners, 3)."""
    corners = CORNERS[kind]
    first = block[:, :corners]
    last = np.roll(first, -1, axis=1)
    middle = block[:, corners : 2 * corners] if block.shape[1] >= 2 * corners else np.full_like(first, -1)
    return np.stack([first, last, middle], axis=2).reshape(-1, 3)


def _in_lines(edges: np.ndarray) -> np.ndarray:
    """The edges in the order in which they follow one another, the smallest number of a node first in every line."""
    at: dict[int, list[int]] = {}
    for k, (first, last, _) in enumerate(edges.tolist()):
        at.setdefault(first, []).append(k)
        at.setdefault(last, []).append(k)
    left, found = np.ones(len(edges), bool), []
    for start in np.argsort(edges[:, :2].min(axis=1), kind="stable").tolist():
        k = start
        while left[k]:
            left[k] = False
            found.append(k)
            ends = edges[k, [1, 0]].tolist()  # onward from the last node, if anything is left there
            k = next((other for end in ends for other in at[end] if left[other]), k)
    return edges[found]


TETRA_EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
HEXAHEDRON_EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
WEDGE_EDGES = ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5))
"""Corners of every edge, in the order of the nodes in their middles."""
TETRA = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
HEXAHEDRON = ((0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (2, 3, 7, 6), (0, 3, 2, 1), (4, 5, 6, 7))
WEDGE = ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))
"""Corners of every face, anticlockwise seen from outside, in the order of the nodes in their middles."""

FACE_SHAPES: dict[str, skfem.Element] = {
    "triangle": skfem.ElementTriP1(), "triangle6": skfem.ElementTriP2(), "quad": skfem.ElementQuad1(), "quad8": skfem.ElementQuadS2(),
    "quad9": skfem.ElementQuad2(),
}  # fmt: skip
FACE_ORDER = 6
"""Of the points that integrate exactly: shape functions times normals, 4 for curved triangles and 5 for quadrilaterals; products of two
on straight ones, 4 and 5."""
TRIANGLES = {
    "triangle": [[0, 1, 2]],
    "triangle6": [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
    "quad": [[0, 1, 2], [0, 2, 3]],
    "quad8": [[0, 4, 7], [1, 5, 4], [2, 6, 5], [3, 7, 6], [4, 5, 6], [4, 6, 7]],
    "quad9": [[a, b, 8] for a, b in ((0, 4), (4, 1), (1, 5), (5, 2), (2, 6), (6, 3), (3, 7), (7, 0))],
}
"""Triangles that every face is drawn with."""
TURNED = {
    "triangle": [0, 2, 1], "triangle6": [0, 2, 1, 5, 4, 3], "quad": [0, 3, 2, 1], "quad8": [0, 3, 2, 1, 7, 6, 5, 4],
    "quad9": [0, 3, 2, 1, 7, 6, 5, 4, 8],
}  # fmt: skip
"""The nodes of every face, seen from its other side."""


@dataclass(frozen=True, eq=False)
class BoundaryFaces:
    """Faces that belong to one element only, by kind; their nodes count anticlockwise seen from outside."""

    nodes: np.ndarray  # (n_nodes, 3) of the whole mesh, real or complex
    faces: Mapping[str, np.ndarray]  # kind -> (n_faces, n_local), corners first, then the middles of the edges

    @property
    def points(self) -> np.ndarray:
        """Numbers of the nodes of the surface, in order."""
        return np.unique(np.concatenate([members.ravel() for members in self.faces.values()]))

    @property
    def triangles(self) -> np.ndarray:
        """Triangles to draw, (n_triangles, 3), as places in `points`."""
        every = [members[:, TRIANGLES[kind]].reshape(-1, 3) for kind, members in self.faces.items()]
        return np.searchsorted(self.points, np.concatenate(every))

    def between(self, nodes: np.ndarray) -> BoundaryFaces:
        """Faces all of whose nodes are among the given ones."""
        return BoundaryFaces(self.nodes, {kind: each[np.isin(each, nodes).all(axis=1)] for kind, each in self.faces.items()})

    def named(self, corners: frozenset) -> BoundaryFaces:
        """Faces with the given corners, in rising order."""
        found = {}
        for kind, each in self.faces.items():
            found[kind] = each[[tuple(key) in corners for key in _corners(each, kind).tolist()]]
        return BoundaryFaces(self.nodes, found)

    def products(self) -> sparse.csr_array:
        """Integrals int N_k N_l dA for all nodes k and l of the mesh, (n_nodes, n_nodes)."""
        found = sparse.csr_array((len(self.nodes), len(self.nodes)), dtype=self.nodes.dtype)
        for kind, members in self.faces.items():
            values, normals = _on_faces(kind, self.nodes[members])
            each = np.einsum("kq,lq,eq->ekl", values, values, np.sqrt((normals**2).sum(axis=2)))
            row, column = (np.broadcast_to(axis, each.shape).ravel() for axis in (members[:, :, None], members[:, None, :]))
            found = found + sparse.coo_array((each.ravel(), (row, column)), shape=found.shape).tocsr()
        return found

    def normals(self) -> np.ndarray:
        """Integrals int N_k n dA with the outer normal n for every node k of the mesh, (n_nodes, 3)."""
        found = np.zeros_like(self.nodes)
        for kind, members in self.faces.items():
            values, normals = _on_faces(kind, self.nodes[members])
            np.add.at(found, members, np.einsum("kq,eqa->eka", values, normals))
        return found


def _on_faces(kind: str, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Shape functions (n_local, n_points) and n dA (n_faces, n_points, 3) with the points' weights, of faces (n_faces, n_local, 3)."""
    shapes = FACE_SHAPES[kind]
    points, weights = get_quadrature(shapes.refdom, FACE_ORDER)
    values, slopes = zip(*(shapes.lbasis(points, k) for k in range(places.shape[1])), strict=True)
    along = np.einsum("kdq,eka->deqa", np.stack([np.broadcast_to(slope, points.shape) for slope in slopes]), places)
    return np.stack(values), np.cross(along[0], along[1]) * weights[:, None]


def faces_of(nodes: np.ndarray, blocks: Mapping[str, np.ndarray]) -> BoundaryFaces:
    """Faces that belong to one element only.

    Parameters
    ----------
    blocks : kind of element -> (n_e, nodes of one element), in the order of mesh files

    Raises
    ------
    InputError
        Elements with and without nodes in the middle of their edges meet.
    """
    every: dict[str, list[np.ndarray]] = {}
    for kind, block in blocks.items():
        mirrored = mirrored_elements(nodes[block])
        for face, places in element_faces(kind):
            members = block[:, places]
            members[mirrored] = members[mirrored][:, TURNED[face]]
            every.setdefault(face, []).append(members)
    found = {kind: _single(np.concatenate(faces), kind) for kind, faces in every.items()}
    for corners in (3, 4):
        _refuse_unlike([_corners(faces, kind) for kind, faces in found.items() if CORNERS[kind] == corners])
    return BoundaryFaces(nodes, found)


def _corners(faces: np.ndarray, kind: str) -> np.ndarray:
    """Corners of the faces, in rising order."""
    return np.sort(faces[:, : CORNERS[kind]], axis=1)


def _single(faces: np.ndarray, kind: str) -> np.ndarray:
    _, first, count = np.unique(_corners(faces, kind), axis=0, return_index=True, return_counts=True)
    return faces[np.sort(first[count == 1])]


def _refuse_unlike(keys: list[np.ndarray]) -> None:
    """Refuse faces of different kinds with the same corners: the elements there would part."""
    if not keys:
        return
    place, count = np.unique(np.concatenate(keys), axis=0, return_counts=True)
    if np.any(count > 1):
        raise InputError(
            f"{np.count_nonzero(count > 1)} faces have nodes in the middle of their edges for one of their two elements only, the first "
            f"with the corners {', '.join(map(str, place[np.argmax(count > 1)]))}. Mesh the whole body with elements of one order."
        )


def mirrored_elements(places: np.ndarray) -> np.ndarray:
    """Which elements, (n_e, n_local, 3), have their corners in the order of a mirror image."""
    third = {4: 3, 6: 3, 10: 3, 15: 3}.get(places.shape[1], 4)  # the corner above the first one
    second = 2 if third == 3 else 3
    return np.linalg.det(places[:, [1, second, third]] - places[:, [0]]) < 0


def element_faces(kind: str) -> list[tuple[str, list[int]]]:
    """Kind and local nodes of all faces of an element."""
    corners, edges, first = {
        "tetra": (TETRA, (), 4), "tetra10": (TETRA, TETRA_EDGES, 4), "hexahedron": (HEXAHEDRON, (), 8),
        "hexahedron20": (HEXAHEDRON, HEXAHEDRON_EDGES, 8), "hexahedron27": (HEXAHEDRON, HEXAHEDRON_EDGES, 8), "wedge": (WEDGE, (), 6),
        "wedge15": (WEDGE, WEDGE_EDGES, 6),
    }[kind]  # fmt: skip
    middle = {frozenset(edge): first + k for k, edge in enumerate(edges)}
    found = []
    for k, face in enumerate(corners):
        around = [middle[frozenset(pair)] for pair in zip(face, face[1:] + face[:1], strict=True) if middle]
        centre = [first + len(edges) + k] if kind == "hexahedron27" else []
        members = [*face, *around, *centre]
        found.append(({3: "triangle", 6: "triangle6", 4: "quad", 8: "quad8", 9: "quad9"}[len(members)], members))
    return found


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


class ElementSides(NamedTuple):
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


def cut(nodes: np.ndarray, blocks: Mapping[str, np.ndarray]) -> tuple[ElementSides, Simplices]:
    """Sides and simplices of all elements, block by block; nodes (n_nodes, d)."""
    sides, simplices, elements, n_sides = [], [], 0, 0
    for kind, block in blocks.items():
        centre, mirrored = _centres(kind, nodes[block]), _mirrored(nodes[block])
        for corners, outer in _sides(nodes, kind, block):
            numbers = elements + np.arange(len(block))
            sides.append(ElementSides(numbers, _key(corners), _turn(corners) * np.where(mirrored, -1, 1), 0))
            apexes = np.broadcast_to(centre[:, None, None], (*outer.shape[:2], 1, nodes.shape[1]))
            each = np.concatenate([apexes, outer], axis=2)
            own = [np.repeat(first + np.arange(len(block)), outer.shape[1]) for first in (elements, n_sides)]
            simplices.append(Simplices(own[0], own[1], each.reshape(-1, *each.shape[2:])))
            n_sides += len(block)
        elements += len(block)
    element, key, turn = (np.concatenate(parts) for parts in list(zip(*sides, strict=True))[:3])
    return ElementSides(element, key, turn, elements), Simplices(
        *(np.concatenate(parts) for parts in zip(*simplices, strict=True))
    )


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
