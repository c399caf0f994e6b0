"""`ffrf new wing`: from any airfoil file to a wing that morphs; what cannot be is refused before anything is written."""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from preprocessing import build
from preprocessing.airfoil.airfoil_file import read_airfoil
from preprocessing.airfoil.contour import Contour
from preprocessing.airfoil.skin import Skin
from preprocessing.builders.build_model import read_recipe
from preprocessing.builders.skin_geometry import drooped, read_geometry
from preprocessing.projects.new_wing import DROOP_DEPTH, new_wing
from toolkit.analyses.sensitivity.run import Run
from toolkit.api.model import compile_model
from toolkit.command_line.cli import app
from toolkit.files.scene_reader import read_scene
from toolkit.reduced_model.file import save
from toolkit.studies.optimization.optimize import optimized
from toolkit.studies.problem import problem_of
from toolkit.studies.study_file import Search, read_study

ROOT = Path(__file__).parents[2]
AIRFOILS = ROOT / "tests" / "data" / "airfoils"
REFERENCE = ROOT / "models" / "morphing_wing"
VERY_DIFFERENT = {
    "thick, blocks without header": "nlf416_lednicer_noheader.txt",
    "thin, 35 rows, high camber": "fx63120.dat",
    "symmetric": "e171.dat",
    "cambered, cusped tail": "fx63137.dat",
    "OpenVSP, 18 rows a side": "naca23015.af",
}


def morphed(folder: Path, changes: dict[str, str] | None = None) -> Run:
    """The static end state of a new wing, with gradients."""
    save(build(folder / "skin.toml"), folder / "skin.h5")
    scene = read_scene(folder / "scene.toml", changes)
    return compile_model(scene, list(scene.design)).statics(gradients=True)


@pytest.mark.parametrize("airfoil", VERY_DIFFERENT.values(), ids=VERY_DIFFERENT)
def test_any_airfoil_becomes_a_wing_that_reaches_its_target(airfoil, tmp_path):
    folder = tmp_path / "wing"
    new_wing(folder, AIRFOILS / airfoil)
    run = morphed(folder)
    assert run.verdict.trusted, run.verdict
    found = run.values
    # the linkage is not tuned to the section: a tenth of the droop of 6 mm may be left, the stress be a quarter off the reference
    assert found["shape_rmse"] < 0.6
    assert 0.75 * 57 < found["max_stress_true"] < 1.25 * 57


def test_the_reference_airfoils_give_the_reference_wing(tmp_path):
    new_wing(tmp_path / "wing", REFERENCE / "high_speed.dat", REFERENCE / "low_speed.dat")
    ours, theirs = (tomllib.loads((folder / "scene.toml").read_text()) for folder in (tmp_path / "wing", REFERENCE))
    for name in "ABD":
        assert ours["points"][name] == pytest.approx(theirs["points"][name], abs=2e-3)  # heights are kept to five digits, in mm
    assert {key: ours[key] for key in ("joints", "loads", "design", "responses")} == {
        key: theirs[key] for key in ("joints", "loads", "design", "responses")
    }
    found = morphed(tmp_path / "wing", {"bodies.skin.frames": "1"}).values
    # C and E are 0.44 mm nearer to F, within elements: 5 MPa/mm by the joints' places
    assert found["max_stress_true"] == pytest.approx(56.78, abs=2.2)
    assert (tmp_path / "wing" / "target.dat").read_bytes() == (REFERENCE / "low_speed.dat").read_bytes()


ON_SKIN = ("points.C.arc_length", "points.E.arc_length")


def test_a_new_wing_has_a_study_that_comes_nearer_to_the_target_as_it_stands(tmp_path):
    folder = tmp_path / "wing"
    new_wing(folder, AIRFOILS / VERY_DIFFERENT["symmetric"], chord=1100.0)
    save(build(folder / "skin.toml"), folder / "skin.h5")
    written = read_study(folder / "study.toml")
    few = written.model_copy(update={"search": Search(evaluations=12, certify=False)})
    found = optimized(problem_of(few))
    assert set(found.variables) == {"M_t", "t_w", *(f"points.{name}.{axis}" for name in "ABD" for axis in "xy"), *ON_SKIN}
    assert found.search.failed == 0
    moved = found.search.best.gradients[0, found.problem.responses.index("shape_mse")]
    assert np.all(moved[[found.problem.variables.index(name) for name in ON_SKIN]] != 0)  # C and E count
    assert found.objective < 0.8 * found.values_before["shape_mse"]
    skin = Contour.through(read_airfoil(folder / "airfoil.dat").points, 1100.0)
    for name in "ABD":  # wherever the study may put a joint is within the section
        (left, right), heights = (written.variables[f"points.{name}.{axis}"].between for axis in "xy")
        for x in (left, right):
            low, high = (skin.position(skin.at_x(x, side))[1] for side in ("lower", "upper"))
            assert low < heights[0] < heights[1] < high


