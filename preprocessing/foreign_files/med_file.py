"""MED files of Salome and Code_Aster: HDF5 with one mesh, whose families of nodes and elements make its groups."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import h5py
import numpy as np

from preprocessing.foreign_files.contents import Elements, MeshContents, refuse_leave_out, wrong_file
from toolkit.foundation.errors import InputError

REMEDY = "Export the mesh again as MED from Salome, or as gmsh .msh."
KINDS = {
    "PO1": ("vertex", 1), "SE2": ("line", 2), "SE3": ("line3", 3), "TR3": ("triangle", 3), "TR6": ("triangle6", 6), "QU4": ("quad", 4),
    "QU8": ("quad8", 8), "QU9": ("quad9", 9), "TE4": ("tetra", 4), "T10": ("tetra10", 10), "HE8": ("hexahedron", 8),
    "H20": ("hexahedron20", 20), "H27": ("hexahedron27", 27), "PE6": ("wedge", 6), "P15": ("wedge15", 15), "PY5": ("pyramid", 5),
    "P13": ("pyramid13", 13),
}  # fmt: skip
"""Name of elements in MED -> kind in the words of meshio, and its number of nodes."""
BRICK = [*range(20), 24, 22, 21, 23, 20, 25, 26]
"""Place in MED of every node of a brick of 27, whose faces it numbers from the bottom round to the top."""
OTHERS = ("SE4", "TR7", "OCT", "P18", "POG", "PO2", "POE", "SUP")
"""Elements of MED that are not read: cubic ones, those with more nodes, polygons and polyhedra."""


def med_mesh(path: Path, leave_out: frozenset[str]) -> MeshContents:
    """Nodes, elements and groups of a MED file.

    Raises
    ------
    InputError
        It is no MED file, holds several meshes or states of one, a structured one, other coordinates than Cartesian ones, or elements
        that are none here.
    """
    refuse_leave_out(path, leave_out, "elements of lower dimension name groups only")
    try:
        with h5py.File(path, "r") as file:
            return _mesh(path, file)
    except (OSError, KeyError, ValueError, TypeError, RuntimeError, AttributeError) as error:
        if isinstance(error, InputError):
            raise
        raise wrong_file(path, "it is no MED file, or damaged", REMEDY) from error


def _mesh(path: Path, file: h5py.File) -> MeshContents:
    whole, name = _only(path, _inside(path, file, "ENS_MAA"), "mesh")
    if int(whole.attrs.get("TYP", 0)) != 0 or int(whole.attrs.get("REP", 0)) != 0:
        raise wrong_file(path, "its mesh is structured, or in cylindrical or spherical coordinates", REMEDY)
    mesh = whole if "NOE" in whole else _only(path, whole, "state of the mesh")[0]
    nodes = _inside(path, mesh, "NOE")
    points = _array(path, nodes, "COO").astype(float).reshape(int(whole.attrs["ESP"]), -1).T
    cells: Elements = []
    families: list[np.ndarray] = []
    for kind, block, tags in _elements(path, _inside(path, mesh, "MAI")):
        cells.append((kind, block))
        families.append(tags)
    groups: dict[str, Elements] = {}
    every = file["FAS"][name] if "FAS" in file and name in file["FAS"] else {}
    for group, numbers in _groups(path, every, "ELEME").items():
        groups[group] = [
            (kind, block[own]) for (kind, block), of in zip(cells, families, strict=True) if (own := np.isin(of, numbers)).any()
        ]
    node_tags = _array(path, nodes, "FAM") if "FAM" in nodes else np.zeros(len(points), np.int64)
    for group, numbers in _groups(path, every, "NOEUD").items():
        groups.setdefault(group, []).append(("vertex", np.flatnonzero(np.isin(node_tags, numbers))[:, None]))
    labels = _array(path, nodes, "NUM").astype(np.int64) if "NUM" in nodes else np.zeros(0, np.int64)
    return MeshContents(points, cells, list(groups.items()), labels, remarks=_units(whole))


def _inside(path: Path, group: h5py.Group, name: str) -> h5py.Group | h5py.Dataset:
    """Member of a group in the file, refused if it is a link to another file."""
    if isinstance(group.get(name, getlink=True), h5py.ExternalLink):
        raise wrong_file(path, "it takes its numbers from another file", REMEDY)
    if name not in group:
        raise wrong_file(path, f"it has no {name}, so that it is no MED file or not whole", REMEDY)
    return group[name]


def _array(path: Path, group: h5py.Group, name: str) -> np.ndarray:
    """Numbers of a data set of this file."""
    found = _inside(path, group, name)
    if found.external or found.is_virtual or found.dtype.kind not in "iuf":
        raise wrong_file(path, "it takes its numbers from another file, or has others than numbers", REMEDY)
    return np.asarray(found[()])


def _only(path: Path, group: h5py.Group, what: str) -> tuple[h5py.Group, str]:
    """Single member of a group, and its name."""
    names = list(group)
    if len(names) != 1:
        raise wrong_file(path, f"it holds {len(names)} times a {what} instead of one", "Export one mesh without results.")
    return _inside(path, group, names[0]), names[0]


def _elements(path: Path, group: h5py.Group) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Kind, nodes and families of elements."""
    for name in group:
        if name not in KINDS:
            which = name if name in OTHERS else "a kind that is not known"
            raise wrong_file(path, f"it holds elements of {which}, which are none here", "Mesh the body with other elements.")
        block = _inside(path, group, name)
        kind, n = KINDS[name]
        nodes = _array(path, block, "NOD").astype(np.int64).reshape(n, -1).T - 1
        if nodes.shape[0] != int(_inside(path, block, "NOD").attrs.get("NBR", nodes.shape[0])):
            raise wrong_file(path, f"it has not as many elements {name} as it says", REMEDY)
        tags = _array(path, block, "FAM").astype(np.int64) if "FAM" in block else np.zeros(len(nodes), np.int64)
        if len(tags) != len(nodes):
            raise wrong_file(path, f"elements {name} are without their families", REMEDY)
        yield kind, nodes[:, BRICK] if n == 27 else nodes, tags


def _groups(path: Path, families: Mapping[str, h5py.Group], which: str) -> dict[str, list[int]]:
    """Name of each group -> numbers of the families that are in it, of elements (ELEME) or of nodes (NOEUD)."""
    found: dict[str, list[int]] = {}
    of_kind = families.get(which, {})
    for name in of_kind:
        family = _inside(path, of_kind, name)
        if "GRO" in family:
            for row in _inside(path, family["GRO"], "NOM")[()]:
                text = (
                    bytes(np.asarray(row).astype(np.uint8).tolist()).split(b"\0")[0].strip().decode("utf-8", "backslashreplace")
                )
                found.setdefault(text, []).append(int(family.attrs["NUM"]))
    return found


def _units(mesh: h5py.Group) -> list[str]:
    """Remark that the file names a unit of lengths, whose name is text of its own."""
    text = mesh.attrs.get("UNI", b"")
    named = text.strip(b"\0 ") if isinstance(text, bytes) else b""
    known = {b"m": "m", b"mm": "mm", b"cm": "cm"}.get(named[:16].strip())
    return [f"The file gives lengths in {known}."] if known else []
