"""A run judges itself: what Python, JSON and the terminal say about whether its numbers can be trusted."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import ffrf
from tests.random_scenes.scene import named_scene
from tests.random_scenes.strained import strained_scene
from toolkit.analyses.modes import solve_modes
from toolkit.analyses.sensitivity.adjoint import adjoint
from toolkit.analyses.sensitivity.certificate.certificate import Certificate, DisagreementError, NothingVerifiedError, certify
from toolkit.analyses.sensitivity.direct import direct, numerical
from toolkit.analyses.sensitivity.errors.step_error import step_error
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.command_line.cli import app
from toolkit.description.run_options import RunOptions
from toolkit.files.results_file import load_results, save_results
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.responses.motion import Displacement
from toolkit.responses.response import Partials
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene

MODELS = Path(__file__).parents[2] / "models"
PENDULUM, WING, BEAM = (MODELS / name / "scene.toml" for name in ("pendulum", "morphing_wing", "rotating_beam"))
FOUR_BAR = PENDULUM.parents[1] / "four_bar_chain" / "scene.toml"
WRONG = {"solver.step": "0.2", "solver.formulation": "index-3", "solver.rho_inf": "0.8"}
"""A rod force of 1134.7 N instead of 28.29 N."""


def test_a_verdict_says_doubts_first_and_each_once():
    remark, doubt = Caution("b", "remarkable", doubt=False), Caution("a", "doubtful")
    found = Verdict.of([remark, doubt, doubt], {"drift": float("inf")})
    assert found.warnings == (doubt, remark)
    assert (found.trusted, found.reasons, found.codes) == (False, ("doubtful",), ("a", "b"))
    assert Verdict.of([remark]).trusted
    assert found.record()["drift"] is None  # JSON knows no infinity
    again = Verdict.from_record(json.loads(json.dumps(found.record())))
    assert (again.warnings, again.trusted) == (found.warnings, found.trusted)


def test_python_json_and_the_terminal_say_the_same_about_a_wrong_pendulum():
    """In the text alone, before; JSON gave 1134.7 N and no word."""
    changes = [part for path, value in WRONG.items() for part in ("--set", f"{path}={value}")]
    found = direct(read_scene(PENDULUM, WRONG), [], "transient")
    assert found.values["rod_force"] > 1000
    assert {"energy", "steps"} <= set(found.verdict.codes)
    done = CliRunner().invoke(app, ["simulate", str(PENDULUM), *changes, "--json"])
    record = json.loads(done.stdout)
    assert record["verdict"] == {"trusted": False, "reasons": list(found.verdict.reasons)}
    assert [each["text"] for each in record["warnings"]] == [each.text for each in found.warnings]
    assert record["energy_balance"]["created"] > 0.5
    assert {"drift", "newton_correction", "estimated_error"} <= set(record)
    assert set(record["estimated_error"]["responses"]) == set(found.values)
    table = CliRunner().invoke(app, ["simulate", str(PENDULUM), *changes]).stdout
    assert all(reason in text for text in (done.stderr, table) for reason in found.verdict.reasons)
    assert f"Codes: {', '.join(found.verdict.codes)}. What they mean: docs/doubts.md." in table
    assert "4 %" in found.verdict.explained["energy"].limit


def test_a_motion_that_its_steps_resolve_is_trusted():
    found = direct(read_scene(PENDULUM, {"solver.end_time": "1.0"}), ["m"], "transient")
    assert found.verdict.trusted, found.verdict
    assert max(found.step_error.values.values()) < 1e-3


def test_estimated_errors_are_those_against_a_much_finer_run():
    """Second order: the estimate is right to a factor of two, where it is small."""
    changes = {"solver.end_time": "0.8", "solver.step": "0.01"}
    found = direct(read_scene(PENDULUM, changes), ["g_y"], "transient")
    fine = direct(read_scene(PENDULUM, changes | {"solver.step": "0.0004"}), ["g_y"], "transient")
    for name in ("move_x", "rod_force"):
        true = abs(found.values[name] - fine.values[name]) / abs(fine.values[name])
        assert 0.5 * true < found.step_error.values[name] < 2 * true + 1e-6


def estimated(response, slope=lambda _: 0.0, options=None) -> Mapping[str, float]:
    """Errors that are estimated for a motion of 64 steps whose value and derivative are functions of the length of the step."""
    given = options or RunOptions(end_time=1.0, step=1 / 64)
    run: Any = SimpleNamespace(whole_run=[n / 64 for n in range(65)], options=given, halved=())

    def repeat(other: RunOptions):
        return {"f": response(other.step)}, {"f": {"x": slope(other.step)}}

    found = step_error(run, {"f": response(1 / 64)}, {"f": {"x": slope(1 / 64)}}, {"f": 1.0}, {"f": {"x": 0.0}}, repeat)
    assert found is not None
    return {"value": found.values["f"], "slope": found.gradients["f"]["x"]}


def test_richardsons_rule_is_exact_for_errors_of_one_order():
    assert estimated(lambda h: 1 + 3 * h**2)["value"] == pytest.approx(3 / 64**2, rel=1e-9)
    first = RunOptions(end_time=1.0, step=1 / 64, scheme="paper", rho_inf=0.5)
    assert estimated(lambda h: 1 + 3 * h, options=first)["value"] == pytest.approx(3 / 64, rel=1e-9)
    assert estimated(lambda h: 1.0, lambda h: 2 + h**2)["slope"] == pytest.approx(1 / 64**2 / (2 + 1 / 64**2), rel=1e-9)


def test_chosen_steps_that_their_own_limit_keeps_short_are_halved_with_it():
    """The error that is allowed chooses none of them: a run with a smaller one alone would be the same run."""
    chosen = RunOptions(end_time=1.0, step=1 / 64, local_error=1.0)
    assert estimated(lambda h: 1 + 200 * h**2, options=chosen)["value"] == pytest.approx(200 / 64**2, rel=1e-9)


def test_two_runs_that_agree_by_chance_are_betrayed_by_the_third():
    assert estimated({1 / 64: 1.0, 1 / 32: 1.0, 1 / 16: 1.09}.__getitem__)["value"] == pytest.approx(0.09 / 12)


def test_where_longer_steps_leave_a_doubt_half_the_step_says_how_wrong_it_is():
    """Far from the limit longer steps say 8 %, shorter ones 0.4 %."""
    told = estimated({1 / 256: 1.00375, 1 / 128: 1.003, 1 / 64: 1.0, 1 / 32: 1.0, 1 / 16: 2.0}.__getitem__)
    assert told["value"] == pytest.approx(0.003 / 0.75)


def test_a_shorter_step_that_agrees_by_chance_is_betrayed_by_a_still_shorter_one():
    runs = {1 / 256: 1.4, 1 / 128: 1.003, 1 / 64: 1.0, 1 / 32: 2.0, 1 / 16: 3.0}
    assert estimated(runs.__getitem__)["value"] == pytest.approx(0.4 / (1 - 1 / 16))


def test_a_value_that_is_small_where_the_motion_ends_is_told_to_be_off_by_more_of_itself():
    """Kinetic energy 1.30 J after up to 60 J in the motion, 1.557 J in truth."""
    changes = {"solver.end_time": "2", "solver.step": "0.01", "solver.rho_inf": "0"}
    found = direct(read_scene(FOUR_BAR, changes), ["g_y"], "transient")
    (remark,) = [each for each in found.verdict.warnings if each.code == "small-numbers"]
    assert not remark.doubt
    assert "kinetic" in remark.text
    assert found.step_error.own_values["kinetic"] == pytest.approx(1.557 / 1.297 - 1, rel=0.3)  # an estimate


def test_where_no_longer_step_works_a_shorter_one_tells():
    def response(h: float) -> float:
        if h > 1 / 64:
            raise InputError("too long")
        return 1 + 3 * h**2

    assert estimated(response)["value"] == pytest.approx(3 / 64**2, rel=1e-9)


@pytest.mark.parametrize("method", [adjoint, direct, lambda *a: numerical(*a, "central-difference")])
def test_gradients_that_the_steps_do_not_resolve_are_doubted_whatever_the_method(method):
    found = method(read_scene(PENDULUM, {"solver.step": "0.2", "solver.drift_tolerance": "1.0"}), ["g_y"], "transient")
    assert "gradient-steps" in found.verdict.codes
    fine = method(read_scene(PENDULUM, {"solver.step": "0.002", "solver.end_time": "0.2"}), ["g_y"], "transient")
    assert "gradient-steps" not in fine.verdict.codes, fine.verdict


def test_trusted_gradients_that_are_off_by_some_percent_have_a_remark_with_their_size():
    """Against steps a tenth as long, relative to the largest derivative in the motion."""
    coarse, fine = (direct(read_scene(PENDULUM, {"solver.step": step}), ["g_y"], "transient") for step in ("0.025", "0.0025"))
    (remark,) = [each for each in coarse.verdict.warnings if each.code == "rough-gradients"]
    assert not remark.doubt
    told = {name: float(part) / 100 for name, part in re.findall(r"(\w+) by g_y by about ([\d.]+)%", remark.text)}
    off = {
        name: abs(coarse.gradients[name]["g_y"] - fine.gradients[name]["g_y"]) / coarse.gradient_scales[name]["g_y"]
        for name in coarse.gradients
    }
    assert told.keys() == {name for name, error in off.items() if error > 0.05}
    assert told == pytest.approx({name: off[name] for name in told}, rel=0.2)  # fourth-order terms of a second-order error of 8 %
    assert "rough-gradients" not in fine.verdict.codes


@pytest.mark.parametrize(("seed", "code"), [(81035, "added-errors"), (83026, "rough-gradients")])
def test_errors_by_steps_and_by_frames_that_are_small_one_by_one_are_told_with_their_sum(seed, code, tmp_path):
    """Against a run with twice the elements, a frame to each, and steps a tenth as long."""
    _, scene, fine = strained_scene(seed, tmp_path)
    run = ffrf.compile(scene, variables=list(scene.design)).simulate(gradients=True)
    steps = {"step": scene.solver.end_time / (10 * run.solution.steps), "local_error": None, "times": None}
    finer = fine.model_copy(update={"solver": fine.solver.model_copy(update=steps)})
    true = ffrf.compile(finer, variables=list(scene.design)).simulate(gradients=True)
    (told,) = [each for each in run.verdict.warnings if each.code == code]
    assert told.doubt == (code == "added-errors")
    parts = {name: float(part) / 100 for name, part in re.findall(r"([\w ]+) by about ([\d.]+)%", told.text)}
    off = {f: abs(true.values[f] - value) / run.scales[f] for f, value in run.values.items()}
    for f, slopes in run.gradients.items():
        for x, slope in slopes.items():
            scale = max(run.gradient_scales[f][x], abs(slope))
            off[f"the derivative of {f} by {x}"] = abs(true.gradients[f][x] - slope) / scale
    known = {name: off[name.strip()] for name in parts}
    assert parts == pytest.approx(known, rel=0.2)
    assert min(known.values()) > 0.05
    assert not {"large-deformation", "steps"} & set(run.verdict.codes)


def test_a_gradient_of_little_effect_counts_where_it_is_far_from_the_largest_in_the_motion(tmp_path):
    """A stress by the velocity of another body: shapes that the reduced body leaves out change it by a seventh.

    With all shapes of its elements the derivative is 262 instead of 149, as of the run with four times as many elements, and a
    fortieth of what one is whose variable changes the stress by all of it.
    """
    _, scene = named_scene(82068, tmp_path)
    run = ffrf.compile(scene, variables=list(scene.design)).simulate(gradients=True)
    error = run.frame_errors.gradients["smooth_body2"]["x0"]
    assert error == pytest.approx(261.7 - run.gradients["smooth_body2"]["x0"], rel=0.2)
    (told,) = [each for each in run.verdict.warnings if each.code == "geometric-gradients"]
    assert told.doubt
    assert "smooth_body2 by x0" in told.text


@pytest.mark.parametrize("seed", [52, 56])
def test_an_angle_that_is_zero_by_symmetry_is_not_doubted_for_its_round_off(seed, tmp_path):
    """Derivatives of 1e-39 and 1e-16 that other steps change by a fifth."""
    scene = named_scene(seed, tmp_path)[1]
    found = direct(scene, list(scene.design), "transient")
    assert abs(found.values["turn_block"]) < 1e-12
    assert "gradient-steps" not in found.verdict.codes


TWINS = """units = "m-kg-s"
points = { P = [0.0, 0.0], Q = [-0.36, 0.93] }
[bodies]
one = { type = "rigid", mass = 2.0, inertia = 0.5, center = "P" }
two = { type = "rigid", mass = 2.0, inertia = 0.5, center = "Q" }
[joints]
first = { type = "slider", bodies = ["one", "ground"], point = "P", axis = [0.93, 0.36], lock_rotation = true }
second = { type = "slider", bodies = ["two", "ground"], point = "Q", axis = [0.93, 0.36], lock_rotation = true }
[loads]
weight = { type = "gravity", acceleration = [-9.1, -3.6] }
between = { type = "spring-damper", bodies = ["one", "two"], points = ["P", "Q"], stiffness = 100.0, damping = 3.0 }
left = { type = "spring-damper", bodies = ["one", "ground"], points = ["P", "Q"], stiffness = 100.0, damping = 3.0 }
right = { type = "spring-damper", bodies = ["two", "ground"], points = ["Q", "P"], stiffness = 100.0, damping = 3.0 }
[responses]
power = { type = "power", load = "between" }
work = { type = "work", load = "between" }
across = { type = "distance", bodies = ["one", "two"], points = ["P", "Q"], component = "x" }
[solver]
end_time = 1.0
step = 0.01
"""


def test_works_that_are_zero_by_symmetry_are_not_doubted_for_their_round_off(tmp_path):
    """Two blocks side by side: the spring between them is turned by round-off alone, some 1e-28 of works and powers of the others."""
    (tmp_path / "scene.toml").write_text(TWINS)
    found = direct(read_scene(tmp_path / "scene.toml"), ["bodies.one.mass"], "transient")
    assert 0 < abs(found.values["work"]) < 1e-20
    assert found.verdict.trusted, found.verdict


def test_solutions_carry_a_verdict_too():
    found = simulate(compile_scene(read_scene(PENDULUM, WRONG)))
    assert {"energy", "coarse-steps"} <= set(found.verdict.codes)
    assert not Solution(*[None] * 10).verdict.trusted  # nobody looked


def test_a_beam_beyond_its_critical_speed_is_doubted_in_python():
    scene = read_scene(BEAM, {"solver.end_time": "0.1", "bodies.beam.angular_velocity": "120.0"})
    assert {"critical-speed", "large-deformation"} <= set(direct(scene, [], "transient").verdict.codes)


def test_a_files_verdict_is_that_of_its_run(tmp_path):
    found = direct(read_scene(PENDULUM, WRONG), [], "transient")
    save_results(found, tmp_path / "run.h5")
    assert load_results(tmp_path / "run.h5").verdict.reasons == found.verdict.reasons
    shown = CliRunner().invoke(app, ["inspect", str(tmp_path / "run.h5")])
    assert found.verdict.reasons[0] in shown.stdout
    exported = CliRunner().invoke(app, ["export", str(tmp_path / "run.h5"), "--csv", str(tmp_path / "tables"), "--json"])
    assert json.loads(exported.stdout)["verdict"]["trusted"] is False


@pytest.mark.parametrize("analysis", [direct, adjoint, lambda *a: numerical(*a, "forward-difference")])
def test_a_wrong_word_for_the_analysis_is_refused(analysis):
    """`statics` ran the motion, `dynamic` passed; a text for the variables was split into its letters."""
    scene = read_scene(PENDULUM, {"solver.end_time": "0.01"})
    for word in ("statics", "dynamic"):
        with pytest.raises(InputError, match=f"no analysis '{word}'. Choose one of: transient, static"):
            analysis(scene, ["m"], word)
    with pytest.raises(InputError, match="a list of names, not the text 'm'"):
        analysis(scene, "m", "transient")


def test_differences_betray_what_all_exact_methods_share():
    scene = read_scene(PENDULUM, {"solver.end_time": "0.2", "solver.step": "0.02"})
    point = {"body": "bob", "point": "P"}
    height = Displacement(**point, component="y")

    class Half(Displacement):
        """A displacement whose real part alone is seen."""

        kind = "half-blind-displacement-of-a-test"

        def instants(self, solution: Solution) -> Callable[[int], Partials]:
            """No partial derivatives."""
            look = super().instants(solution)
            return lambda step: Partials(np.real(look(step).value) + 0 * solution.q[step, 0])

    blind = scene.model_copy(update={"responses": {"seen": height, "unseen": Half(**point, component="y")}})
    found = certify(blind, ["g_y"], "transient")
    assert found.differences["complex-step"]["unseen"]["g_y"] == 0  # zero by all of them
    with pytest.raises(DisagreementError, match="gradient of unseen is contradicted by central differences"):
        found.check(1e-8)
    assert found.quotients["seen"].slope == pytest.approx(found.along["seen"], rel=1e-8)


def test_a_certificate_that_verifies_nothing_is_a_failure():
    """ "0 gradients agree to - digits", with exit code 0, before."""
    exact: Any = SimpleNamespace(gradients={"f": {"x": 1.0}})
    lost = Certificate(exact, {"adjoint": {"f": {"x": 0.3}}}, {"f": {"x": 1.0}}, {"f": 2.0}, [])
    with pytest.raises(NothingVerifiedError, match="no gradient was verified"):
        lost.check(1e-8)
    Certificate(exact, {"adjoint": {"f": {"x": 1e-9}}}, {"f": {"x": 1.0}}, {"f": 2.0}, []).check(1e-8)


SPRING = """
units = "m-kg-s"
points = { O = [0.0, 0.0], P = [1.0, 0.0] }
bodies = { b = { type = "rigid", mass = 1.0, inertia = 1.0, center = "P" } }
loads = { k = { type = "spring-damper", bodies = ["b", "ground"], points = ["P", "O"], stiffness = 10.0, length = 0.2 } }
design = { L = "loads.k.length" }
responses = { x = { type = "displacement", body = "b", point = "P", component = "x" } }
solver = { end_time = 2.0, step = 0.002 }
[joints]
x = { type = "slider", bodies = ["b", "ground"], point = "P", axis = [1.0, 0.0], lock_rotation = true }
"""


def test_a_spring_that_passes_length_zero_is_doubted_and_no_certificate_confirms_its_gradients(tmp_path):
    """Its force jumps: dx/dL = -1.73 by all exact methods, -3.82 by the closed form of the two oscillations."""
    (tmp_path / "scene.toml").write_text(SPRING)
    scene = read_scene(tmp_path / "scene.toml")
    found = certify(scene, ["L"], "transient")
    assert {"spring-through-zero", "differences"} <= {each.code for each in found.verdict.warnings if each.doubt}
    before = direct(
        scene.with_number("solver.end_time", 0.4), ["L"], "transient"
    )  # omega t = 1.3, x = 1 - 0.8 (1 - cos(omega t)) > 0
    assert "spring-through-zero" not in before.verdict.codes
    relaxed = direct(scene.with_number("loads.k.length", 0.0), [], "transient")
    assert "spring-through-zero" not in relaxed.verdict.codes


@pytest.mark.parametrize(("damping", "doubt"), [(0.0, None), (0.6, False), (6.0, True)])
def test_modes_tell_that_dampers_are_not_in_them(tmp_path, damping, doubt):
    """zeta = c / (2 sqrt(k m)): 0.095 and 0.95."""
    (tmp_path / "scene.toml").write_text(SPRING.replace("stiffness = 10.0", f"stiffness = 10.0, damping = {damping}"))
    scene = read_scene(tmp_path / "scene.toml")
    found = solve_modes(solve_statics(compile_scene(scene))).verdict
    assert [each.doubt for each in found.warnings if each.code == "damped"] == ([] if doubt is None else [doubt])
    if damping:
        assert f"up to {damping / (2 * np.sqrt(10.0)):.2g} of" in str(found)
        assert f"that at {np.sqrt(10.0) / (2 * np.pi):.4g} Hz" in str(found)
