"""Elements that do not fit: those that lie in one another, and slits between their sides.

A mesh that covers every place once has every side at most twice, seen from opposite sides. Where it covers a place more often although
that is so (two meshes of one region, with nodes of their own), that region ends at sides that belong to one element only, and just
inside of one of these there are two elements. So two tests are enough, of which the second looks at the elements along the boundary alone.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from preprocessing.mesh.faces import ElementSides, Simplices, cut
from preprocessing.mesh.solid_mesh import SolidMesh
from toolkit.foundation.errors import InputError

INSIDE_PART = 0.5
"""Where an element is looked at, on the way from its side to its centre: parts that only touch, with curved faces meshed differently,
enter one another by less."""
EDGE_TOLERANCE = 1e-9
"""Part of a simplex by which a point may be outside of it: on its edge, but for round-off."""
FLAT_SIMPLEX = 1e-12
"""Volume of a simplex, in parts of the power of its extent, from which it can hold a point."""
PAIRS_AT_ONCE = 20_000
"""Pairs of points and elements at once."""


def refuse_overlaps(mesh: SolidMesh) -> None:
    """Refuse elements that lie in one another.

    Raises
    ------
    InputError
        It says how many do, and where the first ones are.
    """
    sides, simplices = cut(mesh.nodes, mesh.blocks)
    pairs = np.concatenate([_on_one_side(sides), *_inside_others(sides, _proper(simplices))])
    if len(pairs):
        one, other = pairs[np.argmin(pairs.min(axis=1))]
        raise InputError(
            f"{len(np.unique(pairs))} of the {sides.n_elements} elements of the mesh lie in one another, so that their mass would count "
            f"twice: the {_named(mesh, one)} and the {_named(mesh, other)} are the first. Delete one of the two meshes of that "
            "region, or cut its parts along common faces before meshing (gmsh: BooleanFragments, then Coherence)."
        )


def _on_one_side(sides: ElementSides) -> np.ndarray:
    """Pairs of elements (n, 2) that have a side in common and lie on the same side of it."""
    _, number, count = np.unique(np.column_stack([sides.key, sides.turn]), axis=0, return_inverse=True, return_counts=True)
    number = number.ravel()
    shared = np.flatnonzero(count[number] > 1)
    order = shared[np.argsort(number[shared], kind="stable")]
    same = number[order][1:] == number[order][:-1]
    return np.column_stack([sides.element[order][:-1][same], sides.element[order][1:][same]])


def _proper(simplices: Simplices) -> Simplices:
    """Simplices that hold points.

    The outer ones of an element that is folded over, within the limits of its shape functions, do not.
    """
    edges = simplices.corners[:, 1:] - simplices.corners[:, [0]]
    extent = np.abs(edges).max(axis=(1, 2))
    volume = np.linalg.det(edges / np.where(extent > 0, extent, 1.0)[:, None, None])
    mostly = np.sign(np.bincount(simplices.element, volume))
    kept = volume * mostly[simplices.element] > FLAT_SIMPLEX
    return Simplices(*(part[kept] for part in simplices))


def _inside_others(sides: ElementSides, simplices: Simplices) -> Iterator[np.ndarray]:
    """Pairs of an element on the boundary and another one that holds a point of it."""
    _, number, count = np.unique(sides.key, axis=0, return_inverse=True, return_counts=True)
    single = count[number.ravel()] == 1
    outer = np.flatnonzero(single[simplices.side])
    corners = simplices.corners[outer]
    points, owner = (1 - INSIDE_PART) * corners[:, 1:].mean(axis=1) + INSIDE_PART * corners[:, 0], simplices.element[outer]
    order = np.argsort(simplices.element, kind="stable")
    first = np.searchsorted(simplices.element[order], np.arange(sides.n_elements + 1))
    point, element = _near(points, owner, *_boxes(simplices, sides.n_elements))
    for some in np.array_split(np.arange(len(point)), 1 + len(point) // PAIRS_AT_ONCE):
        own = np.diff(first)[element[some]]
        pair = np.repeat(some, own)
        simplex = order[np.repeat(first[element[some]] - np.cumsum(own) + own, own) + np.arange(len(pair))]
        held = pair[_holds(simplices.corners[simplex], points[point[pair]])]
        yield np.column_stack([owner[point[held]], element[held]])


def _boxes(simplices: Simplices, n_elements: int) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest coordinates of the elements, (n_elements, d)."""
    low = np.full((n_elements, simplices.corners.shape[2]), np.inf)
    high = -low
    np.minimum.at(low, simplices.element, simplices.corners.min(axis=1))
    np.maximum.at(high, simplices.element, simplices.corners.max(axis=1))
    return low, high


def _near(points: np.ndarray, owner: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of points and of other elements whose boxes hold them, as numbers."""
    every, middle, radius = cKDTree(points), (low + high) / 2, np.linalg.norm(high - low, axis=1) / 2
    found = every.query_ball_point(middle, (1 + EDGE_TOLERANCE) * radius)
    point = np.concatenate([np.zeros(0, int), *(np.array(each, int) for each in found)])
    element = np.repeat(np.arange(len(low)), [len(each) for each in found])
    slack = EDGE_TOLERANCE * radius[element, None]
    held = np.all((points[point] >= low[element] - slack) & (points[point] <= high[element] + slack), axis=1)
    held &= owner[point] != element
    return point[held], element[held]


def _holds(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Whether simplices (n, d + 1, d) hold points (n, d)."""
    edges = np.swapaxes(corners[:, 1:] - corners[:, [0]], 1, 2)
    parts = np.linalg.solve(edges, (points - corners[:, 0])[:, :, None])[:, :, 0]
    return (parts.min(axis=1) >= -EDGE_TOLERANCE) & (parts.sum(axis=1) <= 1 + EDGE_TOLERANCE)


def _named(mesh: SolidMesh, element: int) -> str:
    """Words for an element: its kind and place."""
    for kind, block in mesh.blocks.items():
        if element < len(block):
            place = ", ".join(f"{x:g}" for x in mesh.nodes[block[element]].mean(axis=0))
            return f"{kind} round ({place})"
        element -= len(block)
    raise IndexError(element)


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
