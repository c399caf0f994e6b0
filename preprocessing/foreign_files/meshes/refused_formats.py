"""Formats that hold no mesh of a body, or none that is read here, by their endings."""

from __future__ import annotations

from pathlib import Path

from toolkit.foundation.errors import InputError

SURFACES = {
    ".stl": "STL", ".off": "OFF", ".ply": "PLY", ".ply2": "PLY2", ".obj": "Wavefront OBJ", ".wrl": "VRML", ".x3d": "X3D", ".wkt": "WKT",
    ".svg": "SVG", ".vtp": "VTK PolyData", ".3mf": "3MF", ".amf": "AMF", ".glb": "glTF", ".gltf": "glTF",
}  # fmt: skip
"""Ending -> format of surfaces, whose triangles are no elements: bodies of the plane are often cut or written in part there."""
GEOMETRIES = {
    ".step": "STEP",
    ".stp": "STEP",
    ".iges": "IGES",
    ".igs": "IGES",
    ".brep": "BREP",
    ".geo": "a script of gmsh",
    ".x_t": "Parasolid",
}
"""Ending -> format of shapes without a mesh."""
UNREAD = {
    ".celum_f": "CELUM", ".celum_s": "CELUM", ".diff": "Diffpack", ".ir3": "Iridium", ".key": "LS-DYNA", ".k": "LS-DYNA", ".m": "MATLAB",
    ".mail": "Code_Aster's text", ".neu": "Gambit", ".p3d": "Plot3D", ".pos": "views of gmsh", ".rad": "Radioss", ".pvtu": "parallel VTK",
    ".vtm": "multi-block VTK", ".vti": "VTK ImageData", ".vtr": "VTK RectilinearGrid", ".vts": "VTK StructuredGrid",
    ".frd": "results of CalculiX",
    ".odb": "results of Abaqus", ".op2": "results of Nastran", ".rst": "results of Ansys", ".hm": "HyperMesh", ".mphtxt": "COMSOL",
}  # fmt: skip
"""Ending -> format that is not read."""
INSTEAD = "Export the elements of the body as gmsh .msh, Abaqus .inp, Nastran .bdf, Ansys .cdb, universal file .unv, MED .med or VTK .vtu."


def refuse_format(path: Path) -> None:
    """Refuse a file by its ending, with the reason.

    Raises
    ------
    InputError
        Files of this ending hold surfaces, shapes or what no reader knows.
    """
    ending = path.suffix.lower()
    for formats, why in (
        (SURFACES, "which holds surfaces, not the elements of a body"),
        (GEOMETRIES, "which holds shapes, not a mesh"),
        (UNREAD, "which is not read"),
    ):
        if ending in formats:
            raise InputError(f"the mesh {str(path)!r} is in the format {formats[ending]}, {why}. {INSTEAD}")
