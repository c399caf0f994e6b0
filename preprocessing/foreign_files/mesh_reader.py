"""Which reader reads a mesh file: by its ending."""

from __future__ import annotations

import json
from importlib import import_module
from pathlib import Path
from typing import Any

from preprocessing.foreign_files.meshes.refused_formats import refuse_format
from preprocessing.foreign_files.meshes.wrong_file import refuse_leave_out

READERS: dict[str, tuple[str, str]] = {
    ".inp": ("preprocessing.foreign_files.abaqus.reader", "read_deck"),
    **dict.fromkeys((".bdf", ".nas", ".fem", ".blk"), ("preprocessing.foreign_files.nastran.bulk_file", "read_bulk")),
    ".msh": ("preprocessing.foreign_files.gmsh.gmsh_mesh", "gmsh_mesh"),
    ".vtk": ("preprocessing.foreign_files.vtk.legacy", "legacy_vtk"),
    ".vtu": ("preprocessing.foreign_files.vtk.xml", "xml_vtk"),
    ".unv": ("preprocessing.foreign_files.meshes.universal_file", "universal_mesh"),
    ".cdb": ("preprocessing.foreign_files.meshes.ansys_archive", "ansys_mesh"),
    ".med": ("preprocessing.foreign_files.meshes.med_file", "med_mesh"),
}
"""Ending -> module of a reader of its own, and its function of a path and of what is to be left out, which returns `MeshContents`."""


def mesh_contents(path: str, leave_out: str = "[]") -> dict[str, Any]:
    """Record of a mesh file's contents; `leave_out` is a list in JSON: names of element types, keywords and cards."""
    file, names = Path(path), frozenset(name.strip().lstrip("*").upper() for name in json.loads(leave_out))
    if (ending := file.suffix.lower()) in READERS:
        module, function = READERS[ending]
        return getattr(import_module(module), function)(file, names).sent()
    refuse_format(file)
    refuse_leave_out(file, names, "elements of lower dimension name groups only")
    from preprocessing.foreign_files.any_mesh import any_mesh, known_ending

    known_ending(file)
    return any_mesh(path).sent()
