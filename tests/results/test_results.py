"""Results files: what is read is what was computed, the scene comes back, and no damaged file gets through."""

import csv
import json
import shutil
from dataclasses import fields, replace

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

from tests.models.scenes import HANGING_DESIGN, MODELS, WING, hanging_skin
from toolkit.analyses.sensitivity.direct import direct, evaluated, numerical
from toolkit.analyses.sensitivity.preparation import ANALYSES, evaluate_responses, prepare, solve
from toolkit.analyses.sensitivity.run import restored
from toolkit.command_line.cli import app
from toolkit.description.results_layout import BODY, STATES, ResultsFileError
from toolkit.files.results import restore_scene, table_of
from toolkit.files.results_file import load_results, save_results
from toolkit.files.scene_reader import read_scene, scene_from_table
from toolkit.files.tables import export_csv
from toolkit.foundation.errors import InputError, ToolkitError
from toolkit.foundation.files.safe_files import safe_name
from toolkit.responses.shape_error import shape_error, shape_error_history
from toolkit.responses.stress import stress_field


@pytest.fixture(scope="module")
def wing(tmp_path_factory):
    """The wing's motion with derivatives beside a copy of its model: result, and path of the file."""
    folder = tmp_path_factory.mktemp("wing")
    for name in ("scene.toml", "skin.h5"):
        shutil.copy(MODELS / name, folder)
    found = direct(read_scene(folder / "scene.toml"), ["t_w", "points.D.x"], "transient")
    save_results(found, folder / "run.h5", WING.read_text(), {"a.path": "1"})
    return found, folder / "run.h5"


@pytest.fixture
def copy(wing, tmp_path):
    """A copy of the file that a test may spoil, with its model."""
    shutil.copy(wing[1].parent / "skin.h5", tmp_path)
    return shutil.copy(wing[1], tmp_path / "copy.h5")


def same(a, b):
    """Whether two values are the same, arrays entry by entry with nan equal to nan."""
    return np.array_equal(a, b, equal_nan=a.dtype.kind == "f") if isinstance(a, np.ndarray) else a == b


def test_what_is_read_is_what_was_computed(wing):
    found, path = wing
    read, solution = load_results(path), found.solution
    for name in STATES:
        assert same(getattr(read, name), getattr(solution, name)), name
    assert [*read.coordinates, *read.multiplier_names] == list(solution.system.numbering.names)
    assert read.design == ["t_w", "points.D.x"]
    assert (read.responses, read.response_units, read.gradients) == (found.values, found.units, found.gradients)
    assert read.variables["t_w"] == {"path": "bodies.skin.thickness", "value": 1.5}
    stress, dstress = stress_field(solution, "skin")
    assert same(read.bodies["skin"].stress, stress)
    assert same(read.bodies["skin"].dstress, dstress)
    assert len(set(read.bodies["skin"].stress_points)) == stress.shape[1]
    assert read.scene.text == WING.read_text()
    assert read.scene.changes == {"a.path": "1"}
    assert (read.settings["step"], read.unit("stress"), read.kind, read.method) == (0.05, "MPa", "transient", "direct")


@pytest.mark.parametrize("kind", ["static", "transient"])
def test_saving_what_was_read_changes_nothing(kind, tmp_path):
    scene = hanging_skin() if kind == "transient" else read_scene(WING)
    first = save_results(direct(scene, HANGING_DESIGN[:1] if kind == "transient" else [], kind), tmp_path / "first.h5")
    again = load_results(save_results(load_results(tmp_path / "first.h5"), tmp_path / "again.h5").path)
    assert first.kind == again.kind == kind
    for item in fields(first):
        if item.name not in ("bodies", "path", "scene"):
            assert same(getattr(again, item.name), getattr(first, item.name)), item.name
    for name in BODY:
        assert same(getattr(again.bodies["skin"], name), getattr(first.bodies["skin"], name)), name
    assert again.scene.table == first.scene.table
    assert again.scene.models == first.scene.models


def test_a_run_without_a_file_is_kept_too(tmp_path):
    found = evaluated(solve(prepare(read_scene(WING)), "transient"), gradients=False)
    read = load_results(save_results(found, tmp_path / "run.h5").path)
    assert read.gradients == {}
    assert read.dq.shape == (25, 102, 0)
    assert read.responses["max_stress"] == pytest.approx(56.78, abs=5e-3)  # the reference value's digits
    assert read.scene.sha256 == ""


