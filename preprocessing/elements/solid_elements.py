"""The elements of a mesh with the shape functions of scikit-fem, numbered as the nodes of the mesh are."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np
import skfem
from scipy import sparse
from skfem.quadrature import get_quadrature
from skfem.refdom import RefLine, RefTri, RefWedge

from preprocessing.elements.wedge15 import ElementWedge15, MeshWedge15
from preprocessing.mesh.faces import HEXAHEDRON_EDGES
from preprocessing.mesh.solid_mesh import SolidMesh
from toolkit.foundation.errors import InputError

KINDS: dict[str, tuple[type[skfem.Mesh], type[skfem.Element], int]] = {
    "triangle": (skfem.MeshTri1, skfem.ElementTriP1, 4),
    "triangle6": (skfem.MeshTri2, skfem.ElementTriP2, 6),
    "quad": (skfem.MeshQuad1, skfem.ElementQuad1, 6),
    "quad8": (skfem.MeshQuad2, skfem.ElementQuadS2, 8),
    "quad9": (skfem.MeshQuad2, skfem.ElementQuad2, 10),
    "tetra": (skfem.MeshTet1, skfem.ElementTetP1, 2),
    "tetra10": (
        skfem.MeshTet2,
        skfem.ElementTetP2,
        8,
    ),  # from 5 on, scikit-fem's points for tetrahedra are exact for one order less
    "hexahedron": (skfem.MeshHex1, skfem.ElementHex1, 5),
    "hexahedron20": (skfem.MeshHex2, skfem.ElementHexS2, 9),
    "hexahedron27": (skfem.MeshHex2, skfem.ElementHex2, 9),
    "wedge": (skfem.MeshWedge1, skfem.ElementWedge1, 5),
    "wedge15": (MeshWedge15, ElementWedge15, 9),
}
"""Geometry and shape functions of every kind, and the order of the points that integrate products of two of them exactly, on curved
elements too. The map of 8 nodes is one of 9, and that of 20 one of 27, whose last nodes follow from the others."""
CUBE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
"""Corners of hexahedra in the order of mesh files; scikit-fem has another one."""
CUBE_MIDDLES = np.array(
    [
        *((CUBE[a] + CUBE[b]) / 2 for a, b in HEXAHEDRON_EDGES),
        *([x, 0.5, 0.5] for x in (0, 1)),
        *([0.5, y, 0.5] for y in (0, 1)),
        *([0.5, 0.5, z] for z in (0, 1)),
        [0.5, 0.5, 0.5],
    ]
)
"""Middles of their edges and faces, and of themselves, in that order."""
NUMBERS_AT_ONCE = 3_000_000
"""Numbers of gradients of shape functions at once."""
MOST_KEPT_POINTS = 3_000
"""Coordinates of points of the reference element at which values of shape functions are kept."""
SMALLEST_VOLUME = 1e-8
"""Smallest area or volume of an element at a point, in parts of the power of its largest extent."""


@dataclass(frozen=True, eq=False)
class ElementBlock:
    """All elements of one kind in a mesh."""

    kind: str
    connectivity: np.ndarray  # (n_e, n_local) in the order of scikit-fem's shape functions
    geometry: skfem.Mesh  # with the same elements in the same order
    shapes: skfem.Element

    def functions(self) -> skfem.CellBasis:
        """Shape functions at points that integrate products of two of them exactly, on curved elements too."""
        return self._functions(points_of(self.kind))

    def functions_in_parts(self) -> Iterator[tuple[np.ndarray, skfem.CellBasis]]:
        """Shape functions and numbers of some elements after others, so that not all gradients are in memory at once."""
        points = points_of(self.kind)
        at_once = max(1, NUMBERS_AT_ONCE // (points[0].size * self.shapes.doflocs.shape[0]))
        for start in range(0, len(self.connectivity), at_once):
            elements = np.arange(start, min(start + at_once, len(self.connectivity)))
            yield elements, self._functions(points, elements)

    def functions_at(self, points: np.ndarray, elements: np.ndarray | None = None) -> skfem.CellBasis:
        """Shape functions at points (d, n_points) of the reference element, of all elements or of those with the given numbers."""
        return self._functions((points, np.ones(points.shape[1])), elements)

    def _functions(self, quadrature: tuple[np.ndarray, np.ndarray], elements: np.ndarray | None = None) -> skfem.CellBasis:
        """Shape functions at points; the gradient of the map is inverted once, where scikit-fem does so for each of them."""
        mapping = self.geometry.mapping()
        inverse = mapping.invDF(quadrature[0], elements)
        mapping.invDF = lambda _points, tind=None: inverse
        try:
            return skfem.CellBasis(self.geometry, self.shapes, mapping, quadrature=quadrature, elements=elements)
        finally:
            del mapping.invDF

    def numbering(self, functions: skfem.CellBasis, n_nodes: int) -> sparse.csr_array:
        """Sparse (functions, n_nodes) that says which shape function of scikit-fem belongs to which node."""
        pair = np.column_stack([functions.dofs.element_dofs.T.ravel(), self.connectivity.ravel()])
        row, column = np.unique(pair, axis=0).T
        return sparse.coo_array((np.ones(len(row)), (row, column)), shape=(functions.N, n_nodes)).tocsr()


def element_blocks(mesh: SolidMesh) -> list[ElementBlock]:
    """Elements of a mesh, kind by kind.

    Raises
    ------
    InputError
        An element is degenerate or folded over; names it by its nodes and its place. Or elements do not meet at all of their nodes.
    """
    found = [_block(kind, connectivity, mesh.nodes) for kind, connectivity in mesh.blocks.items()]
    for block in found:
        _refuse_degenerate(block, mesh.nodes)
    return found


def _block(kind: str, connectivity: np.ndarray, nodes: np.ndarray) -> ElementBlock:
    geometry, shapes, _ = KINDS[kind]
    connectivity = connectivity[:, _order(kind)]
    used, local = np.unique(connectivity, return_inverse=True)
    local, points = local.reshape(connectivity.shape), nodes[used]
    further = geometry.elem().doflocs[connectivity.shape[1] :].T
    if further.size:
        known = np.stack([shapes().lbasis(further, i)[0] for i in range(connectivity.shape[1])])
        local = np.column_stack([local, len(points) + np.arange(len(local) * further.shape[1]).reshape(len(local), -1)])
        points = np.vstack([points, np.einsum("kf,ekd->efd", known, nodes[connectivity]).reshape(-1, nodes.shape[1])])
    try:
        made = geometry(np.ascontiguousarray(points.T), np.ascontiguousarray(local.T), sort_t=False)
    except IndexError as error:  # scikit-fem counts nodes between corners by the sides of the elements
        raise InputError(
            f"the {kind} elements do not fit together: what is a corner of one lies between the corners of another, or two that meet have "
            "not the same node between their corners. Fix the mesh, or mesh it again."
        ) from error
    mapping = made.mapping()
    if hasattr(mapping, "elem"):  # that of straight triangles and tetrahedra has none
        mapping.elem = _evaluated_once(type(mapping.elem))
    return ElementBlock(kind, connectivity, made, _evaluated_once(shapes))


def _evaluated_once(shapes: type[skfem.Element]) -> skfem.Element:
    """Element of scikit-fem which evaluates its functions once at the same points: a map of 27 nodes asks for each of them 9 times."""
    found = shapes()
    found.lbasis = partial(_function_at, shapes)
    return found


def _function_at(shapes: type[skfem.Element], points: np.ndarray, number: int) -> tuple[np.ndarray, np.ndarray]:
    """Shape function and its gradient at points of the reference element; those at a few points are kept."""
    if points.size > MOST_KEPT_POINTS:
        found: tuple[np.ndarray, np.ndarray] = shapes().lbasis(points, number)
        return found
    return _known_function(shapes, np.asarray(points, float).tobytes(), points.shape, number)  # type: ignore[arg-type]


@lru_cache(maxsize=512)
def _known_function(
    shapes: type[skfem.Element], points: bytes, shape: tuple[int, ...], number: int
) -> tuple[np.ndarray, np.ndarray]:
    found: tuple[np.ndarray, np.ndarray] = shapes().lbasis(np.frombuffer(points).reshape(shape), number)
    return found


def _order(kind: str) -> np.ndarray:
    """Place in the mesh file's order of the node of every shape function."""
    places = KINDS[kind][1].doflocs
    if not kind.startswith("hexahedron"):
        return np.arange(len(places))
    return np.array([np.argmin(np.abs(np.vstack([CUBE, CUBE_MIDDLES]) - place).sum(axis=1)) for place in places])


