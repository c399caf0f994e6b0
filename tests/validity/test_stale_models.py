"""A reduced model whose inputs were edited after it was built: the scene says so, with what has changed and the command that fixes it."""

from __future__ import annotations

import shutil
from pathlib import Path

import h5py
import meshio
import numpy as np
import pytest

from preprocessing.builders.build_model import build, read_recipe
from tests.models.solid_bodies import rectangle, write_body
from toolkit.files.scene_reader import read_scene
from toolkit.reduced_model.file import load, save
from toolkit.scene.scene import Scene
from toolkit.validity.scene_cautions import stale_models

pytestmark = pytest.mark.usefixtures("read_here")

ROOT = Path(__file__).parents[2]
MODELS = ROOT / "models"
WING = MODELS / "morphing_wing"
INPUTS = {
    "morphing_wing/skin": {"skin.toml", "high_speed.dat", "low_speed.dat"},
    "snap_through/skin": {"skin.toml", "../morphing_wing/high_speed.dat", "../morphing_wing/low_speed.dat"},
    "bracket/body": {"body.toml", "bracket.msh"},
    "spatial_bracket/body": {"body.toml", "bracket.msh"},
}


@pytest.fixture
def wing(tmp_path) -> Path:
    """A copy of the example with its model."""
    for name in ("high_speed.dat", "low_speed.dat", "skin.toml", "skin.h5", "scene.toml"):
        shutil.copyfile(WING / name, tmp_path / name)
    return tmp_path


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))


def said(folder: Path) -> str:
    """The one doubt about the scene in a folder."""
    (caution,) = stale_models(read_scene(folder / "scene.toml"))
    assert (caution.code, caution.doubt) == ("stale-model", True)
    return caution.text


@pytest.mark.parametrize("scene", sorted(MODELS.glob("*/scene.toml")), ids=lambda path: path.parent.name)
def test_shipped_scenes_have_the_models_of_their_files(scene):
    assert stale_models(read_scene(scene)) == []


@pytest.mark.parametrize("name", INPUTS)
def test_shipped_models_hold_what_they_were_built_from(name):
    model = load(MODELS / f"{name}.h5")
    assert set(model.inputs) == INPUTS[name]
    assert model.source == {f"{name.split('/')[1]}.toml": (MODELS / f"{name}.toml").read_text()}


def test_an_edited_thickness_is_told_with_both_values_and_the_command(wing):
    assert stale_models(read_scene(wing / "scene.toml")) == []
    edit(wing / "skin.toml", "thickness = 1.5", "thickness = 3.0")
    text = said(wing)
    assert "the reduced model 'skin.h5' of skin is older than what it was built from" in text
    assert "skin.toml, where section.thickness is 3.0 and was 1.5." in text
    assert text.endswith(f"Fix: build it again, ffrf-preprocess {wing / 'skin.toml'}")
    save(build(wing / "skin.toml"), wing / "skin.h5")
    assert stale_models(read_scene(wing / "scene.toml")) == []


def test_keys_that_come_and_go_are_told(wing):
    edit(wing / "skin.toml", "width = 1000.0\n", "")
    edit(wing / "skin.toml", "[interface_points]", '[basis]\nkind = "static"\n\n[interface_points]')
    assert "skin.toml, where basis.kind is static and was left out; section.width is left out and was 1000.0." in said(wing)


def test_an_edited_airfoil_is_told(wing):
    with (wing / "low_speed.dat").open("a") as file:
        file.write("\n")
    assert "there are changes in low_speed.dat. These numbers are those of the old files." in said(wing)


def test_comments_and_files_that_are_not_there_are_no_change(wing):
    text = (wing / "skin.toml").read_text()
    (wing / "skin.toml").write_text("# mine\n" + text.replace("thickness = 1.5", "thickness = 1.50"))
    assert stale_models(read_scene(wing / "scene.toml")) == []
    for name in ("skin.toml", "high_speed.dat", "low_speed.dat"):
        (wing / name).unlink()
    assert stale_models(read_scene(wing / "scene.toml")) == []
    (wing / "skin.toml").mkdir()
    assert stale_models(read_scene(wing / "scene.toml")) == []


def test_a_file_that_is_no_toml_any_more_has_changed(wing):
    (wing / "skin.toml").write_text("[section\n")
    assert "there are changes in skin.toml. " in said(wing)


