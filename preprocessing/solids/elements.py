"""The elements of a mesh with the shape functions of scikit-fem, numbered as the nodes of the mesh are."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import skfem
from scipy import sparse
from skfem.quadrature import get_quadrature

from preprocessing.solids.solid_mesh import SolidMesh
from toolkit.errors import InputError

KINDS: dict[str, tuple[type, type]] = {
    "triangle": (skfem.MeshTri1, skfem.ElementTriP1),
    "triangle6": (skfem.MeshTri2, skfem.ElementTriP2),
    "quad": (skfem.MeshQuad1, skfem.ElementQuad1),
    "quad8": (skfem.MeshQuad2, skfem.ElementQuadS2),
    "quad9": (skfem.MeshQuad2, skfem.ElementQuad2),
}
"""Geometry and shape functions of every kind; the map of 8 nodes is one of 9, whose last node follows from the others."""
MIDDLE_OF_8 = np.array([-1, -1, -1, -1, 2, 2, 2, 2]) / 4
"""The ninth node from the eight."""
DEGENERATE = 1e-8
"""Smallest area of an element at a point, in parts of the square of its largest extent."""


@dataclass(frozen=True, eq=False)
class ElementBlock:
    """All elements of one kind."""

    kind: str
    connectivity: np.ndarray  # (n_e, n_local)
    geometry: Any  # mesh of scikit-fem with the same elements in the same order
    shapes: Any  # element of scikit-fem

    def functions(self) -> Any:
        """Shape functions at points that integrate products of two of them exactly, on curved elements too."""
        return skfem.CellBasis(self.geometry, self.shapes, intorder=2 * self.shapes.maxdeg + 2)

    def functions_at(self, point: np.ndarray) -> Any:
        """Shape functions at one point (d,) of the reference element."""
        return skfem.CellBasis(self.geometry, self.shapes, quadrature=(point[:, None], np.ones(1)))

    def numbering(self, functions: Any, n_nodes: int) -> Any:
        """Sparse (functions, n_nodes) that says which shape function of scikit-fem belongs to which node."""
        pair = np.column_stack([functions.element_dofs.T.ravel(), self.connectivity.ravel()])
        row, column = np.unique(pair, axis=0).T
        return sparse.coo_array((np.ones(len(row)), (row, column)), shape=(functions.N, n_nodes)).tocsr()


def element_blocks(mesh: SolidMesh) -> list[ElementBlock]:
    """The elements, kind by kind.

    Raises
    ------
    InputError
        An element is degenerate or folded over; names it by its nodes and its place.
    """
    found = [_block(kind, connectivity, mesh.nodes) for kind, connectivity in mesh.blocks.items()]
    for block in found:
        _refuse_degenerate(block, mesh.nodes)
    return found


def _block(kind: str, connectivity: np.ndarray, nodes: np.ndarray) -> ElementBlock:
    geometry, shapes = KINDS[kind]
    used, local = np.unique(connectivity, return_inverse=True)
    local, points = local.reshape(connectivity.shape), nodes[used]
    if kind == "quad8":
        middles = np.einsum("k,ekd->ed", MIDDLE_OF_8, nodes[connectivity])
        local = np.column_stack([local, len(points) + np.arange(len(local))])
        points = np.vstack([points, middles])
    made = geometry(np.ascontiguousarray(points.T), np.ascontiguousarray(local.T), sort_t=False)
    return ElementBlock(kind, connectivity, made, shapes())


def _refuse_degenerate(block: ElementBlock, nodes: np.ndarray) -> None:
    corners = nodes[block.connectivity]
    extent = np.ptp(corners, axis=1).max(axis=1)
    least, most = np.full(len(corners), np.inf), np.full(len(corners), -np.inf)
    for points in _test_points(block):
        area = _determinant(block.geometry.mapping().DF(points)) / np.where(extent > 0, extent, 1.0)[:, None] ** 2
        least, most = np.minimum(least, area.min(axis=1)), np.maximum(most, area.max(axis=1))
    wrong = np.flatnonzero(~(np.maximum(least, -most) > DEGENERATE))
    if len(wrong):
        place = ", ".join(f"{x:g}" for x in corners[wrong[0]].mean(axis=0))
        numbers = ", ".join(map(str, block.connectivity[wrong[0]]))
        raise InputError(
            f"{len(wrong)} of the {len(corners)} elements of kind {block.kind} are flat or folded over, the first with the nodes {numbers} "
            f"round ({place}). Mesh that place again, with middles of edges in the middle third."
        )


def _determinant(gradient: np.ndarray) -> np.ndarray:
    """Of (d, d, n_e, n_points)."""
    return np.linalg.det(np.moveaxis(gradient, (0, 1), (-2, -1)))


def _test_points(block: ElementBlock) -> Iterator[np.ndarray]:
    """Points of the reference element at which its area must not vanish: the nodes, and those of integration."""
    yield block.shapes.doflocs.T
    yield get_quadrature(block.shapes.refdom, 2 * block.shapes.maxdeg + 2)[0]
