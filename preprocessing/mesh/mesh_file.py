"""Mesh files of other programs, as plain arrays that were checked."""

from __future__ import annotations

import json
from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np

from preprocessing.foreign_files.apart import read_apart
from preprocessing.foreign_files.contents import KNOWN, LOWER, PLANE, SOLID, SPATIAL, Elements, MeshContents, PointMass
from preprocessing.foreign_files.included_files import drawn_on
from preprocessing.mesh.element_numbering import (
    Renumbering,
    distinct,
    first_of_copies,
    joined,
    refuse_exchanged,
    refuse_unlike,
    uncollapsed,
)
from preprocessing.mesh.faces import CORNERS
from preprocessing.mesh.solid_mesh import SolidMesh, refuse_parts
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import LARGEST

PLANE_TOLERANCE = 1e-9
"""Part of the extent by which a plane mesh may leave its plane."""

MOST_RIGID_NODES, MOST_CARRIERS = 200, 500
"""Nodes of a rigid body that carry a mass, and most nodes whose mean does."""


def read_mesh(path: Path, scale: float = 1.0, leave_out: Sequence[str] = ()) -> SolidMesh:
    """The elements of a mesh file, of the plane or spatial; nodes that none of them has are left out.

    Parameters
    ----------
    path : the file
    scale : by which its coordinates are multiplied
    leave_out : names of element types, keywords and cards that are not to be part of the body though they stand in the file

    Raises
    ------
    InputError
        The file cannot be read, holds kinds of elements that are not supported or elements twice, leaves its plane, or falls into parts.
    """
    raw = uncollapsed(path, _read(path, leave_out))
    kinds = _kinds(path, [kind for kind, _ in raw.cells])
    present = [kind for kind in dict.fromkeys(kind for kind, _ in raw.cells) if kind in kinds]
    blocks = {kind: _refuse_twice(path, raw, joined([block for other, block in raw.cells if other == kind])) for kind in present}
    used = distinct([*blocks.values()], len(raw.points))
    number = Renumbering.keeping(used, len(raw.points))
    points = raw.points[used]
    _refuse_places(path, points, scale)
    mesh = SolidMesh(
        scale * (_plane(path, points) if kinds is PLANE else _space(path, points)),
        {kind: number.of(block) for kind, block in blocks.items()},
        _node_groups(raw, number),
        used,
        {name: faces for name, elements in raw.groups if (faces := _faces(elements, number))} if kinds is SPATIAL else {},
        len(raw.points),
        {name: found for name, elements in raw.groups if (found := _own(elements, blocks, number))},
        raw.labels[used] if len(raw.labels) else None,
        _masses(path, raw.masses, number.table, scale, 2 if kinds is PLANE else 3),
        raw.left_out,
        raw.remarks,
    )
    refuse_exchanged(path, mesh.nodes, mesh.blocks)
    refuse_unlike(path, mesh.nodes, mesh.blocks)
    refuse_parts(mesh)
    return mesh


def _node_groups(raw: MeshContents, number: Renumbering) -> dict[str, np.ndarray]:
    """Nodes of every group, in the new numbers; where two have one name, as a node set and an element set may, those of the first."""
    found: dict[str, np.ndarray] = {}
    for name, elements in raw.groups:
        if name not in found:
            nodes = number.of(distinct([each for _, each in elements], len(number.table)))
            found[name] = nodes[nodes >= 0]
    return found


def _refuse_twice(path: Path, raw: MeshContents, elements: np.ndarray) -> np.ndarray:
    """Elements of the body, which are refused if one of them is there twice."""
    twice = np.flatnonzero(~first_of_copies(elements))
    if len(twice):
        place = ", ".join(f"{x:g}" for x in raw.points[elements[twice[0]]].mean(axis=0))
        raise InputError(
            f"the mesh {str(path)!r} holds {len(twice)} elements twice, the first round ({place}), so that it is not clear whether their "
            "mass counts twice. Delete the copies; what should be twice as heavy needs twice the density or width."
        )
    return elements


def _read(path: Path, leave_out: Sequence[str]) -> MeshContents:
    """Contents of the file, with the numbers of nodes in range."""
    remedy = "Export it again, for example as gmsh .msh or Abaqus .inp."
    found = MeshContents.received(read_apart("mesh", path, "as a mesh", remedy, json.dumps([*leave_out]), drawn=drawn_on(path)))
    points = found.points
    cells = [(kind, block) for kind, block in found.cells if block.size or kind not in KNOWN]
    groups = [(name, [(kind, block) for kind, block in elements if block.size]) for name, elements in found.groups]
    if points.ndim != 2 or points.shape[1] not in (2, 3) or points.dtype.kind != "f":
        raise InputError(
            f"the mesh {str(path)!r} has points of shape {points.shape}. Export x and y, or x, y and z, of each point."
        )
    for kind, block in (*cells, *(each for _, elements in groups for each in elements)):
        _refuse_numbers(path, kind, block, len(points))
    return found._replace(cells=cells, groups=groups)


