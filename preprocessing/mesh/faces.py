"""The surface of a spatial mesh: its faces, the triangles that they are drawn with, and integrals over them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import skfem
from scipy import sparse
from skfem.quadrature import get_quadrature

from preprocessing.mesh.outline import CORNERS
from toolkit.foundation.errors import InputError

TETRA_EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
HEXAHEDRON_EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
WEDGE_EDGES = ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5))
"""Corners of every edge, in the order of the nodes in their middles."""
TETRA = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
HEXAHEDRON = ((0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (2, 3, 7, 6), (0, 3, 2, 1), (4, 5, 6, 7))
WEDGE = ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))
"""Corners of every face, anticlockwise seen from outside, in the order of the nodes in their middles."""

FACE_SHAPES: dict[str, Any] = {
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

    def products(self) -> Any:
        """Integrals int N_k N_l dA for all nodes k and l of the mesh, sparse (n_nodes, n_nodes)."""
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
