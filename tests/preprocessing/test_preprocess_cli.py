"""The command `ffrf-preprocess`: what it writes, when it has nothing to do, and what it says about wrong inputs."""

import json
import os
import shutil
import sys
import tomllib
from dataclasses import asdict, replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from preprocessing import build
from preprocessing.builders.recipe import WRITER_VERSION
from preprocessing.builders.skin_geometry import read_geometry
from preprocessing.builders.skin_recipe import SkinRecipe
from preprocessing.commands.cli import main
from toolkit.reduced_model.file import load, save

ROOT = Path(__file__).parents[2]
MODELS = ROOT / "models" / "morphing_wing"


@pytest.fixture
def folder(tmp_path):
    """A copy of the example's inputs."""
    for name in ("high_speed.dat", "low_speed.dat", "skin.toml"):
        shutil.copyfile(MODELS / name, tmp_path / name)
    return tmp_path


@pytest.fixture
def run(monkeypatch, capsys, folder):
    """Run the command on the copy: exit code, standard output, standard error."""

    def command(*options: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["ffrf-preprocess", str(folder / "skin.toml"), *options])
        with pytest.raises(SystemExit) as caught:
            main()
        output = capsys.readouterr()
        return caught.value.code or 0, output.out, output.err

    return command


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def arrays(model) -> dict[str, np.ndarray]:
    """All arrays of a model by the path of their names."""

    def walk(name, value):
        if isinstance(value, dict):
            for key, item in value.items():
                yield from walk(f"{name}/{key}", item)
        elif isinstance(value, np.ndarray):
            yield name, value

    return dict(walk("", {k: v for k, v in asdict(replace(model, path=None)).items()}))


def test_model_is_written_next_to_the_toml_and_read_by_the_runtime(run, folder):
    code, out, err = run()
    assert (code, err) == (0, "")
    assert "skin.h5 written: 90 elastic coordinates, interface points C, E, G." in out
    model = load(folder / "skin.h5")
    assert model.nominal == {
        "youngs_modulus": 70000.0,
        "density": 2.7e-9,
        "thickness": 1.5,
        "width": 1000.0,
        "damping_mass": 0.0,
        "damping_stiffness": 0.0,
        "chord": 550.0,
        "y_scale": 1.0,
    }
    assert model.nominal_units == {
        "youngs_modulus": "MPa",
        "density": "t/mm^3",
        "thickness": "mm",
        "width": "mm",
        "damping_mass": "1/s",
        "damping_stiffness": "s",
        "chord": "mm",
        "y_scale": "",
    }
    assert set(model.writers) == {"ffrf-toolkit", "gmsh", "numpy"}
    assert sorted(p.name for p in folder.iterdir()) == ["high_speed.dat", "low_speed.dat", "skin.h5", "skin.toml"]


def test_second_run_with_unchanged_inputs_does_nothing(run, folder):
    run()
    before = (folder / "skin.h5").stat()
    code, out, _ = run()
    after = (folder / "skin.h5").stat()
    assert code == 0
    assert "is up to date: its inputs are unchanged. Use --force" in out
    assert (before.st_ino, before.st_mtime_ns) == (after.st_ino, after.st_mtime_ns)


def test_force_builds_again(run, folder):
    run()
    before = (folder / "skin.h5").stat().st_ino
    assert "written" in run("--force")[1]
    assert (folder / "skin.h5").stat().st_ino != before  # written anew and renamed


@pytest.mark.parametrize("name", ["skin.toml", "high_speed.dat", "low_speed.dat"])
def test_change_of_any_input_builds_again(run, folder, name):
    run()
    with (folder / name).open("ab") as file:
        file.write(b"\n")
    assert "written" in run()[1]