def test_models_that_lie_elsewhere_find_their_files(wing):
    (wing / "built").mkdir()
    save(build(wing / "skin.toml", values={"thickness": 1.6}), wing / "built" / "thick.h5")
    assert set(load(wing / "built" / "thick.h5").inputs) == {"../skin.toml", "../high_speed.dat", "../low_speed.dat"}
    edit(wing / "scene.toml", '"skin.h5"', '"built/thick.h5"')
    assert stale_models(read_scene(wing / "scene.toml")) == []
    edit(wing / "skin.toml", "density = 2.7e-9", "density = 2.8e-9")
    text = said(wing)
    assert "material.density is 2.8e-09 and was 2.7e-09" in text
    command = f"ffrf-preprocess {wing / 'skin.toml'} --parameter thickness=1.6 --output {wing / 'built' / 'thick.h5'}"
    assert text.endswith(command)


def test_a_model_that_knows_no_files_says_nothing(wing):
    """Built in Python, or by an older version."""
    with h5py.File(wing / "skin.h5", "a", libver="v110") as file:
        for group in ("inputs", "source"):
            del file[group]
    edit(wing / "skin.toml", "thickness = 1.5", "thickness = 3.0")
    assert stale_models(read_scene(wing / "scene.toml")) == []


MESH = rectangle("quad8", (6, 2), 1.0, 0.2)
BASIS = 'kind = "craig-bampton"\ncount = 1'


def hanging(folder: Path) -> Scene:
    """A scene with the body in a folder."""
    (folder / "scene.toml").write_text(
        'units = "m-kg-s"\n[points]\nA = { body = "arm", interface = "tip" }\n[bodies]\n'
        'arm = { type = "flexible", model = "body.h5", frame = "grounded" }\n'
    )
    return read_scene(folder / "scene.toml")


def with_included_mesh(folder: Path) -> tuple[Path, Path]:
    """A body whose mesh is in a file that its Abaqus file includes from a folder below."""
    path = write_body(folder, MESH, BASIS)
    (folder / "parts").mkdir()
    included = folder / "parts" / "plate.inp"
    meshio.write(included, meshio.Mesh(np.column_stack([MESH.nodes, 0 * MESH.nodes[:, 0]]), [("quad8", MESH.blocks["quad8"])]))
    (folder / "body.inp").write_text("*HEADING\na plate\n** *INCLUDE, INPUT=parts/none.inp\n*Include, input=parts/plate.inp\n")
    path.write_text(path.read_text().replace("body.vtu", "body.inp"))
    return path, included


def with_xdmf(folder: Path) -> tuple[Path, Path]:
    """A body whose mesh is in XDMF, and its numbers in an HDF5 file beside it."""
    path = write_body(folder, MESH, BASIS)
    meshio.write(
        folder / "mesh.xdmf", meshio.Mesh(np.column_stack([MESH.nodes, 0 * MESH.nodes[:, 0]]), [("quad8", MESH.blocks["quad8"])])
    )
    path.write_text(path.read_text().replace("body.vtu", "mesh.xdmf"))
    return path, folder / "mesh.h5"


@pytest.mark.parametrize("make", [with_included_mesh, with_xdmf])
def test_files_that_a_mesh_draws_on_belong_to_the_inputs(make, tmp_path):
    path, data = make(tmp_path)
    described = read_recipe(path)
    assert data in described.inputs
    before = described.hash()
    model = described.build()
    assert model.input_hash == before
    save(model, tmp_path / "body.h5")
    scene = hanging(tmp_path)
    assert stale_models(scene) == []
    data.write_bytes(data.read_bytes() + b"\n")
    assert read_recipe(path).hash() != before  # ffrf-preprocess builds again
    (caution,) = stale_models(scene)
    assert f"changes in {data.relative_to(tmp_path).as_posix()}. " in caution.text


def test_an_included_file_is_not_sought_in_the_folder_of_the_command(tmp_path, monkeypatch):
    path, _ = with_included_mesh(tmp_path)
    before = read_recipe(path).hash()
    (tmp_path / "elsewhere" / "parts").mkdir(parents=True)
    (tmp_path / "elsewhere" / "parts" / "plate.inp").write_text("*HEADING\n")
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert read_recipe(path).hash() == before
