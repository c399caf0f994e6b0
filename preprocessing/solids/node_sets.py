"""Nodes that a region of body.toml means, and how much of the boundary each of them stands for."""

from __future__ import annotations

from difflib import get_close_matches

import numpy as np

from preprocessing.solids.body_tables import Region
from preprocessing.solids.outline import BoundaryLines
from preprocessing.solids.solid_mesh import SolidMesh
from toolkit.errors import InputError

ON_EDGE = 1e-9
"""Part of the body's extent by which a node may be outside of a box."""


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
        close = get_close_matches(group, mesh.groups, n=1)
        hint = f" Did you mean {close[0]!r}?" if close else " Name one of them, or take a box or numbers of nodes."
        raise InputError(f"the mesh has no group {group!r}; there are {', '.join(map(repr, mesh.groups)) or 'none'}.{hint}")
    return mesh.groups[group]


def _in_box(mesh: SolidMesh, box: list[float]) -> np.ndarray:
    low, high = np.array(box[:2]), np.array(box[2:])
    if np.any(low > high):
        raise InputError(f"the box {box} is turned inside out; write x_min, y_min, x_max, y_max.")
    slack = ON_EDGE * mesh.size
    return np.flatnonzero(np.all((mesh.nodes >= low - slack) & (mesh.nodes <= high + slack), axis=1))


def weights_of(outline: BoundaryLines | None, nodes: np.ndarray) -> np.ndarray:
    """Share of each node in a mean over the nodes, positive, sum 1.

    Where every node is on an edge of the boundary between these nodes, the mean is that along the boundary, so that it does not depend
    on the mesh; else all count alike.
    """
    if outline is None:
        return np.full(len(nodes), 1 / len(nodes))
    inside = np.append(np.isin(np.arange(len(outline.nodes)), nodes), True)  # the last one stands for no node in the middle
    edges = outline.edges[inside[outline.edges].all(axis=1)]
    length = np.linalg.norm(outline.nodes[edges[:, 1]] - outline.nodes[edges[:, 0]], axis=1)
    straight = edges[:, 2] < 0
    ends, middle = np.where(straight, 1 / 2, 1 / 6) * length, np.where(straight, 0, 4 / 6) * length
    shares = np.bincount(np.append(edges, -1) + 1, np.append(np.column_stack([ends, ends, middle]), 0.0), len(inside))[1:][nodes]
    return shares / shares.sum() if np.all(shares > 0) else np.full(len(nodes), 1 / len(nodes))