@pytest.mark.parametrize("rest", [1.0, 0.5])
def test_file_that_is_no_whole_model_is_replaced_only_on_demand(run, folder, rest):
    run()
    whole = (folder / "skin.h5").read_bytes()
    content = b"my data" if rest == 1 else whole[: int(rest * len(whole))]
    (folder / "skin.h5").write_bytes(content)
    for options in ((), ("--force",)):
        code, out, err = run(*options)
        assert (code, out) == (1, "")
        assert (
            "skin.h5' is there and is not a reduced model, or a damaged one. Name another file with --output, or replace" in err
        )
        assert (folder / "skin.h5").read_bytes() == content
    assert "written" in run("--overwrite")[1]


def test_a_model_of_another_body_is_replaced_only_on_demand(run, folder):
    """One that says what it was built from, and one that does not."""
    (folder / "other").mkdir()
    shutil.copy(ROOT / "models" / "rotating_beam" / "beam.h5", folder / "other" / "beam.h5")
    for name in ("high_speed.dat", "low_speed.dat", "skin.toml"):
        shutil.copy(folder / name, folder / "other" / name)
    edit(folder / "other" / "skin.toml", "thickness = 1.5", "thickness = 1.4")
    save(build(folder / "other" / "skin.toml"), folder / "other" / "skin.h5")
    bodies = {"beam.h5": "which does not say what it was built from", "skin.h5": f"built from '{folder / 'other' / 'skin.toml'}'"}
    for name, words in bodies.items():
        place = folder / "other" / name
        before = place.read_bytes()
        for options in ((), ("--force",)):
            code, out, err = run("--output", str(place), *options)
            assert (code, out) == (1, "")
            assert (
                f"{name}' is there and is the reduced model of another body, {words}. Name another file with --output, or " in err
            )
            assert place.read_bytes() == before
    assert "written" in run("--output", str(folder / "other" / "beam.h5"), "--overwrite")[1]


def test_a_model_of_the_same_body_is_replaced_wherever_it_is(run, folder, monkeypatch):
    """Also when all of it has been moved; and a committed one that does not say what it was built from, at its usual place."""
    (folder / "project").mkdir()
    shutil.copy(MODELS / "skin.h5", folder / "skin.h5")
    edit(folder / "skin.toml", "thickness = 1.5", "thickness = 1.6")
    assert "written" in run()[1]
    assert "written" in run("--output", str(folder / "project" / "thick.h5"), "--parameter", "thickness=2.0")[1]
    assert "../skin.toml" in load(folder / "project" / "thick.h5").inputs
    moved = Path(shutil.copytree(folder, folder.with_name(folder.name + " moved")))
    edit(moved / "skin.toml", "thickness = 1.6", "thickness = 1.7")
    monkeypatch.setattr(
        sys, "argv", ["ffrf-preprocess", str(moved / "skin.toml"), "--output", str(moved / "project" / "thick.h5")]
    )
    with pytest.raises(SystemExit, match=r"^0$"):
        main()
    assert load(moved / "project" / "thick.h5").nominal["thickness"] == 1.7


@pytest.mark.parametrize("options", [(), ("--force",), ("--overwrite",), ("--force", "--overwrite")])
def test_a_scene_is_never_replaced_by_a_model(run, folder, options):
    shutil.copy(MODELS / "scene.toml", folder / "scene.toml")
    code, out, err = run("--output", str(folder / "scene.toml"), *options)
    assert (code, out) == (1, "")
    assert "scene.toml' does not end in .h5, as the name of a reduced model must. Name another file with --output." in err
    assert (folder / "scene.toml").read_bytes() == (MODELS / "scene.toml").read_bytes()


def test_a_linked_model_is_replaced_where_it_is_and_keeps_its_permissions(run, folder):
    (folder / "shared").mkdir()
    (folder / "skin.h5").symlink_to(Path("shared") / "skin.h5")
    run()
    (folder / "shared" / "skin.h5").chmod(0o600)
    assert "written" in run("--force")[1]
    assert (folder / "skin.h5").is_symlink()
    assert (folder / "shared" / "skin.h5").stat().st_mode & 0o777 == 0o600


