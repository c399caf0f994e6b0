"""Slits: sides of elements that lie on one another without a node in common, so that the body comes apart there."""

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
    """What there is to say about slits of a mesh; nothing where it has none."""
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
