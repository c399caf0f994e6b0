"""Mesh files of other programs, read by meshio and reduced to plain arrays."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from preprocessing.solids.solid_mesh import SolidMesh, refuse_parts
from toolkit.errors import InputError

PLANE = {"triangle": 3, "triangle6": 6, "quad": 4, "quad8": 8, "quad9": 9}
"""Kinds of elements that are used, and their numbers of nodes."""
LOWER = ("vertex", "line", "line3")
"""Kinds that serve to name groups only."""
SOLID = ("tetra", "hexahedron", "wedge", "pyramid")
FLAT = 1e-9
"""Part of the extent by which a plane mesh may leave its plane."""
FAILURES = (OSError, ValueError, KeyError, IndexError, TypeError, AttributeError, AssertionError, StopIteration, SystemExit)
"""What meshio's readers raise on files that are not what their names say; some end the program."""


def read_mesh(path: Path, scale: float = 1.0) -> SolidMesh:
    """The plane elements of a mesh file; nodes that none of them has are left out.

    Raises
    ------
    InputError
        The file cannot be read, is spatial, holds no plane elements or kinds that are not supported, or falls into parts.
    """
    raw = _read(path)
    wanted = [block for block in raw.cells if block.type in PLANE]
    _refuse_kinds(path, [block.type for block in raw.cells])
    kinds = dict.fromkeys(block.type for block in wanted)
    blocks = {kind: _once(np.concatenate([np.asarray(b.data, int) for b in wanted if b.type == kind])) for kind in kinds}
    used = np.unique(np.concatenate([block.ravel() for block in blocks.values()]))
    number = np.full(len(raw.points), -1)
    number[used] = np.arange(len(used))
    groups = {name: number[members][number[members] >= 0] for name, members in _groups(raw)}
    nodes = scale * _plane(path, np.asarray(raw.points, float)[used])
    members = {name: np.unique(group) for name, group in groups.items()}
    mesh = SolidMesh(nodes, {kind: number[block] for kind, block in blocks.items()}, members, used)
    refuse_parts(mesh)
    return mesh


def _once(elements: np.ndarray) -> np.ndarray:
    """Every element once; gmsh 2.2 writes those that are in several groups several times."""
    _, first = np.unique(np.sort(elements, axis=1), axis=0, return_index=True)
    return elements[np.sort(first)]


def _read(path: Path) -> Any:
    """What meshio finds; what it prints becomes part of the error."""
    if not path.is_file():
        raise InputError(f"there is no mesh file {str(path)!r}. Mend the path; it is relative to the TOML file.")
    try:
        meshio = import_module("meshio")
    except ImportError as error:
        raise InputError(
            f"reading meshes needs meshio, which cannot be loaded ({error}). Install it with: pip install '.[preprocessing]'."
        ) from error
    said = StringIO()
    try:
        with redirect_stdout(said), redirect_stderr(said):
            return meshio.read(path, file_format="gmsh" if path.suffix == ".msh" else None)  # not that of ANSYS Fluent
    except (meshio.ReadError, *FAILURES) as error:
        reason = " ".join(f"{said.getvalue()} {error}".split())
        raise InputError(
            f"the mesh file {str(path)!r} cannot be read by meshio ({reason}). Export it again, for example as gmsh .msh or Abaqus .inp."
        ) from error


def _refuse_kinds(path: Path, kinds: list[str]) -> None:
    spatial = sorted({kind for kind in kinds if kind.startswith(SOLID)})
    if spatial:
        raise InputError(
            f"the mesh {str(path)!r} is spatial (it holds {', '.join(spatial)}), but bodies move in the plane here. Give a mesh of "
            "triangles or quadrilaterals of the section in the plane; its width is a number of [section]."
        )
    foreign = sorted(set(kinds) - {*PLANE, *LOWER})
    if foreign or not set(kinds) & set(PLANE):
        what = f"elements of the kinds {', '.join(foreign)}" if foreign else "no triangles and no quadrilaterals"
        raise InputError(f"the mesh {str(path)!r} holds {what}; possible are {', '.join(PLANE)}. Mesh the surface with these.")


def _plane(path: Path, points: np.ndarray) -> np.ndarray:
    """x and y of points whose z is the same."""
    if not np.all(np.isfinite(points)):
        raise InputError(f"the mesh {str(path)!r} holds coordinates that are not finite numbers. Export it again.")
    if points.shape[1] > 2 and np.ptp(points[:, 2]) > FLAT * np.ptp(points[:, :2]):
        raise InputError(
            f"the mesh {str(path)!r} is spatial: its z reaches from {points[:, 2].min():g} to {points[:, 2].max():g}, but bodies move in "
            "the plane here. Give a mesh in the plane of x and y."
        )
    return points[:, :2]


def _groups(raw: Any) -> Iterator[tuple[str, np.ndarray]]:
    """Names and nodes of node sets, element sets and physical groups."""
    yield from ((name, np.asarray(members, int)) for name, members in raw.point_sets.items())
    for name, sets in raw.cell_sets.items():
        if name not in raw.point_sets and not name.startswith("gmsh:"):
            of = zip(raw.cells, sets, strict=True)
            yield name, _nodes([block.data[np.asarray(own, int)] for block, own in of if own is not None])
    for name, (tag, dimension) in raw.field_data.items():  # gmsh 2.2
        tags = raw.cell_data.get("gmsh:physical")
        if tags is not None and name not in raw.cell_sets:
            of = zip(raw.cells, tags, strict=True)
            yield name, _nodes([block.data[np.asarray(own) == tag] for block, own in of if block.dim == dimension])


def _nodes(elements: list[np.ndarray]) -> np.ndarray:
    """Numbers of the nodes of elements."""
    return np.unique(np.concatenate([np.zeros(0, int), *(np.ravel(each) for each in elements)])).astype(int)