def test_gradients_by_differences_are_kept_without_derivatives_of_the_states(tmp_path):
    found = numerical(read_scene(WING), ["t_w"], "transient", "forward-difference")
    read = load_results(save_results(found, tmp_path / "run.h5").path)
    assert (read.method, read.design, read.gradients) == ("forward-difference", [], found.gradients)
    assert read.bodies["skin"].dstress.shape == (25, 120, 0)
    assert list(read.variables) == ["t_w"]
    assert restored(read).solution.system.n_x == 0


def test_the_error_along_the_skin_at_any_time_is_that_of_a_run_that_ends_there(wing):
    solution = wing[0].solution
    error, derror = shape_error_history(solution, "skin")
    # the same steps give the same states; sums are taken in another order
    assert error[-1] == pytest.approx(shape_error(solution, "skin")[0], rel=1e-12)
    shorter = direct(read_scene(WING, {"solver.end_time": "0.6"}), ["t_w", "points.D.x"], "transient").solution
    expected = shape_error(shorter, "skin")
    assert error[12] == pytest.approx(expected[0], rel=1e-9)
    assert derror[12] == pytest.approx(expected[1], rel=1e-9, nan_ok=True)


@pytest.mark.parametrize("scene", [read_scene(WING), hanging_skin()], ids=["wing", "hanging skin"])
def test_a_scene_survives_the_way_through_its_table(scene):
    table = json.loads(json.dumps(table_of(scene)))
    assert scene_from_table(table, scene.directory / "scene.toml") == scene


def test_the_restored_scene_is_the_changed_one(tmp_path):
    scene = read_scene(WING, {"solver.step": "0.1"}).with_number("bodies.skin.thickness", 1.6)
    found = direct(scene, ["t_w"], "transient")
    kept = save_results(found, tmp_path / "run.h5")
    again = direct(restore_scene(kept), ["t_w"], "transient")
    assert again.values == found.values
    assert again.gradients == found.gradients


def test_the_restored_solution_has_all_that_the_first_had(wing):
    found, path = wing
    again = restored(load_results(path)).solution
    assert again.system.design == found.solution.system.design
    # nothing is solved again: the responses of the stored states are the stored ones to the last bit
    assert evaluate_responses(again) == found.values


def test_a_project_can_be_moved_as_a_whole(wing, tmp_path):
    shutil.copytree(wing[1].parent, tmp_path / "elsewhere")
    read = load_results(tmp_path / "elsewhere" / "run.h5")
    assert restore_scene(read).directory.resolve() == (tmp_path / "elsewhere").resolve()


def test_a_model_that_changed_or_vanished_is_refused(copy):
    read = load_results(copy)
    model = copy.parent / "skin.h5"
    with h5py.File(model, "a", libver="v110") as file:
        file.attrs["note"] = "another file"
    with pytest.raises(ResultsFileError, match=r"is not the one that 'copy\.h5' was computed with.*Run the scene again"):
        restore_scene(read)
    model.unlink()
    with pytest.raises(ResultsFileError, match=r"is not there\. Name its folder"):
        restore_scene(read)
    assert restore_scene(read, MODELS).directory == MODELS


def test_a_complex_run_is_refused(tmp_path):
    scene = read_scene(WING, {"solver.end_time": "0.05"}).with_number("bodies.skin.thickness", 1.5 + 1e-30j)
    with pytest.raises(InputError, match="complex"):
        save_results(evaluated(solve(prepare(scene), "transient"), gradients=False), tmp_path / "run.h5")
    with pytest.raises(InputError, match="complex"):
        table_of(scene)
    assert list(tmp_path.iterdir()) == []


def test_only_results_files_are_written_over(tmp_path):
    for path, message in [
        (tmp_path / "none" / "run.h5", "there is no folder"),
        (tmp_path / "run.csv", r"does not end in \.h5"),
        (shutil.copy(MODELS / "skin.h5", tmp_path), "is not a results file; it is left as it is"),
    ]:
        done = CliRunner().invoke(app, ["simulate", str(WING), "--output", str(path)])
        assert done.exit_code == 1
        with pytest.raises(ResultsFileError, match=message):
            raise ResultsFileError(done.stderr)
    assert (tmp_path / "skin.h5").read_bytes() == (MODELS / "skin.h5").read_bytes()


def test_an_interrupted_write_leaves_the_old_file(wing, tmp_path, monkeypatch):
    results = load_results(wing[1])
    save_results(results, tmp_path / "run.h5")
    before = (tmp_path / "run.h5").read_bytes()

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("toolkit.files.results_file._write_gradients", interrupted)
    with pytest.raises(KeyboardInterrupt):
        save_results(results, tmp_path / "run.h5")
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [before]


def delete(name):
    return lambda file: file.__delitem__(name)


def put(name, data):
    def change(file):
        del file[name]
        file[name] = data

    return change