@pytest.mark.parametrize("options", [(), ("--force", "--overwrite")])
def test_a_pipe_as_output_is_neither_replaced_nor_waited_for(run, folder, options):
    os.mkfifo(folder / "pipe.h5")
    code, _, err = run("--output", str(folder / "pipe.h5"), *options)
    assert code == 1
    assert "pipe.h5' is there and is not a regular file" in err
    assert (folder / "pipe.h5").is_fifo()


@pytest.mark.parametrize("missing", ["mesh/nodes", "shape", "affine"])
def test_model_that_is_not_whole_is_reported_and_replaced(run, folder, missing):
    run()
    with h5py.File(folder / "skin.h5", "a", libver="v110") as file:
        del file[missing]
    code, out, err = run()
    assert code == 0
    assert f"lacks {missing}" in err or "lacks the dataset 'nodes'" in err
    assert "It is built anew." in err
    assert "written" in out


def test_model_that_does_not_say_what_it_was_built_from_is_replaced(run, folder):
    run()
    with h5py.File(folder / "skin.h5", "a", libver="v110") as file:
        for group in ("inputs", "source"):
            del file[group]
    code, out, err = run()
    assert (code, "written" in out) == (0, True)
    assert "does not say what it was built from, as those of older versions. It is built anew." in err
    assert set(load(folder / "skin.h5").inputs) == {"skin.toml", "high_speed.dat", "low_speed.dat"}


def test_model_of_another_schema_version_is_replaced(run, folder):
    run()
    with h5py.File(folder / "skin.h5", "a", libver="v110") as file:
        file.attrs["schema_version"] = 0
    code, out, err = run()
    assert (code, "written" in out) == (0, True)
    assert "has schema version 0" in err


def test_output_goes_where_it_is_asked_for(run, folder):
    run("--output", str(folder / "other.h5"))
    assert (folder / "other.h5").exists()
    assert not (folder / "skin.h5").exists()


@pytest.mark.parametrize("name", ["skin.toml", "high_speed.dat", "low_speed.dat", "other_name.dat"])
@pytest.mark.parametrize("options", [(), ("--force",), ("--overwrite",)])
def test_output_never_overwrites_an_input(run, folder, name, options):
    (folder / "other_name.dat").hardlink_to(folder / "low_speed.dat")
    before = (folder / name).read_bytes()
    code, out, err = run("--output", str(folder / name), *options)
    assert (code, out) == (1, "")
    assert f"{name}' is an input of the model and would be overwritten by it. Name another file with --output." in err
    assert (folder / name).read_bytes() == before


@pytest.mark.parametrize("options", [(), ("--force",)])
def test_output_that_is_a_folder_is_one_message(run, folder, options):
    code, out, err = run("--output", str(folder), *options)
    assert (code, out) == (1, "")
    assert err == f"'{folder}' is a folder. Name a file in it, for example --output {folder / 'skin.h5'}.\n"


def test_two_builds_are_equal_to_the_last_bit(folder):
    one, two = arrays(build(folder / "skin.toml")), arrays(build(folder / "skin.toml"))
    assert one.keys() == two.keys()
    for name, value in one.items():
        assert np.array_equal(value, two[name]), name


def test_committed_model_is_what_its_inputs_give():
    committed, fresh = load(MODELS / "skin.h5"), build(MODELS / "skin.toml")
    assert committed.input_hash == fresh.input_hash
    assert committed.nominal == fresh.nominal
    ours, theirs = arrays(committed), arrays(fresh)
    assert ours.keys() == theirs.keys()
    for name, value in ours.items():
        # other versions of numpy and scipy may round differently; the splines amplify that a little
        np.testing.assert_allclose(value, theirs[name], rtol=0, atol=1e-9 * np.abs(value).max(), err_msg=name)


def test_writer_version_is_the_version_of_the_distribution():
    assert tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"] == WRITER_VERSION


def crossing(folder: Path) -> None:
    """Lift the lower side above the upper in the middle of the section."""
    lines = (folder / "high_speed.dat").read_text().splitlines()
    rows = [line.split() for line in lines[1:]]
    nose = min(range(len(rows)), key=lambda i: float(rows[i][0]))
    for row in rows[nose:]:
        if 0.4 < float(row[0]) < 0.6:
            row[1] = str(float(row[1]) + 0.15)
    (folder / "high_speed.dat").write_text("\n".join([lines[0], *(" ".join(row) for row in rows)]) + "\n")


