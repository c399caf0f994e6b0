"""MED on small changes of a file of gmsh, and formats that meshio reads: counted, and its warnings heard."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import h5py
import meshio
import numpy as np
import pytest

from preprocessing.foreign_files.any_mesh import any_mesh
from preprocessing.foreign_files.meshes.med_file import med_mesh
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
COUNTED = {
    "medit": ("mesh", {}, "Tetrahedra\n2", "Tetrahedra\n3"),
    "su2": ("su2", {}, "NELEM= 2", "NELEM= 3"),
    "netgen": ("vol", {}, "volumeelements\n2", "volumeelements\n3"),
    "avs": ("avs", {}, "5 2 0", "5 3 0"),
    "tetgen": ("ele", {}, "2 4 ", "3 4 "),
    "ugrid": ("ugrid", {}, "5 0 0 2", "5 0 0 3"),
    "tecplot": ("dat", {}, "ELEMENTS = 2", "ELEMENTS = 3"),
    "dolfin": ("xml", {}, 'cells size="2"', 'cells size="3"'),
    "xdmf": ("xdmf", {"data_format": "XML"}, 'NumberOfElements="2"', 'NumberOfElements="3"'),
}
"""Format -> ending, options of writing, and a number of elements in it that is made a wrong one."""


@pytest.mark.parametrize("name", COUNTED)
def test_elements_are_counted_where_the_format_states_them(tmp_path, name):
    ending, options, right, wrong = COUNTED[name]
    path = tmp_path / f"body.{ending}"
    meshio.write(path, TETRA, **options)
    found = any_mesh(str(path))
    assert [(kind, len(nodes)) for kind, nodes in found.cells] == [("tetra", 2)]
    assert not found.remarks
    text = path.read_text()
    assert right in text
    path.write_text(text.replace(right, wrong, 1))
    with pytest.raises((InputError, Exception, SystemExit), match=r"."):
        any_mesh(str(path))


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

        monkeypatch.setattr("preprocessing.foreign_files.any_mesh.meshio.read", read)

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
    assert np.all(TETRA.points[0] == 0)
