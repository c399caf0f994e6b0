"""The command `ffrf`: purity and keys of its JSON, overrides, numbers of the reference scene, messages and exit codes."""

import json
import re
import shutil
import signal
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from preprocessing.builders.build_model import read_recipe
from preprocessing.commands.cli import app as preprocess
from toolkit.analyses.sensitivity.certificate import certificate
from toolkit.analyses.sensitivity.preparation import evaluate_responses, prepare, solve
from toolkit.analyses.sensitivity.run import run_of
from toolkit.api.model import compile_model
from toolkit.command_line import cli
from toolkit.command_line.announcements import compile_before
from toolkit.command_line.cli import app
from toolkit.command_line.keeping import free_motions_of, solved
from toolkit.command_line.printing import prepare_folder
from toolkit.command_line.run_answer import RunAnswer
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.safe_files import OWN, list_own, listed, own_set
from toolkit.foundation.verdict import finite

ROOT = Path(__file__).parents[2]
SCENE = str(ROOT / "models" / "morphing_wing" / "scene.toml")
MODEL = str(ROOT / "models" / "morphing_wing" / "skin.h5")
RESPONSES = {"max_stress": "MPa", "max_stress_true": "MPa", "shape_rmse": "mm", "shape_max_error": "mm", "drive_angle": "rad"}
VARIABLES = {"t_w", "M_t", "x_A", "y_A", "E"}

CHECK_VALUES = {"max_stress_true": "56.78", "shape_rmse": "0.330", "shape_max_error": "0.564", "drive_angle": "0.503"}
"""Printed with the reference scene; the digits are the tolerance."""


def run(*arguments: str):
    """Run a command in this process: exit_code, stdout, stderr."""
    return CliRunner().invoke(app, list(arguments))


def record(*arguments: str) -> dict:
    """The JSON object of a command that succeeds."""
    done = run(*arguments, "--json")
    assert done.exit_code == 0, done.stderr
    return json.loads(done.stdout)


def refused(*arguments: str) -> str:
    """Message of a command that fails as it should: exit code 1, nothing on standard output, no traceback."""
    done = run(*arguments)
    assert done.exit_code == 1
    assert done.stdout == ""
    assert "Traceback" not in done.stderr
    return done.stderr


