"""Rows of the stress operator of a plane mesh: along the boundary, or components in the elements.

With the strain eps of the displacements and Lame's constants, for the unit vectors a and b,

    a . sigma b = lambda (a . b) tr eps + 2 mu a . eps b

On a free boundary the stress along it is the only one there is.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import skfem
from scipy import sparse

from preprocessing.solids.elements import ElementBlock
from preprocessing.solids.outline import BoundaryLines

AXES = {"xx": (0, 0), "yy": (1, 1), "xy": (0, 1)}
MIDDLE_OF_EDGE = (np.array([[0.5]]), np.ones(1))

Rows = tuple[Any, Any]
"""Those for lambda and for mu, sparse (n_stress, n)."""


def stress_rows(quantity: str, blocks: Sequence[ElementBlock], outline: BoundaryLines) -> Rows:
    """Rows of one quantity of the table [stress], for unit Lame's constants."""
    n = outline.nodes.size
    if quantity == "none":
        return sparse.csr_array((0, n)), sparse.csr_array((0, n))
    if quantity == "tangential":
        return _along(blocks, outline)
    a, b = AXES[quantity]
    found = [_rows(block.functions_at(_centre(block)), block.connectivity, np.eye(2)[[a]], np.eye(2)[[b]], n) for block in blocks]
    return tuple(sparse.vstack(parts, format="csr") for parts in zip(*found, strict=True))  # type: ignore[return-value]


def _centre(block: ElementBlock) -> np.ndarray:
    """Of the reference element."""
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
        found.append(_rows(functions, block.connectivity[functions.tind], tangent, tangent, n))
        places += [number[tuple(sorted(corners[k]))] for k in functions.find]
    order = np.argsort(places)
    return tuple(sparse.vstack(parts, format="csr")[order] for parts in zip(*found, strict=True))  # type: ignore[return-value]


def _corner_nodes(block: ElementBlock) -> np.ndarray:
    """Node of every vertex of scikit-fem's mesh."""
    vertices = block.geometry.t
    found = np.zeros(vertices.max() + 1, int)
    found[vertices] = block.connectivity[:, : len(vertices)].T
    return found


def _rows(functions: Any, members: np.ndarray, a: np.ndarray, b: np.ndarray, n: int) -> Rows:
    """Rows for lambda and mu at one point of each element, its nodes being `members` (n_e, n_local); a, b are (n_e or 1, 2)."""
    gradient = np.stack([functions.basis[i][0].grad[:, :, 0] for i in range(functions.Nbfun)], axis=2)  # (2, n_e, n_local)
    along_a, along_b = (np.einsum("ed,dei->ei", np.broadcast_to(v, (len(members), 2)), gradient) for v in (a, b))
    first = np.einsum("e,dei->eid", np.sum(np.broadcast_to(a * b, (len(members), 2)), axis=1), gradient)
    shear = along_b[:, :, None] * a[:, None, :] + along_a[:, :, None] * b[:, None, :]
    return _placed(first, members, n), _placed(shear, members, n)


def _placed(values: np.ndarray, members: np.ndarray, n: int) -> Any:
    """Values (n_e, n_local, 2) at the nodal coordinates of the members, one row for each element."""
    column = 2 * members[:, :, None] + np.arange(2)
    row = np.broadcast_to(np.arange(len(members))[:, None, None], column.shape)
    return sparse.coo_array((values.ravel(), (row.ravel(), column.ravel())), shape=(len(members), n)).tocsr()
