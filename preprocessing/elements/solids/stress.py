"""Rows of the stress operator: along the boundary or components in the elements of the plane, all components on a surface in space.

With the strain eps of the displacements and Lame's constants, for the unit vectors a and b,

    a . sigma b = lambda (a . b) tr eps + 2 mu a . eps b

On a free boundary in the plane the stress along it is the only one there is. At a node of a surface in space it is the mean of the
elements that meet there, each at that node.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import skfem
from scipy import sparse

from preprocessing.elements.solids.elements import ElementBlock
from preprocessing.mesh.faces import BoundaryFaces
from preprocessing.mesh.outline import BoundaryLines
from toolkit.foundation.errors import InputError

AXES = {"xx": (0, 0), "yy": (1, 1), "xy": (0, 1)}
COMPONENTS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
"""Axes of the six components in space, in their order: xx, yy, zz, yz, xz, xy."""
MIDDLE_OF_EDGE = (np.array([[0.5]]), np.ones(1))

Rows = tuple[Any, Any]
"""Stress rows for lambda and for mu, sparse (n_stress, n)."""


def stress_rows(
    quantity: str | None,
    blocks: Sequence[ElementBlock],
    boundary: BoundaryLines | BoundaryFaces,
    motion: np.ndarray | None = None,
) -> Rows:
    """Rows of one quantity of the table [stress], for unit Lame's constants; None is that of the dimension.

    Parameters
    ----------
    motion : (n_nodes, 3) in space, for derivatives along it; else None

    Raises
    ------
    InputError
        The quantity is one of the other dimension.
    """
    n = boundary.nodes.size
    if quantity == "none":
        return sparse.csr_array((0, n)), sparse.csr_array((0, n))
    if isinstance(boundary, BoundaryFaces):
        if quantity not in (None, "surface"):
            raise InputError(f'quantity = "{quantity}" is one of plane bodies. Take "surface" or "none".')
        return surface_rows(blocks, boundary.nodes, boundary.points, motion)
    if quantity == "surface":
        raise InputError('quantity = "surface" is that of spatial bodies. Take "tangential", "xx", "yy", "xy" or "none".')
    quantity = quantity or "tangential"
    if quantity == "tangential":
        return _along(blocks, boundary)
    a, b = AXES[quantity]
    found = []
    for block in blocks:
        functions = block.functions_at(_centre(block)[:, None])
        found.append(_rows(_gradients(functions), block.connectivity, np.eye(2)[[a]], np.eye(2)[[b]], n))
    return tuple(sparse.vstack(parts, format="csr") for parts in zip(*found, strict=True))  # type: ignore[return-value]


def _centre(block: ElementBlock) -> np.ndarray:
    """Centre of the reference element."""
    return block.geometry.elem.refdom.p.mean(axis=1)


def _along(blocks: Sequence[ElementBlock], outline: BoundaryLines) -> Rows:
    """Stress along the boundary in the middle of its edges, in their order."""
    n, places, found = outline.nodes.size, [], []
    number = {tuple(sorted(pair)): k for k, pair in enumerate(outline.edges[:, :2].tolist())}
    for block in blocks:
        corners = _corner_nodes(block)[block.geometry.facets].T.tolist()  # nodes at both ends of every edge
        facets = [k for k, pair in enumerate(corners) if tuple(sorted(pair)) in number]
        if not facets:
            continue
        functions = skfem.FacetBasis(block.geometry, block.shapes, facets=np.array(facets), quadrature=MIDDLE_OF_EDGE)
        normal = functions.normals[:, :, 0].T
        tangent = np.column_stack([-normal[:, 1], normal[:, 0]])
        found.append(_rows(_gradients(functions), block.connectivity[functions.tind], tangent, tangent, n))
        places += [number[tuple(sorted(corners[k]))] for k in functions.find]
    order = np.argsort(places)
    return tuple(sparse.vstack(parts, format="csr")[order] for parts in zip(*found, strict=True))  # type: ignore[return-value]


def _corner_nodes(block: ElementBlock) -> np.ndarray:
    """Node of every vertex of scikit-fem's mesh."""
    vertices = block.geometry.t
    found = np.zeros(vertices.max() + 1, int)
    found[vertices] = block.connectivity[:, : len(vertices)].T
    return found


