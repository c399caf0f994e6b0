"""The readers of VTK's two formats: all ways of writing numbers, cells that VTK orders otherwise, and cells that are refused."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

from preprocessing.foreign_files.contents import MeshContents
from preprocessing.foreign_files.vtk_legacy import legacy_vtk
from preprocessing.foreign_files.vtk_xml import xml_vtk
from tests.foreign_meshes.sizes import size
from tests.models.solid_bodies import box, rectangle
from toolkit.foundation.errors import InputError

CUBE = "0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1"
"""Corners as a voxel counts them."""
HEAD = "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET UNSTRUCTURED_GRID\n"


def legacy(folder: Path, cells: str, types: str, points: str = CUBE) -> MeshContents:
    rows, numbers = cells.split("; "), types.split()
    count = sum(len(row.split()) for row in rows)
    text = f"{HEAD}POINTS {len(points.split()) // 3} double\n{points}\nCELLS {len(rows)} {count}\n" + "\n".join(rows)
    (folder / "body.vtk").write_text(f"{text}\nCELL_TYPES {len(numbers)}\n" + "\n".join(numbers) + "\n")
    return legacy_vtk(folder / "body.vtk", frozenset())


def test_voxels_and_pixels_become_hexahedra_and_quadrilaterals(tmp_path):
    found = legacy(tmp_path, "8 0 1 2 3 4 5 6 7; 4 0 1 2 3", "11 8")
    assert {kind: nodes.tolist() for kind, nodes in found.cells} == {
        "hexahedron": [[0, 1, 3, 2, 4, 5, 7, 6]],
        "quad": [[0, 1, 3, 2]],
    }
    assert size(found.points, dict(found.cells[1:])) == pytest.approx(1.0)


REFUSED = {
    "4 0 1 2 3; 2": "VTK_POLY_VERTEX", "4 0 1 2 3; 4": "VTK_POLY_LINE", "4 0 1 2 3; 6": "VTK_TRIANGLE_STRIP", "4 0 1 3 2; 7": "VTK_POLYGON",
    "8 0 1 2 3 4 5 6 7; 42": "VTK_POLYHEDRON", "8 0 1 3 2 4 5 7 6; 72": "VTK_LAGRANGE_HEXAHEDRON",
    "1 0; 99": "a type that VTK does not list",
}  # fmt: skip


@pytest.mark.parametrize("cell", REFUSED)
def test_cells_that_are_no_elements_are_refused_by_name(tmp_path, cell):
    nodes, number = cell.split("; ")
    with pytest.raises(InputError, match=f"1 of its cells are {REFUSED[cell]}, which is no element here"):
        legacy(tmp_path, f"8 0 1 2 3 4 5 6 7; {nodes}", f"11 {number}")


WRONG = {
    "too few nodes": (("7 0 1 2 3 4 5 6", "11"), "a cell of type 11 has not the 8 nodes of its type"),
    "a type too many": (("8 0 1 2 3 4 5 6 7", "11 11"), "cells, types and nodes contradict each other"),
    "a word": (("8 0 1 2 3 4 5 6 x", "11"), "line 8: a word is no number|line 8: there are more or fewer numbers"),
    "half a node": (("8 0 1 2 3 4 5 6 7.5", "11"), "other numbers than whole ones"),
    "a negative count": (("-8 0 1 2 3 4 5 6 7", "11"), "CELLS has not as many cells as it says"),
}


@pytest.mark.parametrize("kind", WRONG)
def test_cells_that_contradict_themselves_are_refused(tmp_path, kind):
    cells, message = WRONG[kind]
    with pytest.raises(InputError, match=message):
        legacy(tmp_path, *cells)


HEADERS = {
    "POLYDATA": "its DATASET is none of UNSTRUCTURED_GRID",
    "UNSTRUCTURED_GRID\nPOINTS 999999999999 double\n0": "more or fewer numbers",
    "UNSTRUCTURED_GRID\nPOINTS 1 double\n0 0 0\nSTRANGE 1": "line 7: a section is none of VTK's",
    "UNSTRUCTURED_GRID\nPOINTS 1 double\n0 0 0": "it has no CELLS",
    "STRUCTURED_POINTS\nDIMENSIONS 9999999 999999 99999\nORIGIN 0 0 0\n": "it has no SPACING",
}


@pytest.mark.parametrize("text", HEADERS)
def test_grids_that_are_none_are_refused(tmp_path, text):
    (tmp_path / "body.vtk").write_text(f"# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET {text}\n")
    with pytest.raises(InputError, match=HEADERS[text]):
        legacy_vtk(tmp_path / "body.vtk", frozenset())


def test_ghost_cells_are_refused(tmp_path):
    legacy(tmp_path, "8 0 1 2 3 4 5 6 7", "11")
    with (tmp_path / "body.vtk").open("a") as file:
        file.write("CELL_DATA 1\nFIELD FieldData 1\nvtkGhostType 1 1 unsigned_char\n1\n")
    with pytest.raises(InputError, match="marks cells as ghosts"):
        legacy_vtk(tmp_path / "body.vtk", frozenset())


GRIDS = {
    "STRUCTURED_POINTS\nDIMENSIONS 3 2 2\nORIGIN 1 0 0\nSPACING 0.5 1 2": 2.0,
    "RECTILINEAR_GRID\nDIMENSIONS 3 2 2\nX_COORDINATES 3 float\n0 1 4\nY_COORDINATES 2 float\n0 1\nZ_COORDINATES 2 float\n0 2": 8.0,
    f"STRUCTURED_GRID\nDIMENSIONS 2 2 2\nPOINTS 8 float\n{CUBE}": 1.0,
}


@pytest.mark.parametrize("text", GRIDS)
def test_grids_whose_cells_are_not_listed_have_the_volume_of_their_box(tmp_path, text):
    (tmp_path / "body.vtk").write_text(f"# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET {text}\n")
    found = legacy_vtk(tmp_path / "body.vtk", frozenset())
    assert size(found.points, dict(found.cells)) == pytest.approx(GRIDS[text])


WRITTEN = {
    "5.1 text": ("vtk", {"binary": False, "file_format": "vtk"}),
    "5.1": ("vtk", {"file_format": "vtk"}),
    "4.2 text": ("vtk", {"binary": False, "file_format": "vtk42"}),
    "4.2": ("vtk", {"file_format": "vtk42"}),
    "xml text": ("vtu", {"binary": False}),
    "xml": ("vtu", {}),
    "xml uncompressed": ("vtu", {"compression": None}),
    "xml lzma": ("vtu", {"compression": "lzma"}),
}
"""What meshio writes."""


@pytest.mark.parametrize("name", WRITTEN)
@pytest.mark.parametrize("kind", ["triangle", "quad8", "tetra10", "hexahedron", "wedge"])
def test_what_meshio_writes_is_read_as_it_was(tmp_path, name, kind):
    ending, options = WRITTEN[name]
    solid = rectangle(kind, (3, 2), 1.0, 0.4) if kind in ("triangle", "quad8") else box(kind, (2, 1, 1), (1.0, 0.4, 0.4))
    points = np.column_stack([solid.nodes, np.zeros((len(solid.nodes), 3 - solid.dimension))])
    meshio.write(tmp_path / f"body.{ending}", meshio.Mesh(points, [(kind, solid.blocks[kind])]), **options)
    found = (legacy_vtk if ending == "vtk" else xml_vtk)(tmp_path / f"body.{ending}", frozenset())
    np.testing.assert_allclose(found.points, points, rtol=1e-11, atol=0)  # meshio writes twelve digits into text
    assert [(each, nodes.tolist()) for each, nodes in found.cells] == [(kind, solid.blocks[kind].tolist())]


XML = """<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"{file}><UnstructuredGrid>
<Piece NumberOfPoints="3" NumberOfCells="1"><Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">{points}
</DataArray></Points><Cells><DataArray type="Int64" Name="connectivity" format="ascii">{nodes}</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">3</DataArray><DataArray type="UInt8" Name="types" format="{form}">{types}
</DataArray></Cells>{data}</Piece></UnstructuredGrid>{more}</VTKFile>"""
GOOD = {"file": "", "points": "0 0 0 1 0 0 0 1 0", "nodes": "0 1 2", "form": "ascii", "types": "5", "data": "", "more": ""}
WRONG_XML = {
    "another type": ({"types": "7"}, "VTK_POLYGON"),
    "a node that is not there": ({"nodes": "0 1 3"}, "a node that its Piece does not hold"),
    "points missing": ({"points": "0 0 0 1 0 0"}, "more or fewer numbers than its Piece says"),
    "a word": ({"points": "0 0 0 1 0 0 0 1 x"}, "a word is no number"),
    "no base64": ({"form": "binary", "types": "%%%%"}, "claims more bytes|not in base64"),
    "more bytes than there are": ({"form": "binary", "types": "////fwU="}, "claims more bytes than there are"),
    "unknown compression": (
        {"file": ' compressor="vtkLZ4DataCompressor"', "form": "binary", "types": "AQAAAAU="},
        "compressed otherwise than by ZLib or LZMA",
    ),
    "a damaged block": (
        {"file": ' compressor="vtkZLibDataCompressor"', "form": "binary", "types": "AQAAAAEAAAABAAAAAQAAAA==BQ=="},
        "a compressed array is damaged",
    ),
    "no array behind": ({"form": "appended"}, "no offset within AppendedData"),
    "cut off": ({"more": "<"}, "it is no XML, or not whole"),
    "ghosts": (
        {"data": '<CellData><DataArray type="UInt8" Name="vtkGhostType" format="ascii">1</DataArray></CellData>'},
        "marks cells as ghosts",
    ),
}


def xml(folder: Path, **changed: str) -> MeshContents:
    (folder / "body.vtu").write_text(XML.format(**{**GOOD, **changed}))
    return xml_vtk(folder / "body.vtu", frozenset())


@pytest.mark.parametrize("kind", WRONG_XML)
def test_xml_that_contradicts_itself_is_refused(tmp_path, kind):
    changed, message = WRONG_XML[kind]
    assert [nodes.tolist() for _, nodes in xml(tmp_path).cells] == [[[0, 1, 2]]]
    with pytest.raises(InputError, match=message):
        xml(tmp_path, **changed)


def test_pieces_are_one_mesh(tmp_path):
    text = XML.format(**GOOD)
    piece = text[text.index("<Piece") : text.index("</UnstructuredGrid>")]
    (tmp_path / "body.vtu").write_text(text.replace(piece, piece * 2))
    found = xml_vtk(tmp_path / "body.vtu", frozenset())
    assert [nodes.tolist() for _, nodes in found.cells] == [[[0, 1, 2]], [[3, 4, 5]]]
    assert len(found.points) == 6


def test_numbers_behind_the_xml_are_read(tmp_path):
    """In base64 and as they are, each behind its number of bytes."""
    vtk = pytest.importorskip("vtkmodules.vtkIOXML")
    legacy(tmp_path, "8 0 1 2 3 4 5 6 7", "11")
    from vtkmodules.vtkIOLegacy import vtkUnstructuredGridReader

    reader = vtkUnstructuredGridReader()
    reader.SetFileName(str(tmp_path / "body.vtk"))
    reader.Update()
    for encoded in (0, 1):
        for compressor in ("None", "ZLib", "LZMA"):
            writer = vtk.vtkXMLUnstructuredGridWriter()
            writer.SetInputData(reader.GetOutput())
            writer.SetFileName(str(tmp_path / "body.vtu"))
            writer.SetDataModeToAppended()
            writer.SetEncodeAppendedData(encoded)
            getattr(writer, f"SetCompressorTypeTo{compressor}")()
            writer.SetBlockSize(64)
            writer.Write()
            found = xml_vtk(tmp_path / "body.vtu", frozenset())
            assert size(found.points, dict(found.cells)) == pytest.approx(1.0)