@pytest.fixture(scope="module")
def simulated() -> tuple[str, str]:
    """What a motion prints that is started as users start it, and what it imports."""
    command = [sys.executable, "-X", "importtime", "-m", "toolkit.command_line.cli", "simulate", SCENE, "--json"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout, done.stderr


@pytest.mark.parametrize("arguments", [("simulate",), ("statics",), ("sensitivity",), ("sensitivity", "--static")])
def test_json_is_one_object_with_the_promised_keys_and_standard_output_holds_nothing_else(arguments, simulated, capfd):
    if arguments == ("simulate",):
        output, _ = simulated
    else:
        done = run(arguments[0], SCENE, *arguments[1:], "--json")
        assert done.exit_code == 0, done.stderr
        output = capfd.readouterr().out + done.stdout  # what compiled code prints, and what Python does
    found = json.loads(output)  # fails on anything before or after the object
    judged = {"verdict", "warnings", "drift"}
    if "static" not in "".join(arguments):
        judged |= {"energy_balance", "estimated_error", "force_noise", "newton_correction", "start"}
    if arguments != ("simulate",):
        judged.add("geometric_error")  # the wing bends so far that its frame matters to its gradients
    assert set(found) == {"responses", "gradients", "gradient_units", "run", "deformation"} | judged
    assert {name: each["unit"] for name, each in found["responses"].items()} == RESPONSES
    assert all(isinstance(each["value"], float) for each in found["responses"].values())
    assert set(found["run"]) == {"method", "reason", "steps", "newton_iterations", "wall_s"}
    assert set(found["run"]["wall_s"]) == {"primal", "sensitivity"}
    if arguments[0] != "simulate":
        assert set(found["gradients"]) == set(RESPONSES)
        assert all(set(slopes) == VARIABLES for slopes in found["gradients"].values())
        assert all(isinstance(slope, float) for slopes in found["gradients"].values() for slope in slopes.values())


def digits(value: float, printed: str) -> str:
    """The value with as many decimals as the printed one."""
    return f"{value:.{len(printed.partition('.')[2])}f}"


def test_statics_meets_the_check_values_of_the_reference_scene():
    found = record("statics", SCENE)
    values = {name: digits(found["responses"][name]["value"], printed) for name, printed in CHECK_VALUES.items()}
    assert values == CHECK_VALUES


def test_the_lowest_mode_meets_the_check_value_and_modes_ascend():
    frequencies = record("modes", SCENE, "--count", "4")["frequencies"]
    assert digits(frequencies["value"][0], "78") == "78"
    assert len(frequencies["value"]) == 4
    assert frequencies["value"] == sorted(frequencies["value"])


def test_the_motion_ends_in_the_static_state_with_all_steps_counted():
    found = record("simulate", SCENE)
    assert found["run"]["steps"] == 24  # 1.2 s in steps of 0.05 s
    assert digits(found["responses"]["drive_angle"]["value"], "0.503") == "0.503"


@pytest.mark.parametrize("options", [(), ("--static",)])
def test_direct_differentiation_and_complex_step_agree(options):
    """By two variables; by all of them in test_sensitivity, without the command."""
    chosen = (*options, "--variables", "t_w,x_A")
    direct, judge = (record("sensitivity", SCENE, *chosen, "--method", method) for method in ("direct", "complex-step"))
    assert judge["run"]["method"] == "complex-step"
    for name, slopes in judge["gradients"].items():
        for variable, slope in slopes.items():
            # both are exact; what is left is the round-off of a thin skin, see AGREEMENT of test_sensitivity
            assert direct["gradients"][name][variable] == pytest.approx(slope, rel=5e-10), (name, variable)


def test_differences_agree_with_direct_differentiation_to_their_own_accuracy():
    chosen = ("--variables", "t_w,points.D.x")
    direct = record("sensitivity", SCENE, *chosen)["gradients"]["max_stress"]
    # relative steps of 1e-5 and 1e-6: truncation grows with the step, round-off with its inverse
    for method, tolerance in (("central-difference", 1e-3), ("forward-difference", 1e-2)):
        found = record("sensitivity", SCENE, *chosen, "--method", method)["gradients"]["max_stress"]
        assert found == pytest.approx(direct, rel=tolerance)


def test_set_changes_numbers_of_scene_model_and_solver():
    changed = record("simulate", SCENE, "--set", "solver.step=0.1", "--set", "bodies.skin.thickness=1.6")
    assert changed["run"]["steps"] == 12
    slope = record("sensitivity", SCENE, "--variables", "t_w")["gradients"]["drive_angle"]["t_w"]
    moved = changed["responses"]["drive_angle"]["value"] - record("simulate", SCENE)["responses"]["drive_angle"]["value"]
    assert moved == pytest.approx(0.1 * slope, rel=0.2)  # the curvature over 7 % of the thickness


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("points.Q.x=3", "there is no 'Q'; possible here: A, B, D, C, E, G"),
        ("points.A.z=3", "possible here: x, y"),
        ("bodies.body2.area=-3", "bodies.body2.area: .* greater than 0"),
        ("loads.drive.torque=much", "loads.drive.torque: .* number"),
        ("solver.stepp=0.1", "solver.stepp: unknown key, did you mean 'step'"),
        ("points.Dd.x=1", "there is no 'Dd', did you mean 'D'; possible here: A, B"),
        ("solver.step=5", "solver.step = 5 is larger than solver.end_time"),
    ],
)
def test_a_wrong_change_is_refused_with_what_would_be_right(change, message):
    assert re.search(message, refused("simulate", SCENE, "--set", change))


def test_a_change_without_a_value_is_a_usage_error():
    done = run("simulate", SCENE, "--set", "points.A.x")
    assert done.exit_code == 2
    assert "path=value" in done.stderr


def test_a_missing_scene_is_named():
    assert "'nowhere.toml' cannot be read" in refused("statics", "nowhere.toml")