def surface_rows(blocks: Sequence[ElementBlock], nodes: np.ndarray, points: np.ndarray, motion: np.ndarray | None = None) -> Rows:
    """Six rows for every point, a node of the surface; with a motion of the nodes (n_nodes, 3), their derivatives along it.

    Parameters
    ----------
    nodes : (n_nodes, 3)
    points : (n_points,) numbers of nodes
    """
    where = np.full(len(nodes), -1)
    where[points] = np.arange(len(points))
    meeting = np.bincount(np.concatenate([block.connectivity.ravel() for block in blocks]), minlength=len(nodes))
    found: list[Any] = [sparse.csr_array((6 * len(points), nodes.size)) for _ in range(2)]
    for block in blocks:
        touching = np.flatnonzero((where[block.connectivity] >= 0).any(axis=1))
        every = _gradients_at_nodes(block, touching, nodes, motion)
        for k in range(block.connectivity.shape[1]):
            on = where[block.connectivity[touching, k]] >= 0
            members = block.connectivity[touching[on]]
            here = members[:, k]
            shares = (every[..., k][:, on] / meeting[here][:, None]).transpose(1, 2, 0)
            entries = (_normal_rows(shares, members, where[here]), _shear_rows(shares, members, where[here]))
            found = [
                total + sparse.coo_array((value, (row, column)), shape=total.shape).tocsr()
                for total, (value, row, column) in zip(found, entries, strict=True)
            ]
    return found[0], found[1]


def _gradients_at_nodes(block: ElementBlock, elements: np.ndarray, nodes: np.ndarray, motion: np.ndarray | None) -> np.ndarray:
    """Gradients of the shape functions i at the nodes k of some elements, (3, n_e, i, k), or their rates along a motion."""
    functions = block.functions_at(block.shapes.doflocs.T, elements)
    gradients = np.stack([functions.basis[i][0].grad for i in range(functions.Nbfun)], axis=2)
    if motion is None:
        return gradients
    slope = np.einsum("aeik,eic->caek", gradients, motion[block.connectivity[elements]])
    return -np.einsum("caek,ceik->aeik", slope, gradients)


def _normal_rows(gradients: np.ndarray, members: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, ...]:
    """Values, rows and columns of tr eps in the first three rows of points, one point for each element, by gradients (n_e, i, 3)."""
    row = 6 * points[:, None, None, None] + np.arange(3)[:, None, None]
    return _flat(gradients[:, None], row, 3 * members[:, None, :, None] + np.arange(3))


def _shear_rows(gradients: np.ndarray, members: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, ...]:
    """Values, rows and columns of 2 a . eps b in all six rows: the derivative along b of displacement along a, and vice versa."""
    axes = np.array(COMPONENTS)
    values = np.moveaxis(gradients[:, :, axes[:, ::-1]], 2, 1)
    row = 6 * points[:, None, None, None] + np.arange(6)[:, None, None]
    return _flat(values, row, 3 * members[:, None, :, None] + axes[:, None])


def _flat(*each: np.ndarray) -> tuple[np.ndarray, ...]:
    return tuple(every.ravel() for every in np.broadcast_arrays(*each))


def _gradients(functions: Any) -> np.ndarray:
    """Gradients of all shape functions at one point of each element, (d, n_e, n_local)."""
    return np.stack([functions.basis[i][0].grad[:, :, 0] for i in range(functions.Nbfun)], axis=2)


def _rows(gradient: np.ndarray, members: np.ndarray, a: np.ndarray, b: np.ndarray, n: int) -> Rows:
    """Rows for lambda and mu at one point of each element, its nodes being `members` (n_e, n_local); a, b are (n_e or 1, d)."""
    each = (len(members), len(gradient))
    along_a, along_b = (np.einsum("ed,dei->ei", np.broadcast_to(v, each), gradient) for v in (a, b))
    first = np.einsum("e,dei->eid", np.sum(np.broadcast_to(a * b, each), axis=1), gradient)
    shear = along_b[:, :, None] * a[:, None, :] + along_a[:, :, None] * b[:, None, :]
    return _placed(first, members, n), _placed(shear, members, n)


def _placed(values: np.ndarray, members: np.ndarray, n: int) -> Any:
    """Values (n_e, n_local, d) at the nodal coordinates of the members, one row for each element."""
    d = values.shape[2]
    column = d * members[:, :, None] + np.arange(d)
    row = np.broadcast_to(np.arange(len(members))[:, None, None], column.shape)
    return sparse.coo_array((values.ravel(), (row.ravel(), column.ravel())), shape=(len(members), n)).tocsr()
