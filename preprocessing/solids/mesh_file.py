"""Mesh files of other programs, read by meshio and reduced to plain arrays."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from preprocessing.solids.outline import CORNERS
from preprocessing.solids.solid_mesh import SolidMesh, refuse_parts
from toolkit.errors import InputError, without_content

PLANE = {"triangle": 3, "triangle6": 6, "quad": 4, "quad8": 8, "quad9": 9}
"""Kinds of elements that are used, and their numbers of nodes."""
SPATIAL = {"tetra": 4, "tetra10": 10, "hexahedron": 8, "hexahedron20": 20, "hexahedron27": 27, "wedge": 6}
"""The same in space."""
LOWER = ("vertex", "line", "line3")
"""Kinds that serve to name groups only; in space those of the plane too."""
SOLID = ("tetra", "hexahedron", "wedge", "pyramid")
"""What the names of spatial kinds begin with."""
FLAT = 1e-9
"""Part of the extent by which a plane mesh may leave its plane."""
FAILURES = (OSError, ValueError, KeyError, IndexError, TypeError, AttributeError, AssertionError, StopIteration, SystemExit)
"""What meshio's readers raise on files that are not what their names say; some end the program."""


def read_mesh(path: Path, scale: float = 1.0) -> SolidMesh:
    """The elements of a mesh file, of the plane or spatial; nodes that none of them has are left out.

    Raises
    ------
    InputError
        The file cannot be read, holds kinds of elements that are not supported or elements twice, leaves its plane, or falls into parts.
    """
    raw = _read(path)
    kinds = _kinds(path, [block.type for block in raw.cells])
    wanted = [block for block in raw.cells if block.type in kinds]
    present = dict.fromkeys(block.type for block in wanted)
    blocks = {
        kind: _once(path, raw, np.concatenate([np.asarray(b.data, int) for b in wanted if b.type == kind])) for kind in present
    }
    used = np.unique(np.concatenate([block.ravel() for block in blocks.values()]))
    number = np.full(len(raw.points), -1)
    number[used] = np.arange(len(used))
    points = np.asarray(raw.points, float)[used]
    found = list(_groups(raw))
    mesh = SolidMesh(
        scale * (_plane(path, points) if kinds is PLANE else _space(path, points)),
        {kind: number[block] for kind, block in blocks.items()},
        {name: np.unique(number[nodes := _nodes(elements)][number[nodes] >= 0]) for name, elements in found},
        used,
        {name: faces for name, elements in found if (faces := _faces(elements, number))} if kinds is SPATIAL else {},
        len(raw.points),
    )
    refuse_parts(mesh)
    return mesh


def _once(path: Path, raw: Any, elements: np.ndarray) -> np.ndarray:
    """Every element once; gmsh 2.2 writes those that are in several groups several times, and nobody else should."""
    _, first = np.unique(np.sort(elements, axis=1), axis=0, return_index=True)
    twice = np.setdiff1d(np.arange(len(elements)), first)
    if len(twice) and path.suffix != ".msh":
        place = ", ".join(f"{x:g}" for x in np.asarray(raw.points, float)[elements[twice[0]]].mean(axis=0))
        raise InputError(
            f"the mesh {str(path)!r} holds {len(twice)} elements twice, the first round ({place}), so that it is not clear whether their "
            "mass counts twice. Delete the copies; what should be twice as heavy needs twice the density or width."
        )
    return elements[np.sort(first)]


def _read(path: Path) -> Any:
    """What meshio finds; what it prints becomes part of the error."""
    if not path.is_file():
        raise InputError(f"there is no mesh file {str(path)!r}. Mend the path; it is relative to the TOML file.")
    try:
        meshio = import_module("meshio")
    except ImportError as error:
        raise InputError(
            f"reading meshes needs meshio, which cannot be loaded ({error}). Install it with: pip install "
            "'ffrf-toolkit[preprocessing]'."
        ) from error
    said = StringIO()
    try:
        with redirect_stdout(said), redirect_stderr(said):
            return meshio.read(path, file_format="gmsh" if path.suffix == ".msh" else None)  # not that of ANSYS Fluent
    except (meshio.ReadError, *FAILURES) as error:
        reason = " ".join(without_content(f"{said.getvalue().rpartition('Error: ')[2]} {error}").split())
        raise InputError(
            f"the mesh file {str(path)!r} cannot be read by meshio ({reason}). Export it again, for example as gmsh .msh or Abaqus .inp."
        ) from error


def _kinds(path: Path, present: list[str]) -> dict[str, int]:
    """The kinds of which the body is made: those of space if there are any."""
    kinds = SPATIAL if any(kind.startswith(SOLID) for kind in present) else PLANE
    foreign = sorted(set(present) - {*PLANE, *kinds, *LOWER})
    if foreign or not set(present) & set(kinds):
        what = f"elements of the kinds {', '.join(foreign)}" if foreign else "no triangles and no quadrilaterals"
        raise InputError(
            f"the mesh {str(path)!r} holds {what}; possible are {', '.join(PLANE)} in the plane and {', '.join(SPATIAL)} in space. Mesh "
            "the body with these."
        )
    return kinds


def _plane(path: Path, points: np.ndarray) -> np.ndarray:
    """x and y of points whose z is the same."""
    points = _space(path, points)
    if points.shape[1] > 2 and np.ptp(points[:, 2]) > FLAT * np.ptp(points[:, :2]):
        raise InputError(
            f"the mesh {str(path)!r} has triangles or quadrilaterals only, but its z reaches from {points[:, 2].min():g} to "
            f"{points[:, 2].max():g}. Give a mesh in the plane of x and y, or mesh the volume with tetrahedra or hexahedra."
        )
    return points[:, :2]


def _space(path: Path, points: np.ndarray) -> np.ndarray:
    """Points that are numbers."""
    if not np.all(np.isfinite(points)):
        raise InputError(f"the mesh {str(path)!r} holds coordinates that are not finite numbers. Export it again.")
    return points


Elements = list[tuple[str, np.ndarray]]
"""Kind and nodes (n_e, n_local) of some elements."""


def _groups(raw: Any) -> Iterator[tuple[str, Elements]]:
    """Names and elements of node sets, element sets and physical groups."""
    yield from ((name, [("vertex", np.asarray(members, int)[:, None])]) for name, members in raw.point_sets.items())
    for name, sets in raw.cell_sets.items():
        if name not in raw.point_sets and not name.startswith("gmsh:"):
            of = zip(raw.cells, sets, strict=True)
            yield name, [(block.type, np.asarray(block.data[np.asarray(own, int)], int)) for block, own in of if own is not None]
    for name, (tag, dimension) in raw.field_data.items():  # gmsh 2.2
        tags = raw.cell_data.get("gmsh:physical")
        if tags is not None and name not in raw.cell_sets:
            of = zip(raw.cells, tags, strict=True)
            here = [(block, np.asarray(own) == tag) for block, own in of if block.dim == dimension]
            yield name, [(block.type, np.asarray(block.data[own], int)) for block, own in here]


def _nodes(elements: Elements) -> np.ndarray:
    """Numbers of the nodes of elements."""
    return np.unique(np.concatenate([np.zeros(0, int), *(each.ravel() for _, each in elements)])).astype(int)


def _faces(elements: Elements, number: np.ndarray) -> frozenset[tuple[int, ...]]:
    """Corners, in rising order, of those of the elements that are faces of spatial ones."""
    flat = [number[each[:, : CORNERS[kind]]] for kind, each in elements if kind in CORNERS]
    return frozenset(tuple(row) for each in flat for row in np.sort(each, axis=1).tolist())