def test_an_unknown_variable_lists_the_available_ones():
    message = refused("sensitivity", SCENE, "--variables", "t_w,chord")
    assert "unknown design variable 'chord'; short names of the scene: t_w, M_t, x_A, y_A, E" in message
    assert "bodies.skin.thickness" in message


def test_a_misspelt_variable_is_guessed():
    assert "unknown design variable 't_ww', did you mean 't_w'; short names" in refused(
        "sensitivity", SCENE, "--variables", "t_ww"
    )


def test_an_error_is_a_json_object_too_where_json_is_asked_for():
    done = run("sensitivity", SCENE, "--variables", "t_ww", "--json")
    assert done.exit_code == 1
    assert json.loads(done.stdout) == {"error": done.stderr.removesuffix("\n")}


@pytest.mark.parametrize(
    ("program", "arguments", "message"),
    [
        (app, ["statics", SCENE, "--nope"], "No such option: --nope"),
        (app, ["sensitivity", SCENE, "--method", "foo"], "Invalid value for '--method': 'foo' is not one of"),
        (app, ["statics", SCENE, "--set", "nothing"], "is not of the form path=value"),
        (app, ["nosuch"], "No such command 'nosuch'"),
        (app, ["new", "solid"], "Missing argument"),
        (preprocess, ["--nope"], "No such option: --nope"),
    ],
)
def test_a_command_line_that_cannot_be_meant_is_a_json_object_too(program, arguments, message):
    done = CliRunner().invoke(program, [*map(str, arguments), "--json"])
    assert done.exit_code == 2
    assert message in json.loads(done.stdout)["error"]


def test_a_wrong_key_is_told_with_its_line_but_not_one_that_the_file_does_not_hold(tmp_path):
    path = tmp_path / "scene.toml"
    text = Path(SCENE).read_text().replace("torque = ", "torqe = ", 1)
    path.write_text(text)
    line = 1 + text[: text.index("torqe")].count("\n")
    message = refused("simulate", str(path))
    assert re.search(rf"scene\.toml: loads\.drive\.torqe: unknown key, did you mean 'torque'.*\(line {line}\)", message)
    assert "(line" not in refused("simulate", SCENE, "--set", "loads.drive.torqu=3")


def test_files_of_the_other_half_of_the_toolkit_are_told_apart():
    skin = str(ROOT / "models" / "morphing_wing" / "skin.toml")
    assert "is a file that a reduced model is built from, not a scene. Build its reduced model with `ffrf-preprocess" in refused(
        "simulate", skin
    )
    study = refused("simulate", str(ROOT / "models" / "morphing_wing" / "study.toml"))
    assert "study.toml is a study of the scene 'scene.toml', not a scene. Give that scene here; `ffrf optimize" in study
    assert "is a folder. Give the path of a scene (.toml) in it" in refused("render", str(MODELS))
    with pytest.raises(
        InputError, match=r"is a scene, not a file that a reduced model is built from\. Analyse it with `ffrf simulate"
    ):
        read_recipe(SCENE)
    for command in ("optimize", "sweep", "uncertainty"):  # what is beside it is named
        told = refused(command, str(MODELS / "morphing_wing" / "scene.toml"))
        assert (
            f"scene.toml is a scene, not a study. Beside it is a study: give {MODELS / 'morphing_wing' / 'study.toml'}." in told
        )
    assert "A study is a file of its own, which begins with scene = 'scene.toml'" in refused(
        "optimize", str(MODELS / "pendulum" / "scene.toml")
    )


@pytest.mark.parametrize("command", [app, preprocess])
def test_both_commands_tell_the_version(command):
    done = CliRunner().invoke(command, ["--version"])
    assert (done.exit_code, done.stdout) == (0, f"ffrf-toolkit {version('ffrf-toolkit')}\n")


def test_an_empty_list_of_variables_lists_the_available_ones():
    assert "bodies.skin.thickness" in refused("sensitivity", SCENE, "--variables", ",")