def claim(file):
    """A dataset that says it is large and holds nothing."""
    del file["q"]
    file.create_dataset("q", shape=(10**6, 10**6), chunks=(1000, 1000), dtype=float)


def edit(**changes):
    def change(file):
        about = json.loads(file["about"][()]) | changes
        del file["about"]
        file["about"] = np.bytes_(json.dumps(about).encode())

    return change


def elsewhere(file):
    del file["q"]
    file["q"] = h5py.ExternalLink("run.h5", "v")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda file: file.attrs.__setitem__("schema", np.bytes_(b"another")), "holds no results"),
        (lambda file: file.attrs.__setitem__("schema_version", 99), "has schema version 99"),
        (delete("q"), "lacks q"),
        (delete("about"), "lacks about"),
        (delete("bodies/skin/stress"), "lacks bodies/skin/stress"),
        (delete("names/design"), "lacks names/design"),
        (put("v", np.zeros((3, 102))), "does not fit the other arrays"),
        (put("times", np.zeros((25, 2))), "instead of numbers with 1"),
        (put("times", np.full(25, np.nan)), "not finite"),
        (put("bodies/skin/stress", np.full((25, 120), np.inf)), "not finite"),
        (put("q", np.bytes_(b"text")), "instead of numbers"),
        (put("names/coordinates", np.array([b"one"])), "instead of 102 names"),
        (put("about", np.bytes_(b"{")), "damaged or incomplete: Expecting property name"),
        (put("about", np.zeros(3)), "instead of a text"),
        (edit(responses=3), "responses"),
        (edit(kind="adventurous"), "kind"),
        (edit(gradients={"max_stress": {}}), "different names"),
        (edit(variables={}, gradients={}), "unknown variables"),
        (edit(bodies=["fuselage"]), "lacks bodies/fuselage/stress"),
        (claim, "which are not in the file"),
        (elsewhere, "which are not in the file|cannot be read|lacks q"),
    ],
)
def test_a_file_that_does_not_make_sense_is_refused_with_what_to_do(copy, wing, change, message):
    shutil.copy(wing[1], copy.parent / "run.h5")
    with h5py.File(copy, "a", libver="v110") as file:
        change(file)
    with pytest.raises(ResultsFileError, match=message) as caught:
        load_results(copy)
    assert "copy.h5" in str(caught.value)
    assert "Run the scene again" in str(caught.value) or "Give a file" in str(caught.value)


def test_missing_foreign_and_truncated_files_are_refused(copy):
    with pytest.raises(ResultsFileError, match="there is no results file"):
        load_results(copy.parent / "none.h5")
    with pytest.raises(ResultsFileError, match=r"no file '.*copy\.hh', did you mean '.*copy\.h5'. A scene is a \.toml file"):
        load_results(copy.parent / "copy.hh")
    with pytest.raises(ResultsFileError, match=r"there is no file 'nowhere/scene'\. A scene"):
        load_results("nowhere/scene")
    with pytest.raises(ResultsFileError, match="holds no results"):
        load_results(copy.parent / "skin.h5")
    whole = copy.read_bytes()
    for size in np.linspace(0, len(whole) - 1, 60).astype(int):
        copy.write_bytes(whole[:size])
        with pytest.raises(ResultsFileError, match=r"damaged|holds no results"):
            load_results(copy)


def test_a_flipped_bit_is_refused_or_was_nowhere_of_importance(copy, wing):
    whole, rng = copy.read_bytes(), np.random.default_rng(7)
    results = load_results(copy)
    structure, anywhere = rng.integers(0, 8000, 100), rng.integers(0, len(whole), 100)
    for place in [*structure, *anywhere]:
        spoilt = bytearray(whole)
        spoilt[place] ^= 1 << int(rng.integers(8))
        copy.write_bytes(spoilt)
        try:
            found = load_results(copy)
        except ResultsFileError:
            continue
        # checksums guard structure and arrays; the few words that have none are checked by what they say
        assert all(same(getattr(found, name), getattr(results, name)) for name in STATES)


def rows(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.reader(file))


def test_tables_hold_the_numbers_to_the_last_bit_under_names_with_units(wing, tmp_path):
    results = load_results(wing[1])
    files = {file.name: rows(file) for file in export_csv(results, tmp_path / "tables")}
    head, *lines = files["stress_skin.csv"]
    assert head[:2] == ["time in s", "element 0, start, outer in MPa"]
    assert same(np.array(lines, float), np.column_stack([results.times, results.bodies["skin"].stress]))
    assert files["coordinates.csv"][0][1:] == results.coordinates
    assert same(np.array(files["velocities.csv"][1:], float)[:, 1:], results.v)
    assert same(np.array(files["stress_skin_by_points.D.x.csv"][1:], float)[:, 1:], results.bodies["skin"].dstress[:, :, 1])
    assert files["responses.csv"][0] == ["response", "value", "unit", "derivative by t_w", "derivative by points.D.x"]
    assert float(files["responses.csv"][1][3]) == results.gradients["max_stress"]["t_w"]


