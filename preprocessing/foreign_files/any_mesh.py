"""Meshes of all formats that have no reader of their own here, as meshio reads them, and counted against what their files say."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import meshio
import numpy as np
from meshio._mesh import topological_dimension

from preprocessing.foreign_files.contents import Elements, MeshContents
from preprocessing.foreign_files.element_kinds import KNOWN
from preprocessing.foreign_files.meshes.refused_formats import INSTEAD
from preprocessing.foreign_files.meshes.stated_counts import stated_counts
from preprocessing.foreign_files.meshes.wrong_file import wrong_file
from toolkit.foundation.errors import InputError

REMEDY = "Export the mesh as gmsh .msh, VTK .vtu or Abaqus .inp."
HARMLESS = {"tags of string type": "Names of markers of SU2 are not read: choose nodes by boxes, or export gmsh .msh."}
"""Remark on each warning of meshio about something that the body does without."""

LACKING = {"wedge15": 3, "pyramid13": 3, "hexahedron24": 3}
"""Dimension of the kinds that meshio 5.3.5 has no dimension of."""


def any_mesh(path: str, file_format: str | None = None) -> MeshContents:
    """Contents of a mesh file that are used; of elements that never are, only the kind.

    Raises
    ------
    InputError
        meshio warns of something that it leaves out, or returns more or fewer nodes or elements than the file says that it holds.
    """
    complete_kinds()
    raw, said = _read(path, file_format)
    remarks = [remark for words, remark in HARMLESS.items() if words in said]
    if said.count("Warning") > sum(map(said.count, HARMLESS)):
        raise wrong_file(Path(path), "meshio warns that it leaves out something of it", REMEDY)
    remarks += _counted(Path(path), raw)
    return MeshContents(
        points=np.asarray(raw.points, float),
        cells=[(block.type, _nodes(block.type, block.data)) for block in raw.cells],
        groups=[(_text(name), elements) for name, elements in _groups(raw)],
        remarks=remarks,
    )


def complete_kinds() -> None:
    """Tell meshio the dimension of kinds that its readers make, but its meshes refuse with a KeyError."""
    topological_dimension.update(LACKING)


def known_ending(path: Path) -> None:
    """Refuse a file whose ending meshio does not know; raises InputError."""
    endings = meshio.extension_to_filetypes
    if not any("".join(path.suffixes[k:]).lower() in endings for k in range(len(path.suffixes))):
        raise InputError(f"the mesh {str(path)!r} has an ending that no format of meshes has here. {INSTEAD}")


def _read(path: str, file_format: str | None) -> tuple[Any, str]:
    """Mesh that meshio reads, and what it prints meanwhile instead of raising errors."""
    heard = StringIO()
    with redirect_stdout(heard), redirect_stderr(heard), warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        try:
            raw = meshio.read(path, file_format=file_format)
        except (SystemExit, KeyError) as error:
            what = (
                "meshio reads no mesh in it: it is not whole, or holds a section or a kind of elements that meshio does not know"
            )
            raise wrong_file(Path(path), what, REMEDY) from error
    numbers = [each for each in warned if issubclass(each.category, (RuntimeWarning, UserWarning))]
    return raw, " ".join(heard.getvalue().split()) + " Warning" * len(numbers)


def _counted(path: Path, raw: Any) -> list[str]:
    """Compare numbers of nodes and elements with what the file says; a remark if it says nothing."""
    stated = stated_counts(path)
    read = len(raw.points), sum(len(block.data) for block in raw.cells)
    for what, said, here in zip(("nodes", "elements"), stated, read, strict=True):
        if said is not None and said != here:
            raise wrong_file(path, f"meshio reads {here} {what} of it, and it says that it holds others", REMEDY)
    if stated[1] is None:
        return [
            "The number of elements was not checked, as this format does not state it: compare the mass with that of your program."
        ]
    return []


def _nodes(kind: str, data: Any) -> np.ndarray:
    return np.asarray(data, np.int64) if kind in KNOWN else np.zeros((0, 0), np.int64)


def _text(name: Any) -> str:
    """Name with characters that can be printed."""
    return str(name).encode("utf-8", "replace").decode()


def _groups(raw: Any) -> Iterator[tuple[str, Elements]]:
    """Names and elements of node sets, element sets and physical groups."""
    yield from ((name, [("vertex", np.asarray(members, np.int64)[:, None])]) for name, members in raw.point_sets.items())
    for name, sets in raw.cell_sets.items():
        if name not in raw.point_sets and not name.startswith("gmsh:"):
            of = zip(raw.cells, sets, strict=True)
            here = [(block, np.asarray(own, int)) for block, own in of if own is not None]
            yield name, [(block.type, _nodes(block.type, block.data)[own]) for block, own in here if block.type in KNOWN]