def test_an_unknown_method_is_a_usage_error_that_lists_the_methods():
    done = run("sensitivity", SCENE, "--method", "guessing")
    assert done.exit_code == 2
    assert "complex-step" in done.stderr


def test_tables_for_people_hold_values_gradients_and_the_distance_of_the_smooth_maximum():
    done = run("sensitivity", SCENE)
    assert done.exit_code == 0
    for text in (*RESPONSES, *VARIABLES, "MPa", "at most ln(n)/rho", "Newton iterations", "24 steps"):
        assert text in done.stdout


def test_a_number_that_does_not_exist_is_null_and_named():
    scene = read_scene(SCENE)
    solution = solve(prepare(scene), "static")
    slopes = {name: {"t_w": np.nan if name == "shape_rmse" else 1.0} for name in RESPONSES}
    found = run_of(solution, evaluate_responses(solution), slopes, "direct", 0.0, 0.0)
    assert any(each.code == "undefined" and "the derivative of shape_rmse by t_w" in each.text for each in found.warnings)
    told = finite(RunAnswer(found, found.verdict).record())
    assert told["gradients"]["shape_rmse"] == {"t_w": None}


def test_inspect_shows_a_reduced_model_with_units_parameters_interfaces_and_derivatives():
    found = record("inspect", MODEL)
    assert found["units"] == "mm-t-s"
    assert found["parameters"]["thickness"] == {"value": 1.5, "unit": "mm"}
    assert found["sizes"]["elastic coordinates"] == 90
    assert found["sizes"]["stress points"] == 120
    assert found["interfaces"]["G"]["arc_length"] == pytest.approx(291.551, abs=5e-4)  # stated with the scene, to its digits
    assert "stiffness" in found["exact_for_every_value"]["youngs_modulus"]
    assert len(found["input_hash"]) == 64
    text = run("inspect", MODEL).stdout
    for part in ("ffrf-reduced-model, version", "thickness: value 1.5, unit mm", "gmsh", "no derivative by the arc length"):
        assert part in text


def test_inspect_shows_the_paths_of_a_scene():
    found = record("inspect", SCENE)
    assert found["design"]["t_w"] == {"path": "bodies.skin.thickness", "value": 1.5}
    assert found["paths"]["points.A.x"] == 72.5
    assert found["responses"]["max_stress"] == {"type": "ks-stress", "unit": "MPa"}


def test_inspect_questions_the_numbers_of_a_scene():
    found = record(
        "inspect", SCENE, "--no-measure", "--set", "loads.drive.torque=1.0", "--set", "bodies.skin.youngs_modulus=70e9"
    )
    assert "unit-of-youngs-modulus" in {each["code"] for each in found["warnings"]}
    assert not found["verdict"]["trusted"]


def test_inspect_prints_the_cost_summary_of_a_scene():
    found = record("inspect", SCENE, "--variables", "t_w", "--no-measure")["cost_summary"]
    assert found["coordinates"][0] == {
        "what": "skin", "kept": 90, "dropped": 3, "why": "grounded frame: it neither moves nor turns",
    }  # fmt: skip
    assert [line["what"] for line in found["derivative blocks (rows of the residual)"]] == ["t_w", "other numbers of the scene"]
    text = run("inspect", SCENE).stdout
    assert "Everything put back takes" in text
    assert "zero damping" in text


def test_inspect_shows_a_scene_that_cannot_be_compiled():
    done = run("inspect", SCENE, "--set", "bodies.skin.thickness=-1")
    assert done.exit_code == 0
    assert "points.A.x: 72.5" in done.stdout
    assert "no cost summary: bodies.skin.thickness = -1 must be a positive number" in done.stdout
    found = record("inspect", SCENE, "--set", "bodies.skin.thickness=-1")
    assert [each["code"] for each in found["warnings"]] == ["cannot-be-compiled"]


def test_keep_all_puts_everything_back_and_gives_the_same_motion():
    lean, whole = record("simulate", SCENE), record("simulate", SCENE, "--keep-all")
    for name, response in lean["responses"].items():
        assert whole["responses"][name]["value"] == pytest.approx(response["value"], rel=1e-8)  # Newton stops at 1e-10


