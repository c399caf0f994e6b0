"""`ffrf new linkage` and `ffrf new solid`: folders whose scenes run at once; what cannot be is refused before anything is written."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from preprocessing import build
from preprocessing.mesh.mesh_file import read_mesh
from preprocessing.projects.new_linkage import METRES, STIFFNESS, new_linkage
from preprocessing.projects.new_solid import TIP_MASS_PART, new_solid, size_question, volume
from toolkit.analyses.sensitivity.direct import direct
from toolkit.command_line.cli import app
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.file import save
from toolkit.studies.problem import problem_of
from toolkit.studies.study_file import read_study

pytestmark = pytest.mark.usefixtures("read_here")

BRACKET = Path(__file__).parents[2] / "models" / "bracket" / "bracket.msh"
WING = Path(__file__).parents[2] / "models" / "morphing_wing"


def test_a_crank_turns_fully():
    """Grashof: the shortest and the longest bar are together shorter than the others, and the shortest is the crank."""
    crank, *others = (np.hypot(*np.subtract(METRES[a], METRES[b])) for a, b in ("OA", "AB", "BC", "CO"))
    assert crank + max(others) < sum(others) - max(others)
    assert crank < min(others)


def test_a_quiet_start_says_nothing(tmp_path):
    done = CliRunner().invoke(app, ["new", "linkage", str(tmp_path / "linkage"), "--quiet"])
    assert (done.exit_code, done.output) == (0, "")
    assert (tmp_path / "linkage" / "scene.toml").is_file()


@pytest.mark.parametrize(("units", "metre"), [("m-kg-s", 1.0), ("mm-t-s", 1000.0)])
def test_a_new_linkage_holds_what_virtual_work_says(units, metre, tmp_path):
    """After one turn crank and rocker stand upright, so that all weights move sideways and the coupler does not turn.

    Both its ends move alike: 0.04 times the crank's rotation is 0.09 times the rocker's. The spring is loaded by 0.5 rad.
    """
    new_linkage(tmp_path / "linkage", units)
    scene = read_scene(tmp_path / "linkage" / "scene.toml")
    found = direct(scene, list(scene.design), "static")
    ratio = 0.04 / 0.09
    assert found.values["hold"] == pytest.approx(
        -0.5 * STIFFNESS * metre * ratio, rel=1e-6
    )  # Newton's tolerance, and digits of 2 pi
    assert found.gradients["hold"]["k"] == pytest.approx(-0.5 * ratio, rel=1e-6)  # as above
    assert set(problem_of(read_study(tmp_path / "linkage" / "study.toml")).variables) == {"x_B", "y_B", "k"}


def test_a_new_solid_of_a_mesh_of_ones_own_runs(tmp_path):
    new_solid(tmp_path / "solid", BRACKET, "crank", "pin")
    written = tomllib.loads((tmp_path / "solid" / "scene.toml").read_text())
    save(model := build(tmp_path / "solid" / "body.toml"), tmp_path / "solid" / "body.h5")
    # the weight is half the body: the mesh is cut into straight pieces, the finite elements are curved by a thousandth of its area
    assert written["bodies"]["weight"]["mass"] == pytest.approx(TIP_MASS_PART * float(model.invariants.mass), rel=1e-3)
    scene = read_scene(tmp_path / "solid" / "scene.toml", {"solver.end_time": 0.004, "joints.motor.curve.height": 0.001})
    found = direct(scene, list(scene.design), "static").values
    assert 0 < found["stress"] < 1.0  # MPa: 18 g bend an arm of 12 cm


NODES = "".join(f"{1 + 5 * j + i}, {10 * i}, {5 * j}\n" for j in range(3) for i in range(5))
ELEMENTS = "".join(f"{1 + 4 * j + i}, {(n := 1 + 5 * j + i)}, {n + 1}, {n + 6}, {n + 5}\n" for j in range(2) for i in range(4))
PART = f"*NODE\n{NODES}*ELEMENT, TYPE=CPS4\n{ELEMENTS}*NSET, NSET=hub\n1, 6, 11\n*NSET, NSET=tip\n5, 10, 15\n"
PLATE = {"main.inp": "*INCLUDE, INPUT=parts/plate.inp\n", "parts/plate.inp": PART}
"""A plate of 40 x 10 mm, in two files."""


def plate(folder: Path, changes: dict[str, str] | None = None) -> Path:
    """The mesh of the plate, with other files."""
    for name, text in (PLATE | (changes or {})).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder / "main.inp"


def test_a_new_solid_has_all_files_that_its_mesh_includes(tmp_path):
    """At their places; the old ones may go, and the folder may move."""
    mesh = plate(tmp_path / "old")
    written = new_solid(tmp_path / "solid", mesh)
    places = [path.relative_to(tmp_path / "solid").as_posix() for path in written]
    assert places == ["main.inp", "parts/plate.inp", "body.toml", "scene.toml", "README.md"]
    for name in PLATE:
        assert (tmp_path / "solid" / name).read_bytes() == (tmp_path / "old" / name).read_bytes()
    (tmp_path / "old").rename(tmp_path / "gone")
    (tmp_path / "solid").rename(tmp_path / "moved")
    model = build(tmp_path / "moved" / "body.toml")
    width = tomllib.loads((tmp_path / "moved" / "body.toml").read_text())["section"]["width"]
    assert float(model.invariants.mass) == pytest.approx(2.7e-9 * 40 * 10 * width, rel=1e-12)


OUTSIDE = {
    "above": ("../plate.inp", "outside of its own folder"),
    "absolute": ("FOLDER/parts/plate.inp", "by its absolute path"),
    "reserved": ("Body.toml", "is made of a file 'Body.toml', and the new folder gets one of that name"),
    "reserved folder": ("scene.toml/plate.inp", "is made of a file 'scene.toml/plate.inp'"),
}


@pytest.mark.parametrize("case", OUTSIDE)
def test_a_mesh_whose_files_have_no_place_in_the_new_folder_is_refused(case, tmp_path):
    (place, message), folder = OUTSIDE[case], tmp_path / "old"
    included = place.replace("FOLDER", str(folder))
    mesh = plate(folder, {"main.inp": f"*INCLUDE, INPUT={included}\n", included: PART})
    with pytest.raises(InputError, match=message):
        new_solid(tmp_path / "solid", mesh)
    assert not (tmp_path / "solid").exists()


def test_the_arm_of_a_new_solid_is_what_its_script_draws_and_is_held_and_gripped(tmp_path):
    new_solid(tmp_path / "solid")
    mesh = read_mesh(tmp_path / "solid" / "arm.msh")
    for group, x, radius in (("hub", 0.0, 8.0), ("tip", 120.0, 5.0)):  # the walls of the bores; gmsh writes sixteen digits
        np.testing.assert_allclose(np.hypot(*(mesh.nodes[mesh.groups[group], :2] - [x, 0.0]).T), radius, rtol=1e-6)
    area = np.pi * (16**2 + 10**2) / 2 + 120 * (16 + 10) - np.pi * (8**2 + 5**2 + 6**2)  # half eyes and a web, less the bores
    assert volume(mesh) == pytest.approx(8 * area, rel=0.02)  # the web meets the eyes beside their middles
    assert b"gmsh.model.mesh.setOrder(2)" in (tmp_path / "solid" / "mesh.py").read_bytes()
    body, scene = (tomllib.loads((tmp_path / "solid" / f"{name}.toml").read_text()) for name in ("body", "scene"))
    assert (body["clamp"]["group"], body["interface_points"]["tip"]["group"], scene["dimension"]) == ("hub", "tip", 3)
    assert scene["joints"]["motor"]["axis"] == scene["joints"]["hub"]["axis"] == [0.0, 0.0, 1.0]
    worst = max(build(tmp_path / "solid" / "body.toml").stress_errors.values())
    assert f"off by some {100 * worst:.2g} %" in (tmp_path / "solid" / "README.md").read_text()


REFUSED = {
    "mesh that is not there": (["solid", "--mesh", "none.msh"], "there is no mesh 'none.msh'.*leave --mesh out"),
    "group that is not there": (["solid", "--mesh", str(BRACKET)], "no group 'hub'; there are 'crank', 'pin'.*--clamp"),
    "other group that is not there": (["solid", "--mesh", str(BRACKET), "--clamp", "crank"], "no group 'tip'.*--grip"),
    "units that no scene has": (["linkage", "--units", "cm"], "no units 'cm'. Take one of mm-t-s, m-kg-s"),
    "groups of the drawn arm": (["solid", "--clamp", "foo"], "groups of a mesh of your own: give it with --mesh"),
    "one group for both": (
        ["solid", "--mesh", str(BRACKET), "--clamp", "pin", "--grip", "pin"],
        "held and gripped at the same group",
    ),
    "fractions that are said to be mm": (
        ["wing", "--airfoil", str(WING / "high_speed.dat"), "--units", "mm"],
        "would be a chord of 1 mm.*--units fraction.*--chord",
    ),
    "units of the drawn arm": (["solid", "--units", "m-kg-s"], "is in mm: leave --units out"),
}


@pytest.mark.parametrize("case", REFUSED)
@pytest.mark.usefixtures("programs_here")
def test_what_cannot_be_is_refused_with_nothing_written(case, tmp_path):
    (kind, *options), message = REFUSED[case]
    done = CliRunner().invoke(app, ["new", kind, str(tmp_path / "mine"), *options])
    assert (done.exit_code, done.stdout) == (1, "")
    with pytest.raises(ValueError, match=message):
        raise ValueError(done.stderr.replace("\n", " "))
    assert not (tmp_path / "mine").exists()


@pytest.mark.usefixtures("programs_here")
def test_a_mesh_of_an_unlikely_size_is_questioned_by_its_units(tmp_path):
    command = [
        "new",
        "solid",
        str(tmp_path / "a"),
        "--mesh",
        str(BRACKET),
        "--clamp",
        "crank",
        "--grip",
        "pin",
        "--units",
        "m-kg-s",
    ]
    done = CliRunner().invoke(app, command)
    assert "The mesh is 153 m long if its numbers are m" in done.stderr
    assert "--units mm-t-s" in done.stderr
    assert size_question(BRACKET, "mm-t-s") == ""


@pytest.mark.usefixtures("programs_here")
def test_the_command_says_what_it_wrote_and_a_second_one_overwrites_nothing(tmp_path):
    first, second = (CliRunner().invoke(app, ["new", "linkage", str(tmp_path / "mine")]) for _ in range(2))
    assert "then ffrf sensitivity" in first.stdout
    assert (second.exit_code, "is not empty" in second.stderr) == (1, True)
