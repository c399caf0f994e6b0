"""Sides of elements that do not fit: slits, where the body comes apart, and triangles that meet quadrilaterals."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from preprocessing.mesh.simplices import cut
from preprocessing.mesh.solid_mesh import SolidMesh

SAME_PLACE = 1e-9
"""Distance of nodes, in parts of the body's extent, below which they lie at one place: coordinates of files hold more digits."""


def slit_told(mesh: SolidMesh) -> str:
    """Remark on slits of a mesh; empty where it has none."""
    place = _places(mesh.nodes)
    if place is None:
        return ""
    sides, _ = cut(mesh.nodes, mesh.blocks)
    single = _rows_of(sides.key, 1)
    split = single & _rows_of(np.sort(np.where(sides.key < 0, -1, place[sides.key]), axis=1), 2)
    if not split.any():
        return ""
    first = sides.key[np.argmax(split)]
    where = ", ".join(f"{x:g}" for x in mesh.nodes[first[first >= 0]].mean(axis=0))
    return (
        f"the mesh has a slit: {split.sum()} sides of elements lie on one another, but share no nodes, so that the body comes apart there "
        f"and its parts enter one another unhindered; one is at ({where}). If it is whole there, merge coincident nodes in the program "
        "that made the mesh (gmsh: Coherence)."
    )


def misfit_told(mesh: SolidMesh) -> str:
    """Remark on triangles that meet quadrilaterals, or tetrahedra beside hexahedra; empty where there are none."""
    if not any(kind.startswith("tetra") for kind in mesh.blocks) or all(kind.startswith("tetra") for kind in mesh.blocks):
        return ""
    sides, _ = cut(mesh.nodes, mesh.blocks)
    single = sides.key[_rows_of(sides.key, 1)]
    triangles, quads = single[single[:, 3] < 0, :3], single[single[:, 3] >= 0]
    halves = np.concatenate([quads[:, [k for k in range(4) if k != left]] for left in range(4)])
    number = np.unique(np.concatenate([triangles, halves]), axis=0, return_inverse=True)[1].ravel()
    meeting = np.isin(number[: len(triangles)], number[len(triangles) :])
    if not meeting.any():
        return ""
    where = ", ".join(f"{x:g}" for x in mesh.nodes[triangles[np.argmax(meeting)]].mean(axis=0))
    return (
        f"{meeting.sum()} triangles of tetrahedra or wedges meet quadrilaterals of other elements, the first at ({where}): they share "
        "nodes but not the displacements between them, so that gaps open there under load. Mesh the body with "
        "elements of one kind."
    )


def _places(nodes: np.ndarray) -> np.ndarray | None:
    """The number of the place of every node, (n,), or nothing where no two nodes share one."""
    pairs = cKDTree(nodes).query_pairs(SAME_PLACE * np.ptp(nodes, axis=0).max(), output_type="ndarray")
    if not len(pairs):
        return None
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(nodes), len(nodes)))
    found: np.ndarray = connected_components(graph, directed=False)[1]
    return found


def _rows_of(key: np.ndarray, count: int) -> np.ndarray:
    """Which rows occur so many times, (n,)."""
    _, number, counts = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    found: np.ndarray = counts[number.ravel()] == count
    return found