def test_inspect_refuses_what_is_neither(tmp_path):
    foreign = tmp_path / "skin.h5"
    foreign.write_text("no HDF5")
    assert "not an HDF5 file" in refused("inspect", str(foreign))
    assert "there is no reduced model" in refused("inspect", str(tmp_path / "none.h5"))
    airfoil = refused("inspect", str(ROOT / "models" / "morphing_wing" / "high_speed.dat"))
    assert "high_speed.dat' is neither a scene (.toml) nor a reduced model or results (.h5). Give the path" in airfoil
    assert "none.dat' does not exist; it is neither" in refused("inspect", str(tmp_path / "none.dat"))
    assert f"'{tmp_path}' is a folder, neither" in refused("inspect", str(tmp_path))


def test_render_refuses_a_file_as_its_folder_before_it_simulates(tmp_path):
    occupied = tmp_path / "output"
    occupied.write_text("")
    assert "cannot be made a folder" in refused("render", SCENE, "--output", str(occupied))


def test_a_motion_that_is_drawn_is_judged_by_its_values_as_one_that_is_printed():
    """By the local error alone its steps are coarse; by comparison with longer steps they are not for its responses."""
    scene = read_scene(Path(SCENE), {"solver.scheme": "arnold-bruels"})
    drawn = solved(scene, "transient", quiet=True).verdict
    printed = compile_model(scene).simulate()
    assert {each.code for each in printed.solution.verdict.warnings} - {each.code for each in drawn.warnings} == {"coarse-steps"}
    assert drawn.record() == printed.verdict.record()


def test_render_refuses_a_format_that_there_is_not_before_it_simulates(tmp_path):
    assert "no pictures of format 'jpeg'. Take one of png, svg, pdf" in refused(
        "render", SCENE, "--format", "jpeg", "--output", str(tmp_path / "new")
    )
    assert not (tmp_path / "new").exists()


def test_help_and_start_import_nothing_heavy():
    """Not numpy either: `main` tells it to take one thread, which it hears when it is imported."""
    heavy = {"numpy", "numba", "scipy", "h5py", "pyvista", "matplotlib", "gmsh", "preprocessing"}
    code = f"import sys, toolkit.command_line.cli; print(*sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_simulate_imports_no_drawing_and_no_sparse_matrices(simulated):
    """SciPy's parts take a seventh of the command to import; a scene of few unknowns needs none of them."""
    imported = {line.rpartition("|")[2].strip() for line in simulated[1].splitlines() if line.startswith("import time:")}
    packages = {name.partition(".")[0] for name in imported}
    assert {"numba", "scipy"} <= packages
    assert not packages & {"pyvista", "vtk", "vtkmodules", "matplotlib", "gmsh", "preprocessing"}
    assert not imported & {"scipy.sparse", "scipy.linalg", "scipy.optimize"}


@pytest.mark.skipif(sys.platform == "win32", reason="signals of another kind")
def test_an_interrupt_ends_a_command_with_one_line_and_the_code_of_shells(monkeypatch, capsys):
    code = (
        "import os, signal, toolkit.command_line.cli as c; c.read = lambda *_: os.kill(os.getpid(), signal.SIGINT);"
        "signal.signal(signal.SIGINT, signal.default_int_handler); c.main()"  # a process in the background is born deaf to it
    )
    command = [sys.executable, "-c", code, "statics", SCENE]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 128 + signal.SIGINT
    told = "interrupted: files that were finished are kept, none is half written."
    assert done.stderr == f"{told}\n"
    assert done.stdout == ""

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "read", interrupted)
    monkeypatch.setattr(sys, "argv", ["ffrf", "statics", SCENE, "--json"])
    with pytest.raises(SystemExit) as end:
        cli.main()
    assert (end.value.code, json.loads(capsys.readouterr().out)) == (128 + signal.SIGINT, {"error": told})


