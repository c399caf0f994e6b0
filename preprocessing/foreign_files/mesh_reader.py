"""Which reader reads a mesh file, by its ending; meshio reads the formats that have no reader here."""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Callable, Iterator
from contextlib import redirect_stderr, redirect_stdout
from importlib import import_module
from io import StringIO
from pathlib import Path

import meshio
import numpy as np
import numpy.typing as npt
from meshio._mesh import topological_dimension

from preprocessing.foreign_files.child import LARGEST_FILE
from preprocessing.foreign_files.contents import KNOWN, Elements, MeshContents, refuse_leave_out, wrong_file
from preprocessing.foreign_files.wire import Sent
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.safe_files import read_start, read_whole

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


MEDIT = rb"^[ \t]*(?:Edges|Triangles|Quadrilaterals|Tetrahedra|Pyramids|Prisms|Pentahedra|Hexahedra|Hexaedra)\s+(\d{1,18})"
NETGEN = rb"^[ \t]*(?:pointelements|edgesegments\w*|surfaceelements\w*|volumeelements)[ \t\r]*\n\s*(\d{1,18})"
Counts = tuple[int | None, int | None]
"""Nodes and elements; None where the file does not say it."""


def _sums(nodes: bytes, elements: bytes) -> Callable[[Path], Counts]:
    """Sums of all numbers that stand behind certain words."""

    def count(path: Path) -> Counts:
        content = read_whole(path, LARGEST_FILE)
        found = [re.findall(each, content, re.MULTILINE | re.IGNORECASE) for each in (nodes, elements)]
        sums = [sum(map(int, each)) if each else None for each in found]
        return sums[0], sums[1]

    return count


def _first_line(path: Path, columns: tuple[int, ...]) -> list[int] | None:
    """Numbers of the first line that is no comment, at the given places."""
    for line in read_whole(path, LARGEST_FILE).split(b"\n"):
        words = line.partition(b"#")[0].split()
        if words:
            wanted = [words[k] for k in columns if k < len(words)]
            return [int(word) for word in wanted] if all(word.isdigit() and len(word) < 19 for word in wanted) else None
    return None


def _avs(path: Path) -> Counts:
    found = _first_line(path, (0, 1))
    return (found[0], found[1]) if found and len(found) == 2 else (None, None)


def _tetgen(path: Path) -> Counts:
    nodes, elements = (_first_line(path.with_suffix(ending), (0,)) for ending in (".node", ".ele"))
    return nodes[0] if nodes else None, elements[0] if elements else None


def _ugrid(path: Path) -> Counts:
    """Numbers of nodes, and of elements of six kinds, from the seven numbers at the beginning of a text."""
    words = read_start(path, 200).split()[:7] if len(path.suffixes) < 2 else []
    if len(words) < 7 or not all(word.isdigit() for word in words):
        return None, None
    return int(words[0]), sum(map(int, words[1:]))


def _dolfin(path: Path) -> Counts:
    """Numbers of nodes and elements, counted in the lists.

    meshio makes room for as many as the lists say, and leaves it as it was where one is missing.
    """
    content = read_whole(path, LARGEST_FILE)
    entries = (rb"<vertex\s", rb"<(?:interval|triangle|tetrahedron|quadrilateral|hexahedron)\s")
    nodes, elements = (len(re.findall(each, content)) for each in entries)
    return nodes, elements


STATED: dict[str, Callable[[Path], Counts]] = {
    ".su2": _sums(rb"^[ \t]*NPOIN[ \t]*=[ \t]*(\d{1,18})", rb"^[ \t]*(?:NELEM|MARKER_ELEMS)[ \t]*=[ \t]*(\d{1,18})"),
    ".mesh": _sums(rb"^[ \t]*Vertices\s+(\d{1,18})", MEDIT),
    ".vol": _sums(rb"^[ \t]*points[ \t\r]*\n\s*(\d{1,18})", NETGEN),
    ".dat": _sums(rb"\b(?:NODES|N)[ \t]*=[ \t]*(\d{1,18})", rb"\b(?:ELEMENTS|E)[ \t]*=[ \t]*(\d{1,18})"),
    ".xml": _dolfin,
    ".xdmf": _sums(rb"(?!)", rb"<Topology[^>]*NumberOfElements=[\"'](\d{1,18})[\"']"),
    ".avs": _avs,
    ".ele": _tetgen,
    ".node": _tetgen,
    ".ugrid": _ugrid,
}
"""Ending of a file -> what it says."""
STATED |= {".tec": STATED[".dat"], ".xmf": STATED[".xdmf"]}


def stated_counts(path: Path) -> Counts:
    """Nodes and elements that a file says it holds; None where its format does not say so."""
    count = STATED.get(path.suffix.lower())
    return count(path) if count else (None, None)


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


def _read(path: str, file_format: str | None) -> tuple[meshio.Mesh, str]:
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


def _counted(path: Path, raw: meshio.Mesh) -> list[str]:
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


def _nodes(kind: str, data: npt.ArrayLike) -> np.ndarray:
    return np.asarray(data, np.int64) if kind in KNOWN else np.zeros((0, 0), np.int64)


def _text(name: object) -> str:
    """Name with characters that can be printed."""
    return str(name).encode("utf-8", "replace").decode()


def _groups(raw: meshio.Mesh) -> Iterator[tuple[str, Elements]]:
    """Names and elements of node sets, element sets and physical groups."""
    yield from ((name, [("vertex", np.asarray(members, np.int64)[:, None])]) for name, members in raw.point_sets.items())
    for name, sets in raw.cell_sets.items():
        if name not in raw.point_sets and not name.startswith("gmsh:"):
            of = zip(raw.cells, sets, strict=True)
            here = [(block, np.asarray(own, int)) for block, own in of if own is not None]
            yield name, [(block.type, _nodes(block.type, block.data)[own]) for block, own in here if block.type in KNOWN]


READERS: dict[str, tuple[str, str]] = {
    ".inp": ("preprocessing.foreign_files.abaqus.reader", "read_deck"),
    **dict.fromkeys((".bdf", ".nas", ".fem", ".blk"), ("preprocessing.foreign_files.nastran.bulk_file", "read_bulk")),
    ".msh": ("preprocessing.foreign_files.gmsh_mesh", "gmsh_mesh"),
    ".vtk": ("preprocessing.foreign_files.vtk_legacy", "legacy_vtk"),
    ".vtu": ("preprocessing.foreign_files.vtk_xml", "xml_vtk"),
    ".unv": ("preprocessing.foreign_files.universal_file", "universal_mesh"),
    ".cdb": ("preprocessing.foreign_files.ansys_archive", "ansys_mesh"),
    ".med": ("preprocessing.foreign_files.med_file", "med_mesh"),
}
"""Ending -> module of a reader of its own, and its function of a path and of what is to be left out, which returns `MeshContents`."""


def mesh_contents(path: str, leave_out: str = "[]") -> dict[str, Sent]:
    """Record of a mesh file's contents; `leave_out` is a list in JSON: names of element types, keywords and cards."""
    file, names = Path(path), frozenset(name.strip().lstrip("*").upper() for name in json.loads(leave_out))
    if (ending := file.suffix.lower()) in READERS:
        module, function = READERS[ending]
        return getattr(import_module(module), function)(file, names).sent()
    refuse_format(file)
    refuse_leave_out(file, names, "elements of lower dimension name groups only")

    known_ending(file)
    return any_mesh(path).sent()