def test_a_wing_of_another_chord_is_a_scaled_copy_with_the_same_stress(tmp_path):
    for chord in (550.0, 55.0):
        new_wing(tmp_path / f"{chord:g}", REFERENCE / "high_speed.dat", chord=chord)
    large, small = (morphed(tmp_path / name, {"bodies.skin.frames": "4"}).values for name in ("550", "55"))
    assert small["max_stress_true"] == pytest.approx(large["max_stress_true"], rel=1e-3)  # digits of the written numbers
    assert small["drive_angle"] == pytest.approx(large["drive_angle"], rel=1e-3)
    assert small["shape_rmse"] == pytest.approx(large["shape_rmse"] / 10, rel=1e-3)


@pytest.mark.parametrize(("units", "factor", "chord"), [("percent", 100.0, None), ("mm", 300.0, 300.0), ("m", 0.3, 300.0)])
def test_an_airfoil_in_other_units_is_the_same_wing(units, factor, chord, tmp_path):
    """The section is that of the file in fractions of the chord; of lengths the chord is the largest x."""
    rows = np.loadtxt(AIRFOILS / "e171.dat", skiprows=1)
    np.savetxt(tmp_path / "scaled.dat", factor * rows, header="e171", comments="")
    if factor > 1:
        with pytest.raises(ValueError, match=r"no fractions of the chord.*--units percent"):
            new_wing(tmp_path / "unclear", tmp_path / "scaled.dat")
    new_wing(tmp_path / "scaled", tmp_path / "scaled.dat", units=units)
    new_wing(tmp_path / "plain", AIRFOILS / "e171.dat", chord=chord or 550.0)
    found, known = (read_recipe(tmp_path / name / "skin.toml") for name in ("scaled", "plain"))
    ours, theirs = (read_geometry(each.path, each.file) for each in (found, known))
    # np.savetxt keeps 18 digits; products with the factor and the quotient that undoes it round
    np.testing.assert_allclose(ours.skin.position(ours.arc_lengths), theirs.skin.position(theirs.arc_lengths), rtol=0, atol=1e-9)
    np.testing.assert_allclose(ours.target, theirs.target, rtol=0, atol=1e-5)  # rows of nine digits of the chord, in mm


def test_a_target_in_percent_goes_with_an_airfoil_in_fractions(tmp_path):
    rows = np.loadtxt(REFERENCE / "low_speed.dat", skiprows=1)
    np.savetxt(tmp_path / "low.dat", 100 * rows, header="low speed", comments="")
    new_wing(tmp_path / "wing", REFERENCE / "high_speed.dat", tmp_path / "low.dat", target_units="percent")
    new_wing(tmp_path / "known", REFERENCE / "high_speed.dat", REFERENCE / "low_speed.dat")
    ours, theirs = (
        read_geometry(each.path, each.file) for each in (read_recipe(tmp_path / n / "skin.toml") for n in ("wing", "known"))
    )
    np.testing.assert_allclose(ours.target, theirs.target, rtol=0, atol=1e-9)  # as above


def test_the_droop_keeps_lengths_height_and_slope_and_sinks_the_nose():
    contour = Contour.through(read_airfoil(REFERENCE / "high_speed.dat").points, 550.0)
    skin = Skin(contour, contour.at_x(137.5, "upper"), contour.at_x(137.5, "lower"))
    target = Contour.through(drooped(contour, skin, 6.0, 550.0), 1.0)
    known = Contour.through(read_airfoil(REFERENCE / "low_speed.dat").points, 550.0)
    s = np.linspace(0, skin.length, 31)
    ours, theirs = (skin.target_positions(each, s) for each in (target, known))
    np.testing.assert_allclose(ours, theirs, atol=1e-3)  # the reference's target is this droop, through other rows of nine digits
    assert ours[-1, 1] == pytest.approx(skin.position(skin.length)[1], abs=1e-3)  # as above: arc lengths of different splines
    nose = contour.leading_edge - skin.start
    assert skin.target_positions(target, nose)[1] == pytest.approx(skin.position(nose)[1] - 6, abs=1e-3)


@pytest.mark.usefixtures("programs_here")
def test_the_command_says_what_it_wrote_and_what_comes_next(tmp_path):
    folder = tmp_path / "my wing"
    done = CliRunner().invoke(app, ["new", "wing", str(folder), "--airfoil", str(AIRFOILS / "e171.dat")])
    assert done.exit_code == 0, done.stderr
    assert sorted(file.name for file in folder.iterdir()) == [
        "README.md",
        "airfoil.dat",
        "scene.toml",
        "skin.toml",
        "study.toml",
        "target.dat",
    ]
    assert (folder / "airfoil.dat").read_bytes() == (AIRFOILS / "e171.dat").read_bytes()
    assert "skin.toml, then ffrf statics" in done.stdout
    assert f"{DROOP_DEPTH:.1%}" in (folder / "README.md").read_text()
    assert f"ffrf-preprocess '{folder}'/skin.toml" in (folder / "README.md").read_text()


def occupied(folder: Path) -> None:
    folder.mkdir()
    (folder / "mine.txt").write_text("")


