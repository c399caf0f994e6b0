"""Nodes that a region of body.toml means, how means over them are taken, and the faces between them."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse

from preprocessing.elements.solids.elasticity import solid_matrices
from preprocessing.elements.solids.elements import element_blocks
from preprocessing.mesh.faces import BoundaryFaces
from preprocessing.mesh.outline import BoundaryLines
from preprocessing.mesh.solid_mesh import SolidMesh
from preprocessing.recipes.solids.body_tables import Region
from toolkit.foundation.errors import InputError
from toolkit.foundation.listed_names import meant

ON_EDGE = 1e-9
"""Part of the body's extent by which a node may be outside of a box."""


Boundary = BoundaryLines | BoundaryFaces
"""The boundary of a mesh in the plane, or in space."""


def nodes_in(mesh: SolidMesh, region: Region) -> np.ndarray:
    """Numbers of the nodes of a region, in order.

    Raises
    ------
    InputError
        The group is unknown, a number too high, or the region is empty.
    """
    if region.group is not None:
        found = _of_group(mesh, region.group)
    elif region.box is not None:
        found = _in_box(mesh, region.box)
    else:
        found = _numbered(mesh, np.unique(np.asarray(region.nodes, int)))
    if not len(found):
        raise InputError(f"{region.words} holds no node of the elements. Choose another group, or a larger box.")
    return found


def _numbered(mesh: SolidMesh, wanted: np.ndarray) -> np.ndarray:
    """Nodes by their numbers in the file."""
    known = np.arange(len(mesh.nodes)) if mesh.in_file is None else mesh.in_file
    if lacking := wanted[~np.isin(wanted, known)].tolist():
        raise InputError(
            f"no element has node {lacking[0]}; the nodes of the elements count from {known[0]} to {known[-1]}, from 0 in the file."
        )
    return np.searchsorted(known, wanted)


def _of_group(mesh: SolidMesh, group: str) -> np.ndarray:
    if group not in mesh.groups:
        raise InputError(
            f"the mesh has no group {group!r}{meant(group, mesh.groups)}; there are {', '.join(map(repr, mesh.groups)) or 'none'}. Name "
            "one of them, or take a box or numbers of nodes."
        )
    return mesh.groups[group]


def _in_box(mesh: SolidMesh, box: list[float]) -> np.ndarray:
    axes = "xyz"[: mesh.dimension]
    order = ", ".join(f"{axis}_{end}" for end in ("min", "max") for axis in axes)
    if len(box) != 2 * mesh.dimension:
        raise InputError(f"the box {box} has {len(box)} numbers, but the body has {mesh.dimension} axes; write {order}.")
    low, high = np.array(box).reshape(2, -1)
    if np.any(low > high):
        raise InputError(f"the box {box} is turned inside out; write {order}.")
    slack = ON_EDGE * mesh.size
    return np.flatnonzero(np.all((mesh.nodes >= low - slack) & (mesh.nodes <= high + slack), axis=1))


def spread_of(mesh: SolidMesh, boundary: Boundary | None, nodes: np.ndarray) -> Any:
    """Weights W (k, k) of means sum_kl W_kl f_k g_l over the nodes; the sum of all is 1.

    Where the nodes are those of whole elements, the mean is that over these elements, int f g dV / V; where every node is on an edge or
    face of the boundary between these nodes, that over the boundary, int f g dA / A: so it does not depend on the mesh. Else all nodes
    count alike.
    """
    for products in (_over_elements(mesh, nodes), None if boundary is None else boundary.between(nodes).products()):
        if products is not None:
            here = products[nodes][:, nodes]
            if np.all(here.diagonal().real > 0):
                return here / here.sum()
    return sparse.diags_array(np.full(len(nodes), 1 / len(nodes)), format="csr")


def _over_elements(mesh: SolidMesh, nodes: np.ndarray) -> Any:
    """Integrals int N_k N_l dV over elements between these nodes, (n_nodes, n_nodes); None where there are none.

    The nodes of the mesh may carry a complex step, along which the integral has its derivative.
    """
    inside = {kind: block[np.isin(block, nodes).all(axis=1)] for kind, block in mesh.blocks.items()}
    inside = {kind: block for kind, block in inside.items() if len(block)}
    if not inside:
        return None
    blocks = element_blocks(SolidMesh(mesh.nodes.real, inside))
    found = solid_matrices(blocks, len(mesh.nodes), mesh.dimension).scalar_mass
    if not np.iscomplexobj(mesh.nodes):
        return found
    return found + 1j * solid_matrices(blocks, len(mesh.nodes), mesh.dimension, mesh.nodes.imag).scalar_mass


def faces_in(mesh: SolidMesh, surface: BoundaryFaces, region: Region) -> BoundaryFaces:
    """Faces of the surface that a region means: those of the group, or all between its nodes.

    Raises
    ------
    InputError
        See `nodes_in`; or no face of the surface is there.
    """
    nodes = nodes_in(mesh, region)
    group = mesh.faces.get(region.group or "")
    found = surface.named(group) if group else surface.between(nodes)
    if not any(len(each) for each in found.faces.values()):
        raise InputError(
            f"{region.words} holds no whole face of the body's surface. Name a group of faces, or all nodes of some faces."
        )
    return found