def _masses(path: Path, masses: Sequence[PointMass], number: np.ndarray, scale: float, dimension: int) -> list[PointMass]:
    """Concentrated masses in the new numbers of nodes, with lengths times the scale.

    Raises
    ------
    InputError
        A mass is negative or has no place, or is on a node that no element has and that follows no such nodes.
    """
    found = []
    for each in masses:
        if each.mass < 0 or not np.all(np.isfinite([each.mass, *each.place, *each.inertia])):
            raise InputError(
                f"the mesh {str(path)!r} has a mass ({each.source}) that is negative, or whose size, place or inertia is no finite number. "
                "Correct it, or leave it out: leave_out in [mesh]."
            )
        if not len(each.carriers) or np.any(number[each.carriers] < 0):
            raise InputError(
                f"the mesh {str(path)!r} has a mass ({each.source}) on a node that no element of the body has, and that no rigid body ties "
                "to such nodes. Put it on a node of the body, or leave it out: leave_out in [mesh]."
            )
        place, inertia = (scale * x for x in each.place[:dimension]), (scale**2 * x for x in each.inertia)
        found.append(each._replace(place=tuple(place), carriers=_carriers(path, each, number), inertia=tuple(inertia)))
    return found


def _carriers(path: Path, mass: PointMass, number: np.ndarray) -> np.ndarray:
    """Nodes that carry a mass, or as many of a rigid body's as tell its motion: every pair of them costs memory."""
    nodes: np.ndarray = np.unique(number[mass.carriers])
    if mass.rigid and len(nodes) > MOST_RIGID_NODES:
        return nodes[np.linspace(0, len(nodes) - 1, MOST_RIGID_NODES).astype(int)]
    if len(nodes) > MOST_CARRIERS:
        raise InputError(
            f"the mesh {str(path)!r} has a mass ({mass.source}) that follows the mean of {len(nodes)} nodes; {MOST_CARRIERS} are the most. "
            "Let it follow fewer of them, or leave it out: leave_out in [mesh]."
        )
    return nodes


def _refuse_numbers(path: Path, kind: str, block: np.ndarray, n: int) -> None:
    """Refuse elements with another number of nodes than their kind has, and nodes that are not there."""
    if not block.size or kind not in KNOWN:
        return
    if block.ndim != 2 or block.shape[1] != KNOWN[kind]:
        raise InputError(f"the mesh {str(path)!r} has a {kind} without its {KNOWN[kind]} nodes. Export it again.")
    if block.min() < 0 or block.max() >= n:
        wrong = int(block.min() if block.min() < 0 else block.max())
        raise InputError(
            f"an element or a group of the mesh {str(path)!r} names node {wrong}, and the nodes count from 0 to {n - 1}. Export it again."
        )


def _kinds(path: Path, present: list[str]) -> dict[str, int]:
    """Kinds of elements that the body is made of: those of space if there are any."""
    kinds = SPATIAL if any(kind.startswith(SOLID) for kind in present) else PLANE
    foreign = sorted(set(present) - {*PLANE, *kinds, *LOWER})
    if foreign or not set(present) & set(kinds):
        what = f"elements of the kinds {', '.join(foreign)}" if foreign else "no triangles and no quadrilaterals"
        raise InputError(
            f"the mesh {str(path)!r} holds {what}; possible are {', '.join(PLANE)} in the plane and {', '.join(SPATIAL)} in space. Mesh "
            "the body with these."
        )
    return kinds


def _refuse_places(path: Path, points: np.ndarray, scale: float) -> None:
    """Refuse places of nodes that no body has."""
    if not np.all(np.isfinite(points)):
        raise InputError(f"the mesh {str(path)!r} holds coordinates that are not finite numbers. Export it again.")
    farthest = float(np.abs(points).max(initial=0.0))
    if farthest * scale > LARGEST or farthest > LARGEST:
        raise InputError(
            f"the mesh {str(path)!r} reaches to {farthest:g}, times its scale {scale:g}. Fix the unit of its coordinates."
        )
    if not len(points) or not np.ptp(points, axis=0).max() * scale > 1 / LARGEST:
        raise InputError(f"the nodes of the elements of the mesh {str(path)!r} are all at one place. Export it again.")


def _plane(path: Path, points: np.ndarray) -> np.ndarray:
    """Coordinates x and y of points whose z is the same."""
    if points.shape[1] > 2 and np.ptp(points[:, 2]) > PLANE_TOLERANCE * np.ptp(points[:, :2]):
        raise InputError(
            f"the mesh {str(path)!r} has triangles or quadrilaterals only, but its z reaches from {points[:, 2].min():g} to "
            f"{points[:, 2].max():g}. Give a mesh in the plane of x and y, or mesh the volume with tetrahedra or hexahedra."
        )
    return points[:, :2]


def _space(path: Path, points: np.ndarray) -> np.ndarray:
    """Points with three coordinates."""
    if points.shape[1] < 3:
        raise InputError(f"the mesh {str(path)!r} has elements of space, but its points have x and y only. Export z too.")
    return points


def _own(elements: Elements, kinds: Collection[str], number: Renumbering) -> dict[str, np.ndarray]:
    """Elements of the body's kinds, in the new numbers of nodes."""
    present = [kind for kind in kinds if any(kind == other for other, _ in elements)]
    return {kind: number.of(joined([each for other, each in elements if other == kind])) for kind in present}


def _faces(elements: Elements, number: Renumbering) -> frozenset[tuple[int, ...]]:
    """Corners, in rising order, of those elements that are faces of spatial ones."""
    flat = [number.of(each[:, : CORNERS[kind]]) for kind, each in elements if kind in CORNERS]
    return frozenset(tuple(row) for each in flat for row in np.sort(each, axis=1).tolist())