def swapped(folder: Path) -> None:
    edit(folder / "skin.toml", 'start = { x = 137.5, side = "upper" }', 'start = { x = 137.5, side = "lower" }')
    edit(folder / "skin.toml", 'end = { x = 137.5, side = "lower" }', 'end = { x = 137.5, side = "upper" }')


WRONG = {
    "missing airfoil": (
        lambda folder: (folder / "low_speed.dat").unlink(),
        [
            "skin.toml', airfoil.target:",
            "low_speed.dat' cannot be read (No such file or directory, did you mean 'high_speed.dat')",
            "Fix the path",
        ],
    ),
    "unknown key": (
        lambda folder: edit(folder / "skin.toml", "width = 1000.0", "witdh = 1000.0"),
        ["skin.toml'", "section.witdh: unknown key, did you mean 'width'; possible here: thickness, width"],
    ),
    "thickness not positive": (
        lambda folder: edit(folder / "skin.toml", "thickness = 1.5", "thickness = 0.0"),
        ["section.thickness: input should be greater than 0 (given: 0.0)"],
    ),
    "point off the skin by arc length": (
        lambda folder: edit(folder / "skin.toml", "{ node = 10 }", "{ arc_length = 300.0 }"),
        ["interface_points.C: ", "arc length 300 from F is off the skin; admissible: 0 (F) to 291.55"],
    ),
    "point off the skin by x": (
        lambda folder: edit(folder / "skin.toml", "{ node = 10 }", '{ x = 200.0, side = "upper" }'),
        ["interface_points.C: ", "x = 200 on the upper side", "is off the skin"],
    ),
    "point off the skin by node": (
        lambda folder: edit(folder / "skin.toml", "{ node = 10 }", "{ node = 31 }"),
        ["interface_points.C: ", "node 31 is not on the skin: nodes count from 0 (F) to 30 (G)"],
    ),
    "thickness lost in round-off": (
        lambda folder: edit(folder / "skin.toml", "thickness = 1.5", "thickness = 1e-9"),
        ["section.thickness: a thickness of 1e-09 is less than 1e-06 of the skin's length 291.55", "Fix the exponent"],
    ),
    "F and G on one side": (
        lambda folder: edit(folder / "skin.toml", 'side = "lower" }    # G', 'side = "upper" }    # G'),
        ["skin.start, skin.end: ", "Both lie on the upper side; put F on the upper side, G on the lower."],
    ),
    "F and G swapped": (swapped, ["skin.start, skin.end: ", "Exchange F and G"]),
    "self-crossing contour": (crossing, ["airfoil.file: ", "high_speed.dat", "crosses itself"]),
    "x far beyond the section": (
        lambda folder: edit(folder / "skin.toml", "start = { x = 137.5", "start = { x = 1e300"),
        ["skin.start: ", "the upper side does not reach x = 1e+300; it runs from x = 8.4", " to 550."],
    ),
    "x beyond the section": (
        lambda folder: edit(folder / "skin.toml", "start = { x = 137.5", "start = { x = 600.0"),
        ["skin.start: ", "the upper side does not reach x = 600"],
    ),
    "file in percent": (
        lambda folder: edit(folder / "skin.toml", "chord = 550.0", 'chord = 550.0\nunits = "percent"'),
        ["airfoil.file: ", "high_speed.dat", "read as percent of the chord"],
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_input_is_one_plain_message_and_exit_code_1(run, folder, case):
    spoil, texts = WRONG[case]
    spoil(folder)
    code, out, err = run()
    assert (code, out) == (1, "")
    assert "Traceback" not in err
    for text in texts:
        assert text in err
    assert not (folder / "skin.h5").exists()


def test_airfoils_in_millimetres_give_the_same_model(folder):
    reference = build(folder / "skin.toml")
    for name in ("high_speed.dat", "low_speed.dat"):
        title, *rows = (folder / name).read_text().splitlines()
        scaled = [" ".join(f"{550 * float(number):.12f}" for number in row.split()) for row in rows]
        (folder / name).write_text("\n".join([title, *scaled]) + "\n")
    edit(folder / "skin.toml", "chord = 550.0", 'chord = 550.0\nunits = "mm"')
    # twelve decimals of a mm are kept; checks the conversion of units, not the last digits
    np.testing.assert_allclose(build(folder / "skin.toml").mesh.nodes, reference.mesh.nodes, rtol=1e-10, atol=1e-8)


def test_warnings_about_the_airfoil_are_shown(run, folder):
    edit(folder / "high_speed.dat", " 0.993046456  0.001038224", " 0.993046456  0.001038224\n 0.993046456  0.001038224")
    code, _, err = run()
    assert code == 0
    assert "high_speed.dat: " in err


ROUND = "skin.toml: half the thickness (25) exceeds the smallest radius of curvature of the skin (4.93): the inner fibre"
LONG = "skin.toml: the thickness ({}) exceeds the shortest element ({}) {} times: Euler-Bernoulli beams are thin"


@pytest.mark.parametrize(("thickness", "elements", "messages"), [
    (1.5, 30, []), (1.5, 500, []), (5.0, 500, [LONG.format(5, 0.583, 8.57)]), (50.0, 20, [ROUND]),
    (50.0, 30, [ROUND, LONG.format(50, 9.72, 5.14)]),
])  # fmt: skip
def test_warnings_about_a_thick_skin_are_told(folder, thickness, elements, messages):
    edit(folder / "skin.toml", "thickness = 1.5", f"thickness = {thickness}")
    edit(folder / "skin.toml", "elements = 30", f"elements = {elements}")
    told: list[str] = []
    read_geometry(folder / "skin.toml", SkinRecipe.read(folder / "skin.toml").file, told.append)
    assert len(told) == len(messages)
    assert all(text.startswith(message) for text, message in zip(told, messages, strict=True))


def test_folder_that_cannot_be_written_is_reported(run, folder):
    code, _, err = run("--output", str(folder / "none" / "skin.h5"))
    assert code == 1
    assert "cannot be written" in err
    assert "Give a writable place" in err


def test_built_file_holds_only_known_groups(run, folder):
    run()
    with h5py.File(folder / "skin.h5") as file:
        groups = {name for name, item in file.items() if isinstance(item, h5py.Group)}
    names = {
        "invariants",
        "derivatives",
        "affine",
        "elements",
        "element_derivatives",
        "element_affine",
        "sections",
        "section_derivatives",
        "section_affine",
        "interfaces",
        "stress",
        "shape",
        "mesh",
        "nominal",
        "nominal_units",
        "writers",
        "inputs",
        "source",
        "composition",
    }
    assert groups == names


def test_json_says_what_was_built_what_was_remarked_and_what_must_be_asked(run, folder):
    edit(folder / "skin.toml", "density = 2.7e-9", "density = 2700.0")
    code, out, err = run("--json", "--quiet")
    built = json.loads(out)
    assert (code, err, built["built"]) == (0, "", True)
    assert built["file"] == str(folder / "skin.h5")
    assert built["elastic_coordinates"] == load(folder / "skin.h5").n_f
    assert built["interface_points"] == list(load(folder / "skin.h5").interfaces)
    (warning,) = built["warnings"]
    assert "density" in warning
    again = json.loads(run("--json")[1])
    assert again == {**built, "built": False, "remarks": []}  # an old file is as doubtful as it was when new
    assert f"warning: {warning}" in run()[2]


def test_an_error_is_json_too_where_json_was_asked_for(run, folder):
    edit(folder / "skin.toml", "thickness = 1.5", "thickness = -1.5")
    code, out, err = run("--json")
    assert code == 1
    assert json.loads(out)["error"] == err.strip()
    assert "thickness" in err
