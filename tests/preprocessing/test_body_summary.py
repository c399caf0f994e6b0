"""What `ffrf-preprocess` and `ffrf inspect` say of a body: closed forms of bars, bent boxes, plates, skins and frames."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import ffrf
from preprocessing import build
from preprocessing.builders import named_mesh
from preprocessing.commands.cli import app as preprocess
from preprocessing.foreign_files.contents import LeftOutContent
from preprocessing.mesh.solid_mesh import SolidMesh
from tests.models.solid_bodies import DENSITY, KINDS, SPATIAL_KINDS, WIDTH, box, rectangle, write_body
from toolkit.command_line.cli import app as ffrf_command

ROOT = Path(__file__).parents[2]
BAR = """units = "m-kg-s"
mesh = { file = "body.inp" }
material = { youngs_modulus = 210e9, density = 7800.0, poisson_ratio = 0.3 }
clamp = { group = "left" }
interface_points = { tip = { group = "right", tie = "rigid" } }
basis = { kind = "craig-bampton", count = 2, derivative = "frozen" }
"""
KEYS = {
    "mass", "centre", "inertia", "volume", "nodes", "elements", "units", "interface_points", "clamp", "groups", "masses", "left_out",
    "remarks", "not_listed",
}  # fmt: skip

pytestmark = pytest.mark.usefixtures("read_here")


@pytest.fixture
def bar(tmp_path) -> Path:
    """Four hexahedra of 1 x 1 x 0.5 m in a row along x."""
    shutil.copyfile(ROOT / "tests" / "data" / "bar_of_four_hexahedra.inp", tmp_path / "body.inp")
    (tmp_path / "body.toml").write_text(BAR)
    return tmp_path


def said(*words: str | Path) -> dict:
    """What a command prints as JSON."""
    app = preprocess if words[0] == "preprocess" else ffrf_command
    done = CliRunner().invoke(app, [*map(str, words[1:] if words[0] == "preprocess" else words), "--json"])
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


def test_the_keys_of_inspect_are_those_that_programs_read(bar):
    built = said("preprocess", bar / "body.toml")
    body = said("inspect", bar / "body.h5")["body"]
    assert body == built["body"] == ffrf.describe(bar / "body.h5")["body"]
    assert body.keys() == KEYS
    assert body["mass"] == pytest.approx(15600.0, rel=1e-12)
    assert body["centre"] == pytest.approx([2.0, 0.5, 0.25], rel=1e-12)
    assert body["volume"] == pytest.approx(2.0, rel=1e-12)
    assert (body["nodes"], body["elements"]) == (20, {"hexahedron": 4})
    assert body["interface_points"].keys() == {"tip"}
    assert body["interface_points"]["tip"]["position"] == pytest.approx([4.0, 0.5, 0.25], rel=1e-12)
    assert body["interface_points"]["tip"]["nodes"] == 4
    assert body["clamp"] == {"position": [0.0, 0.5, 0.25], "nodes": 4}
    assert body["groups"]["bar"] == {"position": [2.0, 0.5, 0.25], "nodes": 20}
    assert body["left_out"] == body["masses"] == body["remarks"] == []
    sides = np.array([4.0, 1.0, 0.5]) ** 2
    np.testing.assert_allclose(body["inertia"], 15600.0 / 12 * (sides.sum() * np.eye(3) - np.diag(sides)), atol=1e-8)
    assert body["units"] == {"mass": "kg", "centre": "m", "inertia": "kg m^2", "volume": "m^3", "position": "m"}


def test_one_line_ends_what_preprocess_says_and_inspect_says_it_for_people(bar):
    line = "body: 4 hexahedra (20 nodes in all), 15600 kg at (2, 0.5, 0.25) m, 2 m^3; tip at (4, 0.5, 0.25), 4 nodes."
    for _ in ("built", "up to date"):
        assert line in CliRunner().invoke(preprocess, [str(bar / "body.toml")]).stdout.splitlines()
    told = CliRunner().invoke(ffrf_command, ["inspect", str(bar / "body.h5")]).stdout
    assert "  interface point tip: (4, 0.5, 0.25) m, 4 nodes\n" in told
    assert "  elements: 4 hexahedra (20 nodes in all)\n" in told


def test_what_is_left_out_and_remarked_is_said_once_and_kept(bar, monkeypatch):
    def read(*args) -> SolidMesh:
        found = original(*args)
        return replace(found, left_out=[LeftOutContent("M3D9", 12, "faces only")], remarks=["Node 5 stands there twice."])

    original = named_mesh.read_mesh
    monkeypatch.setattr(named_mesh, "read_mesh", read)
    done = CliRunner().invoke(preprocess, [str(bar / "body.toml")])
    assert done.stderr.count("Node 5 stands there twice.") == 1
    assert done.stderr.count("body.toml: not part of the body: 12 M3D9 (faces only).") == 1
    assert "4 nodes; left out: 12 M3D9 (faces only)." in done.stdout
    body = said("inspect", bar / "body.h5")["body"]
    assert body["left_out"] == [{"what": "M3D9", "number": 12, "why": "faces only"}]
    assert body["remarks"] == ["Node 5 stands there twice."]


@pytest.mark.parametrize("kind", SPATIAL_KINDS)
def test_volume_times_density_is_the_mass_of_curved_solids(tmp_path, kind):
    """The volume comes from the maps of the elements, the mass from their matrices."""
    model = build(write_body(tmp_path, box(kind, (2, 1, 1), (1.0, 0.3, 0.2), 0.01), 'kind = "static"'))
    body = ffrf.describe(model)["body"]
    assert body["volume"] == pytest.approx(0.06, rel=0.05)
    assert body["mass"] == pytest.approx(DENSITY * body["volume"], rel=1e-12)
    assert body["elements"].keys() == {kind}


@pytest.mark.parametrize("kind", KINDS)
def test_volume_and_inertia_of_plates(tmp_path, kind):
    body = ffrf.describe(build(write_body(tmp_path, rectangle(kind, (3, 2), 2.0, 0.5), 'kind = "static"')))["body"]
    assert body["volume"] == pytest.approx(2.0 * 0.5 * WIDTH, rel=1e-12)
    assert body["mass"] == pytest.approx(DENSITY * body["volume"], rel=1e-12)
    assert body["centre"] == pytest.approx([1.0, 0.0], abs=1e-12)
    assert body["inertia"] == pytest.approx(body["mass"] * (2.0**2 + 0.5**2) / 12, rel=1e-12)
    assert body["interface_points"]["tip"]["position"] == pytest.approx([2.0, 0.0], abs=1e-12)


FRAME = """units = "m-kg-s"
clamp = ["A"]
nodes = { A = [0, 0, 0], B = [0, 0, 2], C = [1, 0, 2] }
beams = [
    { from = "A", to = "B", elements = 4, section = "tube" },
    { from = "B", to = "C", elements = 2, section = "bar" },
]
interface_points = { tip = { node = "C" } }
[sections]
tube = { kind = "tube", material = "steel", diameter = 0.1, wall = 0.01 }
bar = { kind = "rectangle", material = "wood", thickness = 0.02, width = 0.05 }
[materials]
steel = { youngs_modulus = 210e9, density = 7800.0, poisson_ratio = 0.3 }
wood = { youngs_modulus = 10e9, density = 500.0, poisson_ratio = 0.3 }
"""


def test_a_frame_of_two_materials_has_the_volume_of_its_beams(tmp_path):
    (tmp_path / "frame.toml").write_text(FRAME)
    body = ffrf.describe(build(tmp_path / "frame.toml"))["body"]
    tube, bar = np.pi / 4 * (0.1**2 - 0.08**2) * 2.0, 0.02 * 0.05 * 1.0
    assert body["volume"] == pytest.approx(tube + bar, rel=1e-12)
    assert body["mass"] == pytest.approx(7800.0 * tube + 500.0 * bar, rel=1e-12)
    assert body["centre"] == pytest.approx(
        [250.0 * bar / body["mass"], 0.0, (7800.0 * tube + 1000.0 * bar) / body["mass"]], abs=1e-12
    )
    assert (body["nodes"], body["elements"]) == (7, {"beam": 6})
    assert body["interface_points"]["tip"] == {"position": [1.0, 0.0, 2.0], "nodes": 1}


def test_finished_matrices_without_elements_have_no_volume(tmp_path):
    import scipy.io

    model = build(write_body(tmp_path, mesh := box("hexahedron", (1, 1, 1), (1.0, 1.0, 1.0)), 'kind = "full"'))
    assert ffrf.describe(model)["body"]["volume"] == pytest.approx(1.0)
    np.savetxt(tmp_path / "nodes.csv", mesh.nodes, delimiter=",")
    lumped = DENSITY / 8 * np.eye(24)
    scipy.io.mmwrite(tmp_path / "mass.mtx", lumped)
    scipy.io.mmwrite(tmp_path / "stiffness.mtx", _springs(mesh.nodes))
    (tmp_path / "matrices.toml").write_text(
        'units = "m-kg-s"\nmatrices = { mass = "mass.mtx", stiffness = "stiffness.mtx", nodes = "nodes.csv" }\n'
        'clamp = { nodes = [0, 1, 2, 3] }\ninterface_points = { tip = { nodes = [4, 5, 6, 7] } }\nbasis = { kind = "static" }\n'
    )
    body = ffrf.describe(build(tmp_path / "matrices.toml"))["body"]
    assert body["mass"] == pytest.approx(DENSITY)
    assert (body["volume"], body["nodes"], body["elements"]) == (None, 8, {})
    assert body["clamp"]["nodes"] == body["interface_points"]["tip"]["nodes"] == 4


def _springs(nodes: np.ndarray) -> np.ndarray:
    """Stiffness of springs between all pairs of nodes, which nothing supports."""
    found = np.zeros((nodes.size, nodes.size))
    for i in range(len(nodes)):
        for j in range(i):
            along = (nodes[i] - nodes[j]) / np.linalg.norm(nodes[i] - nodes[j])
            row = np.zeros(nodes.size)
            row[3 * i : 3 * i + 3], row[3 * j : 3 * j + 3] = along, -along
            found += 1e9 * np.outer(row, row)
    return found