def points_of(kind: str, order: int | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Points (d, n_points) of the reference element and their weights, which are exact to an order; by default to that of the kind."""
    _, shapes, own = KINDS[kind]
    order = own if order is None else order
    return wedge_points(order, order) if shapes.refdom is RefWedge else get_quadrature(shapes.refdom, order)


def wedge_points(across: int, along: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (3, n_points) of the reference wedge and their weights, exact to these orders in x and y, and in z.

    Those of scikit-fem are no points of a wedge: it pairs the coordinates of the triangle's points with those of all others.
    """
    (triangle, area), (line, length) = get_quadrature(RefTri, across), get_quadrature(RefLine, along)
    points = np.vstack([np.repeat(triangle, line.size, axis=1), np.tile(line, triangle.shape[1])])
    return points, np.kron(area, length)


def _refuse_degenerate(block: ElementBlock, nodes: np.ndarray) -> None:
    corners = nodes[block.connectivity]
    extent = np.ptp(corners, axis=1).max(axis=1)
    least, most = np.full(len(corners), np.inf), np.full(len(corners), -np.inf)
    for points in _test_points(block):
        area = _determinant(block.geometry.mapping().DF(points)) / np.where(extent > 0, extent, 1.0)[:, None] ** nodes.shape[1]
        least, most = np.minimum(least, area.min(axis=1)), np.maximum(most, area.max(axis=1))
    wrong = np.flatnonzero(~(np.maximum(least, -most) > SMALLEST_VOLUME))
    if len(wrong):
        place = ", ".join(f"{x:g}" for x in corners[wrong[0]].mean(axis=0))
        numbers = ", ".join(map(str, block.connectivity[wrong[0]]))
        raise InputError(
            f"{len(wrong)} of the {len(corners)} elements of kind {block.kind} are flat or folded over, the first with the nodes {numbers} "
            f"round ({place}). Mesh that place again, with middles of edges in the middle third."
        )


def _determinant(gradient: np.ndarray) -> np.ndarray:
    """Determinants of matrices (d, d, n_e, n_points)."""
    return np.linalg.det(np.moveaxis(gradient, (0, 1), (-2, -1)))


def _test_points(block: ElementBlock) -> Iterator[np.ndarray]:
    """Points of the reference element at which its area or volume must not vanish: the nodes, and those of integration."""
    yield block.shapes.doflocs.T
    yield points_of(block.kind)[0]