REFUSED = {
    "folder with something in it": (occupied, [], "is not empty, and nothing of yours"),
    "file instead of a folder": (lambda folder: folder.write_text(""), [], "is a file"),
    "missing airfoil": (None, ["--airfoil", "none.dat"], "none.dat: cannot be read.*Check the path"),
    "folder as airfoil": (None, ["--airfoil", str(AIRFOILS)], "cannot be read"),
    "no airfoil": (None, ["--airfoil", str(REFERENCE / "scene.toml")], "airfoil scene.toml: "),
    "missing target": (None, ["--target", "none.dat"], "none.dat: cannot be read.*Check the path"),
    "target of another section": (None, ["--target", str(AIRFOILS / "naca23015.af")], "passes F .* at a distance"),
    "target's units without a target": (None, ["--target-units", "mm"], "belong to a target: give it with --target"),
    "units that nobody has": (None, ["--units", "inch"], "--units inch is unknown. Take one of fraction, percent, mm, m"),
    "target's units that nobody has": (
        None,
        ["--target", str(REFERENCE / "low_speed.dat"), "--target-units", "inch"],
        "--target-units inch is unknown. Take one of fraction, percent, mm, m",
    ),
    "fractions called percent": (None, ["--units", "percent"], "0.01 chord where.*read as percent of the chord.*with --units."),
    "target's fractions called percent": (
        None,
        ["--target", str(REFERENCE / "low_speed.dat"), "--target-units", "percent"],
        "low_speed.dat.*0.01 chord where.*with --target-units.",
    ),
    "chord of nothing": (None, ["--chord", "0"], "chord of 0 mm cannot be"),
    "chord beyond reason": (None, ["--chord", "1e300"], r"chord of 1e\+300 mm cannot be. Give a length from 0.001 to 1e\+06 mm"),
    "chord of atoms": (None, ["--chord", "1e-300"], "chord of 1e-300 mm cannot be"),
    "airfoil of a long name": (None, ["--airfoil", "x" * 300], "cannot be read: File name too long"),
    "folder below a file": (None, ["below"], "cannot be written"),
    "folder of a long name": (None, ["long"], "the system refused to go on at .*: File name too long"),
}


def test_the_program_in_its_own_process_refuses_with_nothing_written(tmp_path):
    refused("missing airfoil", tmp_path)


@pytest.mark.parametrize("case", REFUSED)
@pytest.mark.usefixtures("programs_here")
def test_what_cannot_be_is_refused_with_nothing_written(case, tmp_path):
    refused(case, tmp_path)


def refused(case: str, tmp_path: Path) -> None:
    prepare, options, message = REFUSED[case]
    folder = tmp_path / "wing"
    if options == ["below"]:
        (tmp_path / "file").write_text("")
        folder, options = tmp_path / "file" / "wing", []
    if options == ["long"]:
        folder, options = tmp_path / ("x" * 300), []
    if prepare:
        prepare(folder)
    before = sorted(tmp_path.rglob("*"))
    done = CliRunner().invoke(app, ["new", "wing", str(folder), "--airfoil", str(AIRFOILS / "e171.dat"), *options])
    assert (done.exit_code, done.stdout) == (1, "")
    assert "Traceback" not in done.stderr
    assert_matches(message, done.stderr)
    assert sorted(tmp_path.rglob("*")) == before


def assert_matches(message: str, text: str) -> None:
    with pytest.raises(ValueError, match=message):
        raise ValueError(text.replace("\n", " "))


def test_without_preprocessing_the_command_says_what_to_install(tmp_path):
    code = (
        "import sys, toolkit.foundation.processes as new; new.is_installed = lambda: False;"
        "from toolkit.command_line.cli import app;"
        f"sys.argv = ['ffrf', 'new', 'wing', {str(tmp_path / 'w')!r}, '--airfoil', 'a.dat']; app()"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "pip install 'ffrf-toolkit[preprocessing]'" in done.stderr


def test_a_droop_that_no_skin_can_make_is_refused():
    contour = Contour.through(read_airfoil(REFERENCE / "high_speed.dat").points, 550.0)
    skin = Skin(contour, contour.at_x(137.5, "upper"), contour.at_x(137.5, "lower"))
    with pytest.raises(ValueError, match="Choose a smaller depth"):
        drooped(contour, skin, 500.0, 550.0)


@pytest.mark.usefixtures("programs_here")
def test_json_names_the_files_and_the_next_commands(tmp_path):
    asked = ["new", "wing", str(tmp_path / "wing"), "--airfoil", str(REFERENCE / "high_speed.dat"), "--json"]
    told = json.loads(CliRunner().invoke(app, asked).stdout)
    assert sorted(told["files"]) == sorted(map(str, (tmp_path / "wing").iterdir()))
    assert told["next"][0] == f"ffrf-preprocess {tmp_path}/wing/skin.toml"
    again = CliRunner().invoke(app, asked)
    assert again.exit_code == 1
    assert "is not empty" in json.loads(again.stdout)["error"]