def test_paths_of_models_start_at_the_scene_not_at_the_working_directory(tmp_path, monkeypatch):
    for file in (SCENE, MODEL):
        shutil.copy(file, tmp_path)
    monkeypatch.chdir("/")
    assert record("inspect", str(tmp_path / "scene.toml"))["units"] == "mm-t-s"
    (tmp_path / "skin.h5").unlink()
    assert "there is no reduced model" in refused("statics", str(tmp_path / "scene.toml"))


def test_quiet_leaves_standard_error_to_errors(tmp_path):
    runner, kept = CliRunner(), str(tmp_path / "run.h5")
    loud = runner.invoke(app, ["statics", str(SCENE), "--output", kept])
    assert "results are in" in loud.stderr
    quiet = runner.invoke(app, ["statics", str(SCENE), "--output", kept, "--quiet"])
    assert quiet.stderr == ""
    assert "max_stress" in quiet.stdout
    assert "cannot be read" in runner.invoke(app, ["statics", "nowhere.toml", "--quiet"]).stderr


@pytest.mark.usefixtures("programs_here")
def test_certify_shows_that_exact_methods_agree_and_where_differences_stop_and_draws_it(tmp_path):
    picture = tmp_path / "certificate.png"
    found = record("certify", SCENE, "--static", "--variables", "t_w,x_A", "--output", str(picture))
    assert picture.read_bytes().startswith(b"\x89PNG")
    for method in ("adjoint", "complex-step"):
        largest = max(value for slopes in found["relative_differences"][method].values() for value in slopes.values())
        assert largest < 5e-10, method  # see AGREEMENT of test_sensitivity
    for response in ("max_stress", "shape_rmse", "drive_angle"):  # the others are maxima, with kinks
        assert found["taylor_rates"][response] == pytest.approx(2.0, abs=0.2)
    best = min(found["central_differences"], key=lambda point: point["largest_relative_difference"])
    assert 1e-7 < best["relative_step"] < 1e-2  # truncation on one side, round-off on the other
    done = CliRunner().invoke(app, ["certify", str(SCENE), "--static", "--variables", "x_A", "--json", "--tolerance", "1e-30"])
    assert (done.exit_code, json.loads(done.stdout)["verified"]) == (1, False)  # one object, though there is an error too


def test_certify_ends_with_an_error_where_exact_methods_disagree(monkeypatch):
    right = certificate.adjoint_gradients
    monkeypatch.setattr(certificate, "adjoint_gradients", lambda *run: (right(*run)[0], (1 + 1e-6) * right(*run)[1]))
    done = CliRunner().invoke(app, ["certify", str(MODELS / "slider_crank" / "scene.toml"), "--variables", "k", *SHORT])
    assert done.exit_code == 1
    assert "agreeing digits: adjoint" in done.stdout
    assert re.search(r"direct differentiation and adjoint disagree on d \w+ / d k", done.stderr)


MODELS = ROOT / "models"
SHORT = ["--set", "solver.end_time=0.05"]


@pytest.mark.parametrize(
    "arguments",
    [
        ["slider_crank", "--static"],  # every gradient is zero by symmetry, but for round-off
        ["pendulum", *SHORT],  # one gradient is zero, another linear
        ["four_bar_chain", *SHORT],
    ],
    ids=["all zero", "one zero", "linkage"],
)
def test_certify_does_not_take_round_off_for_a_disagreement(arguments):
    done = CliRunner().invoke(app, ["certify", str(MODELS / arguments[0] / "scene.toml"), *arguments[1:]])
    assert done.exit_code == 0, done.output
    assert "gradients agree to" in done.stdout
    assert not re.search(r"e\+0[3-9]|e\+[1-9]", done.stdout.partition("central difference")[2])  # zeros are not divided by zeros


def test_certify_takes_every_number_of_a_scene():
    scene = read_scene(MODELS / "four_bar_chain" / "scene.toml")
    found = record(
        "certify", str(MODELS / "four_bar_chain" / "scene.toml"), "--variables", "all", "--set", "solver.end_time=0.01"
    )
    for method in ("adjoint", "complex-step"):
        for response, differences in found["relative_differences"][method].items():
            assert set(differences) == set(scene.available_paths())
            for (
                x,
                difference,
            ) in differences.items():  # round-off, as wherever exact methods are compared, or as much as it leaves
                assert difference < max(1e-9, found["round_off"][response][x]), (method, response, x)
    assert found["taylor_rates"] == pytest.approx({"angle": 2, "kinetic": 2, "height": 2}, abs=0.2)  # not quite asymptotic


