"""Files from elsewhere: told where they are, and never quoted in an error message."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from preprocessing.airfoil.airfoil_file import read_airfoil
from preprocessing.commands.cli import app as preprocess
from preprocessing.foreign_files.included_files import drawn_on
from preprocessing.mesh.matrix_file import read_matrix, read_nodes
from preprocessing.mesh.mesh_file import read_mesh
from toolkit.command_line.cli import app
from toolkit.files.results_file import load_results
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import ToolkitError, without_content
from toolkit.reduced_model.file import load

pytestmark = pytest.mark.usefixtures("read_here")

MODELS = Path(__file__).parents[2] / "models"
WING = MODELS / "morphing_wing"


@pytest.fixture
def project(tmp_path):
    """A wing whose model and airfoils are somewhere else."""
    (tmp_path / "shared").mkdir()
    (tmp_path / "project").mkdir()
    for name in ("skin.h5", "high_speed.dat", "low_speed.dat"):
        shutil.copy(WING / name, tmp_path / "shared" / name)
    for name in ("scene.toml", "skin.toml"):
        shutil.copy(WING / name, tmp_path / "project" / name)
    return tmp_path / "project"


def named_by(project: Path, way: str) -> str:
    """The shared folder as a scene may name it."""
    if way == "link":
        (project / "linked").symlink_to(project.parent / "shared")
    return {"..": "../shared", "absolute": str(project.parent / "shared"), "link": "linked"}[way]


def rewritten(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


@pytest.mark.parametrize("way", ["..", "absolute", "link"])
def test_a_scene_says_which_models_it_takes_from_elsewhere(project, way):
    rewritten(project / "scene.toml", '"skin.h5"', f'"{named_by(project, way)}/skin.h5"')
    place = project.parent / "shared" / "skin.h5"
    done = CliRunner().invoke(app, ["inspect", str(project / "scene.toml"), "--no-measure", "--json"])
    assert done.exit_code == 0, done.output
    assert done.stderr.splitlines()[0] == f"note: scene.toml takes files from outside of its folder: '{place}'."
    assert json.loads(done.stdout)["files outside of the scene's folder"] == str(place)
    quiet = CliRunner().invoke(app, ["inspect", str(project / "scene.toml"), "--no-measure", "--quiet"])
    assert (quiet.exit_code, quiet.stderr) == (0, "")


def test_a_scene_that_has_all_its_files_says_nothing():
    done = CliRunner().invoke(app, ["inspect", str(WING / "scene.toml"), "--no-measure", "--json"])
    assert "outside" not in done.output


@pytest.mark.parametrize("way", ["..", "absolute", "link"])
def test_a_body_says_which_files_it_is_built_from(project, way):
    folder = named_by(project, way)
    for name in ("high_speed.dat", "low_speed.dat"):
        rewritten(project / "skin.toml", f'"{name}"', f'"{folder}/{name}"')
    done = CliRunner().invoke(preprocess, [str(project / "skin.toml")])
    assert done.exit_code == 0, done.output
    places = ", ".join(f"'{project.parent / 'shared' / name}'" for name in ("high_speed.dat", "low_speed.dat"))
    assert done.stderr == f"skin.toml takes files from outside of its folder: {places}.\n"


def test_a_body_says_which_files_its_mesh_includes(tmp_path):
    """A plate whose nodes come from elsewhere."""
    (tmp_path / "shared").mkdir()
    (tmp_path / "body").mkdir()
    nodes = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n"
    rest = "*ELEMENT, TYPE=CPS4\n1, 1, 2, 3, 4\n*NSET, NSET=held\n1, 4\n*NSET, NSET=tip\n2, 3\n"
    (tmp_path / "shared" / "nodes.inp").write_text(nodes + rest)
    (tmp_path / "body" / "plate.inp").write_text("*Include, input=../shared/nodes.inp\n")
    shared = tmp_path / "body" / ".." / "shared" / "nodes.inp"
    assert drawn_on(tmp_path / "body" / "plate.inp") == [shared]
    (tmp_path / "body" / "body.toml").write_text(
        'units = "mm-t-s"\nmesh = { file = "plate.inp" }\nclamp = { group = "held" }\n'
        "material = { youngs_modulus = 2e5, density = 7.8e-9, poisson_ratio = 0.3 }\n"
        'section = { width = 1.0 }\nbasis = { kind = "static" }\n[interface_points]\ntip = { group = "tip" }\n'
    )
    done = CliRunner().invoke(preprocess, [str(tmp_path / "body" / "body.toml")])
    assert done.exit_code == 0, done.output
    place = tmp_path / "shared" / "nodes.inp"
    assert done.stderr == f"body.toml takes files from outside of its folder: '{place}'.\n"


SECRET = "S3cr3tW0rd"
TEXTS = {
    "passwords": f"root:{SECRET}:0:0:{SECRET}:/root\n{SECRET} 1 2\n",
    "one number": "0123456789\n" * 5,
    "numbers with commas": f"1,5 0,5\n0,7 0,1234567891\n{SECRET}\n",
    "table": f"1.0, {SECRET}, 3\n4, 5, 6\n",
    "gmsh": f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n2\n1 {SECRET} 0 0\n2 0 0 0\n$EndNodes\n",
    "abaqus": f"*NODE\n1, {SECRET}, 0.0\n*ELEMENT, TYPE={SECRET}\n1, 1, 2, 3\n",
    "nastran": f"GRID,1,,{SECRET}\n{SECRET},1,2\nGRID    {SECRET}\n+{SECRET},1\nSET3,1,{SECRET},1\nCHEXA,1,{SECRET},1,2\n",
    "nastran card": f"GRID,1,,1.,2.,3.\nGRID,{SECRET}\n",
    "vtk": f"# vtk DataFile Version 3.0\n{SECRET}\nASCII\nDATASET {SECRET}\n",
    "market": f"%%MatrixMarket matrix coordinate real general\n2 2 1\n1 {SECRET} 3\n",
}
READERS = {
    "airfoil": (read_airfoil, ".dat"),
    "mesh .msh": (read_mesh, ".msh"),
    "mesh .inp": (read_mesh, ".inp"),
    "mesh .bdf": (read_mesh, ".bdf"),
    "mesh .vtk": (read_mesh, ".vtk"),
    "matrix": (lambda path: read_matrix(path, 2), ".mtx"),
    "archive": (lambda path: read_matrix(path, 2), ".npz"),
    "nodes": (read_nodes, ".csv"),
    "reduced model": (load, ".h5"),
    "results": (load_results, ".h5"),
    "scene": (read_scene, ".toml"),
}


@pytest.mark.parametrize("text", TEXTS)
@pytest.mark.parametrize("reader", READERS)
def test_an_error_never_quotes_a_file_that_is_none_of_ours(tmp_path, capfd, reader, text):
    read, suffix = READERS[reader]
    path = tmp_path / f"file{suffix}"
    path.write_text(TEXTS[text])
    with pytest.raises(ToolkitError) as error:
        read(path)
    said = str(error.value) + "".join(capfd.readouterr())
    for part in (SECRET, "0123456789", "123456789", "0,1234567891", "1234567891"):
        assert part not in said


def test_quoted_content_is_left_out_of_reasons():
    assert without_content("could not convert string 'root:x:\"0\"' to float64 at row 0") == (
        "could not convert string ... to float64 at row 0"
    )
    assert without_content("it ends before its last line") == "it ends before its last line"