def test_tables_replace_those_of_an_earlier_export_and_nothing_else(wing, tmp_path):
    results = load_results(wing[1])
    kept = {file.name for file in export_csv(results, tmp_path)}
    without = {file.name for file in export_csv(replace(results, bodies={}), tmp_path)}
    assert "stress_skin.csv" in kept - without
    assert {file.name for file in tmp_path.glob("*.csv")} == without
    (tmp_path / "stress_skin.csv").write_text("mine")
    with pytest.raises(InputError, match=r"stress_skin\.csv' is there, and ffrf has not written it"):
        export_csv(results, tmp_path)


def test_names_of_files_cannot_leave_their_folder():
    assert "/" not in safe_name("../../etc/passwd")


def test_paraview_reads_the_deformed_skin_with_stress_and_its_derivatives(wing, tmp_path):
    pyvista = pytest.importorskip("pyvista")
    from toolkit.render.paraview import export_paraview

    results = load_results(wing[1])
    reader = pyvista.get_reader(export_paraview(restored(results).solution, tmp_path / "series"))
    assert reader.time_values == results.times.tolist()
    shapes = []
    for step in (0, 24):
        reader.set_active_time_point(step)
        skin, mechanism = reader.read()
        # a coordinate is written with all its digits; the extremes of a linear field are at the ends of the elements
        stress = results.bodies["skin"].stress[step]
        assert skin["stress in MPa"].max() == pytest.approx(stress.max(), rel=1e-12)
        assert skin["stress by t_w"].min() == pytest.approx(results.bodies["skin"].dstress[step, :, 0].min(), rel=1e-12)
        assert mechanism.n_points == 8  # four rods
        shapes.append(skin.points)
    assert np.abs(shapes[1] - shapes[0]).max() > 1.0  # mm; the skin moves by several


def run(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_commands_keep_results_that_inspect_render_and_export_take(tmp_path, monkeypatch):
    path = tmp_path / "run.h5"
    done = run("sensitivity", WING, "--set", "solver.step=0.1", "--variables", "t_w", "--output", path, "--json")
    assert done.exit_code == 0
    printed = json.loads(done.stdout)  # where the results are is said on standard error
    assert "ffrf inspect" in done.stderr
    told = json.loads(run("inspect", path, "--json").stdout)
    assert {name: each["value"] for name, each in told["responses"].items()} == {
        name: each["value"] for name, each in printed["responses"].items()
    }
    assert told["gradients"] == printed["gradients"]
    assert (told["times"]["steps"], told["scene"]["changes"], told["derivatives_of_states_by"]) == (12, "solver.step=0.1", "t_w")
    assert "stress points 120" in run("inspect", path).stdout
    exported = run("export", path, "--csv", tmp_path / "csv", "--models", MODELS)
    assert exported.exit_code == 0
    assert len(rows(tmp_path / "csv" / "coordinates.csv")) == 14

    def forbidden(*_, **__):
        raise AssertionError("the run was repeated")

    drawn = []
    for kind in ANALYSES:
        monkeypatch.setitem(ANALYSES, kind, forbidden)
    monkeypatch.setattr("toolkit.render.pictures.render_solution", lambda solution, *_: drawn.append(solution) or [])
    assert run("render", path, "--output", tmp_path / "pictures").exit_code == 0
    assert same(drawn[0].q, load_results(path).q)


def test_commands_refuse_what_makes_no_sense_with_results(wing, tmp_path):
    path = wing[1]
    for arguments, message in [
        (("export", path), "nothing to export"),
        (("render", path, "--set", "solver.step=0.1"), "--set cannot change"),
        (("render", WING, "--models", MODELS), "--models belongs to a results file"),
        (("render", MODELS / "skin.h5"), "holds no results"),
    ]:
        done = run(*arguments)
        assert done.exit_code == 1
        assert message in done.stderr


def test_every_error_of_a_results_file_is_one_of_the_program():
    assert issubclass(ResultsFileError, ToolkitError)


def test_results_of_another_numbering_are_refused(wing):
    results = load_results(wing[1])
    with pytest.raises(ResultsFileError, match="other unknowns"):
        restored(replace(results, coordinates=results.coordinates[::-1]))