def test_certify_refuses_what_is_no_picture_before_the_work(tmp_path):
    assert "End it with .png or .svg" in refused("certify", str(SCENE), "--output", str(tmp_path / "certificate.txt"))
    assert "does not exist" in refused("certify", str(SCENE), "--output", str(tmp_path / "nowhere" / "certificate.png"))


def test_sensitivity_says_which_method_it_chose_and_why():
    found = record("sensitivity", SCENE, "--static")["run"]
    assert (found["method"], found["reason"].startswith("direct differentiation, because")) == ("direct", True)
    assert record("sensitivity", SCENE, "--static", "--method", "adjoint")["run"]["reason"] == ""


def test_a_run_that_keeps_checkpoints_only_says_so_and_has_no_results_to_write(tmp_path):
    small = ("sensitivity", str(SCENE), "--method", "adjoint", "--set", "solver.memory=1e-6")
    done = run(*small)
    assert "24 steps, of which 6 states are kept" in done.stdout
    done = run(*small, "--output", str(tmp_path / "wing.h5"))
    assert done.exit_code == 1
    assert "kept 6 of 25 states" in done.stderr
    assert "drive_angle" in done.stdout


def test_the_first_run_on_a_machine_compiles_with_memory_of_its_own():
    """What a scene allows its states must not stop the two states that compilation needs."""
    compile_before(read_scene(SCENE, {"solver.memory": "1e-9"}), "transient")


def test_certify_without_responses_says_what_is_missing(tmp_path):
    text = (MODELS / "pendulum" / "scene.toml").read_text()
    path = tmp_path / "scene.toml"
    path.write_text(re.sub(r"(?ms)^\[responses\].*?(?=^\[)", "", text))
    assert "the scene needs a table [responses]" in refused("certify", str(path))


@pytest.mark.parametrize(("given", "taken"), [({}, "1"), ({"OPENBLAS_NUM_THREADS": "3"}, "3")])
def test_a_command_takes_one_thread_for_its_small_matrices_unless_told(monkeypatch, given, taken):
    environment, seen = dict(given), []
    monkeypatch.setattr(cli.os, "environ", environment)
    monkeypatch.setattr(cli, "app", lambda: seen.append(environment["OPENBLAS_NUM_THREADS"]))
    cli.main()
    assert seen == [taken]


@pytest.mark.parametrize("options", [("--static", "--film"), ("--static", "--time", "0.5"), ("--free-motions", "--static")])
def test_pictures_of_no_motion_and_options_of_a_motion_are_refused_together(options, tmp_path):
    done = CliRunner().invoke(
        app, ["render", str(MODELS / "morphing_wing" / "scene.toml"), "--output", str(tmp_path / "out"), *options]
    )
    assert done.exit_code == 1
    assert "out, or --static" in done.stderr
    assert not (tmp_path / "out").exists()


def test_free_motions_are_drawn_of_bodies_whose_number_of_frames_runs_choose(tmp_path):
    wing = MODELS / "morphing_wing_large"
    text = (wing / "scene.toml").read_text()
    held = 'A = { type = "revolute", bodies = ["body2", "ground"], point = "A" }'
    assert held in text
    text = text.replace(held, "").replace("../morphing_wing", str(MODELS / "morphing_wing"))
    (tmp_path / "scene.toml").write_text(text)
    found = free_motions_of(tmp_path / "scene.toml", ['bodies.skin.frames="auto"'], None, 1)()
    assert found.names == ("as given", "free motion 1 of 1")


