"""MED on small changes of a file of gmsh, and formats that meshio reads: counted, and its warnings heard."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import h5py
import meshio
import pytest

from preprocessing.foreign_files.med_file import med_mesh
from preprocessing.foreign_files.mesh_reader import any_mesh, stated_counts
from preprocessing.mesh.mesh_file import read_mesh
from tests.foreign_meshes.gmsh_files import meshed, written
from toolkit.foundation.errors import InputError


@pytest.fixture(scope="module")
def med(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    with meshed("hexahedron") as (gmsh, _):
        return written(gmsh, tmp_path_factory.mktemp("med") / "body.med").read_bytes()


def inside(file: h5py.File) -> h5py.Group:
    """Where nodes and elements stand."""
    mesh = next(iter(file["ENS_MAA"].values()))
    return next(iter(mesh.values()))


def cylindrical(file: h5py.File) -> None:
    next(iter(file["ENS_MAA"].values())).attrs["REP"] = 1


def second(file: h5py.File) -> None:
    file["ENS_MAA"].copy(next(iter(file["ENS_MAA"].values())), "other")


def polyhedra(file: h5py.File) -> None:
    inside(file)["MAI"].move("HE8", "POE")


def elsewhere(file: h5py.File) -> None:
    del inside(file)["NOE"]["COO"]
    inside(file)["NOE"]["COO"] = h5py.ExternalLink("other.h5", "/numbers")


def fewer(file: h5py.File) -> None:
    inside(file)["MAI"]["HE8"]["NOD"].attrs["NBR"] = 3


def no_nodes(file: h5py.File) -> None:
    del inside(file)["NOE"]["COO"]


CHANGES: dict[Callable[[h5py.File], None], str] = {
    cylindrical: "in cylindrical or spherical coordinates",
    second: "holds 2 times a mesh instead of one",
    polyhedra: "elements of POE, which are none here",
    elsewhere: "takes its numbers from another file",
    fewer: "not as many elements HE8 as it says",
    no_nodes: "it has no COO",
}


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__)
def test_what_med_files_hold_besides_is_refused(tmp_path, med, change):
    (tmp_path / "body.med").write_bytes(med)
    assert {kind for kind, _ in med_mesh(tmp_path / "body.med", frozenset()).cells} == {"hexahedron", "quad"}
    with h5py.File(tmp_path / "body.med", "r+") as file:
        change(file)
    with pytest.raises(InputError, match=CHANGES[change]):
        med_mesh(tmp_path / "body.med", frozenset())


def test_a_file_that_is_no_hdf5_is_no_med_file(tmp_path):
    (tmp_path / "body.med").write_text("text")
    with pytest.raises(InputError, match="no MED file, or damaged"):
        med_mesh(tmp_path / "body.med", frozenset())


TETRA = meshio.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], [("tetra", [[0, 1, 2, 3], [1, 2, 3, 4]])])
FEWER = meshio.Mesh(TETRA.points, [("tetra", [[0, 1, 2, 3]])])
COUNTED = {"su2": {}, "vol": {}, "avs": {}, "ele": {}, "dat": {}, "xml": {}, "xdmf": {"data_format": "XML"}}
"""Ending -> options of writing, of formats that state how many elements there are."""


@pytest.mark.parametrize("ending", COUNTED)
def test_elements_are_counted_where_the_format_states_them(tmp_path, monkeypatch, ending):
    path = tmp_path / f"body.{ending}"
    meshio.write(path, TETRA, **COUNTED[ending])
    assert stated_counts(path) in ((5, 2), (None, 2))
    monkeypatch.setattr("preprocessing.foreign_files.mesh_reader.meshio.read", lambda *_, **__: FEWER)
    with pytest.raises(InputError, match="meshio reads 1 elements of it, and it says that it holds others"):
        any_mesh(str(path))


def test_elements_of_medit_are_counted_over_all_kinds(tmp_path):
    text = "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 1\n1 0 0 1\n0 1 0 1\n0 0 1 1\n"
    (tmp_path / "body.mesh").write_text(text + "Triangles\n1\n1 2 3 1\n Tetrahedra\n1\n1 2 3 4 1\nEnd\n")
    assert stated_counts(tmp_path / "body.mesh") == (4, 2)
    assert [(kind, len(nodes)) for kind, nodes in any_mesh(str(tmp_path / "body.mesh")).cells] == [("triangle", 1), ("tetra", 1)]


def test_elements_of_ugrid_are_counted_over_all_kinds(tmp_path):
    """The writer of meshio is of no use under NumPy 2, where it prints types of numbers too."""
    (tmp_path / "body.ugrid").write_text("4 1 0 1\n0 0 0\n")
    assert stated_counts(tmp_path / "body.ugrid") == (4, 2)


def test_an_entry_that_is_missing_in_a_list_of_dolfin_is_refused(tmp_path):
    """meshio would take whatever the memory held."""
    meshio.write(tmp_path / "body.xml", TETRA)
    text = (tmp_path / "body.xml").read_text()
    (tmp_path / "body.xml").write_text(text.replace('cells size="2"', 'cells size="3"'))
    with pytest.raises(InputError, match="meshio reads 3 elements"):
        any_mesh(str(tmp_path / "body.xml"))


def test_that_nothing_was_counted_is_told(tmp_path):
    meshio.write(tmp_path / "body.post", TETRA)
    (remark,) = any_mesh(str(tmp_path / "body.post")).remarks
    assert remark.startswith("The number of elements was not checked")


@pytest.fixture
def warning(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """meshio says something before it returns a mesh."""

    def says(text: str) -> None:
        def read(*_: object, **__: object) -> meshio.Mesh:
            meshio._common.warn(text)
            return TETRA

        monkeypatch.setattr("preprocessing.foreign_files.mesh_reader.meshio.read", read)

    return says


def test_a_warning_of_meshio_is_a_refusal(tmp_path, warning):
    warning("File contains cells that meshio cannot handle.")
    with pytest.raises(InputError, match="meshio warns that it leaves out something"):
        any_mesh(str(tmp_path / "body.post"))


def test_a_warning_that_touches_no_element_is_a_remark(tmp_path, warning):
    warning("meshio does not support tags of string type.")
    assert any("Names of markers of SU2 are not read" in each for each in any_mesh(str(tmp_path / "body.post")).remarks)


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("body.stl", "STL, which holds surfaces, not the elements of a body"),
        ("body.STEP", "STEP, which holds shapes, not a mesh"),
        ("body.key", "LS-DYNA, which is not read"),
        ("body.celum_s", "CELUM, which is not read"),
        ("body.xyz", "an ending that no format of meshes has here"),
        ("body", "an ending that no format of meshes has here"),
    ],
)
def test_formats_are_refused_by_name(tmp_path: Path, name: str, why: str):
    (tmp_path / name).write_text("1 2 3")
    with pytest.raises(InputError, match=rf"{name}'.*{why}.*Export the elements of the body as gmsh \.msh"):
        read_mesh(tmp_path / name)


def test_a_kind_of_elements_that_a_library_does_not_know_is_told_as_that(tmp_path, read_here):
    """gmsh writes elements with middle nodes into Medit's files, at which meshio ends the program."""
    path = tmp_path / "a.mesh"
    nodes = "\n".join(f"{k} 0 {k % 3} 1" for k in range(10))
    path.write_text(
        f"MeshVersionFormatted 2\nDimension\n3\nVertices\n10\n{nodes}\nTetrahedraP2\n1\n1 2 3 4 5 6 7 8 9 10 1\nEnd\n"
    )
    with pytest.raises(InputError, match="a section or a kind of elements that meshio does not know"):
        read_mesh(path)