def test_a_folder_keeps_files_that_no_command_has_written(tmp_path):
    (tmp_path / "curves.png").write_text("mine")
    told = refused("render", SCENE, "--output", str(tmp_path))
    assert "curves.png' is there, and ffrf has not written it" in told
    assert [file.name for file in tmp_path.iterdir()] == ["curves.png"]
    (tmp_path / "curves.png").unlink()
    for _ in range(2):  # its own it may replace
        (prepare_folder(tmp_path, "curves.png") / "curves.png").write_text("ours")
    (tmp_path / "history.svg").write_text("mine")
    with pytest.raises(InputError, match=r"history\.svg' is there"):
        prepare_folder(tmp_path, "history.*")


def test_files_of_an_earlier_set_go_and_those_of_others_stay(tmp_path):
    for name in ("step-1.png", "step-2.png", "step-mine.png", "table.csv"):
        (tmp_path / name).write_text("")
    list_own(tmp_path, ["step-1.png", "step-2.png", "table.csv"])
    list_own(tmp_path, ["step-2.png", "step-3.png"], instead_of=["step-*.png"])
    assert sorted(each.name for each in tmp_path.iterdir()) == [OWN, "step-2.png", "step-mine.png", "table.csv"]
    assert listed(tmp_path) == ["step-2.png", "step-3.png", "table.csv"]


def test_a_folder_that_stays_empty_is_gone_when_the_command_ends(tmp_path, monkeypatch):
    ends = []
    monkeypatch.setattr("atexit.register", lambda *call: ends.append(call))
    for used in (False, True):
        folder = prepare_folder(tmp_path / "outer" / "inner", "curves.png")
        assert folder.is_dir()
        if used:
            (folder / "curves.png").write_text("ours")
        for end, *what in ends:
            end(*what)
        assert (tmp_path / "outer").exists() is used


def test_what_fails_before_its_first_file_leaves_no_list_and_no_folder(tmp_path):
    def fail(folder, *written):
        with own_set(folder, ["step-1.png", "step-2.png"]):
            assert listed(folder) == ["step-1.png", "step-2.png"]
            for name in written:
                (folder / name).write_text("ours")
            raise ZeroDivisionError

    for folder, gone in ((tmp_path / "outer" / "inner", tmp_path / "outer"), (tmp_path, tmp_path / OWN)):
        with pytest.raises(ZeroDivisionError):
            fail(folder)
        assert not gone.exists()
    with pytest.raises(ZeroDivisionError):
        fail(tmp_path, "step-1.png")
    assert listed(tmp_path) == ["step-1.png", "step-2.png"]  # the next call may replace it


def test_a_scene_in_place_of_results_and_no_variable_at_all_are_told():
    assert f"Keep those of a scene in a file first: ffrf simulate {SCENE}" in refused("export", SCENE, "--csv", "tables")
    assert "no design variable: --variables names none. Name some with --variables; short names" in refused(
        "sensitivity", SCENE, "--variables", ""
    )


def test_the_command_on_the_page_about_new_ones_runs(tmp_path):
    """A body in the plane has three coordinates, and a distance is one row: as JSON, as tables and as files."""
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "house.md").read_text(encoding="utf-8"), re.DOTALL)
    (page,) = (each for each in blocks if "def size(" in each)
    written: dict = {"__name__": "size_command"}
    exec(compile(page, "house.md", "exec"), written)
    new = typer.Typer()
    new.command()(written["size"])
    arguments = [str(ROOT / "models" / "pendulum" / "scene.toml"), "--output", str(tmp_path)]
    done, told = CliRunner().invoke(new, [*arguments, "--json"]), CliRunner().invoke(new, arguments)
    assert (done.exit_code, told.exit_code) == (0, 0), done.output + told.output
    assert json.loads(done.stdout) == json.loads((tmp_path / "size.json").read_text())
    assert json.loads(done.stdout)["coordinates"] == 3
    assert (tmp_path / "size.csv").read_text().split() == ["what,number", "coordinates,3", "constraint", "rows,1"]
    assert "constraint rows 1 4 unknowns. Trusted: no check" in " ".join(told.stdout.split())
    assert "size.csv" in told.stderr
    assert "size.json are written." in told.stderr
