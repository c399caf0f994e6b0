"""Steps in which Newton does not converge are halved, with exact gradients through them; what halves do not help keeps its reason."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ffrf
from toolkit.analyses.sensitivity import chosen_frames
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import ConvergenceError
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene
from toolkit.validity.components import told_frictions

MODELS = Path(__file__).parents[2] / "models"
WEIGHT = 'weight = { type = "gravity", acceleration = [0.0, -9810.0] }'
PUSH = 'push = { type = "point-force", body = "skin", point = "E", force = [0.0, -1.0] }'
NAMES = ["t_w", "x_A"]


def wing(load: str, tmp_path: Path, frames: int | str = 10, **options: object) -> Scene:
    """The large morphing wing with one load that acts in full at t = 0."""
    text = (MODELS / "morphing_wing_large" / "scene.toml").read_text()
    text = text.replace("../morphing_wing", str(MODELS / "morphing_wing")).replace("[design]", f"{load}\n\n[design]")
    path = tmp_path / "scene.toml"
    path.write_text(text.replace("frames = 10", f'frames = "{frames}"' if isinstance(frames, str) else f"frames = {frames}"))
    scene = read_scene(path)
    return scene.model_copy(update={"solver": scene.solver.model_copy(update=options)})


@pytest.mark.parametrize("load", [WEIGHT, PUSH], ids=["gravity", "a force"])
def test_a_load_that_sets_in_at_once_is_begun_in_halves_and_told(load, tmp_path):
    run = ffrf.compile(wing(load, tmp_path)).simulate()
    fine = ffrf.compile(wing(load, tmp_path, step=0.01)).simulate()
    assert not fine.solution.halved
    assert run.values["drive_angle"] == pytest.approx(fine.values["drive_angle"], rel=1e-4)
    assert run.values["max_stress"] == pytest.approx(fine.values["max_stress"], rel=1e-3)
    assert run.solution.halved[0] == 0
    (told,) = [caution for caution in run.verdict.warnings if caution.code == "halved-steps"]
    assert repr(load.split()[0]) in told.text
    assert 'solver.start = "equilibrium"' in told.text
    assert run.verdict.trusted


def test_a_start_in_equilibrium_needs_no_halves(tmp_path):
    run = ffrf.compile(wing(WEIGHT, tmp_path, start="equilibrium")).simulate()
    assert run.solution.halved == ()
    assert "halved-steps" not in run.verdict.codes


def test_nothing_is_halved_where_nobody_wants_it_and_no_frame_is_blamed_that_does_not_spin(tmp_path):
    with pytest.raises(
        ConvergenceError, match=r"Newton stopped at t = 0.05 .*'weight' sets in at once.*start = .equilibrium"
    ) as found:
        ffrf.compile(wing(WEIGHT, tmp_path, halvings=0)).simulate()
    assert "critical speed" not in str(found.value)


@pytest.mark.parametrize("scheme", ["paper", "arnold-bruels"])
def test_gradients_are_exact_through_halved_steps(scheme, tmp_path):
    model = ffrf.compile(wing(PUSH, tmp_path, frames=1, end_time=0.05, scheme=scheme), variables=NAMES)
    runs = {method: model.simulate(gradients=method) for method in ("direct", "adjoint", "complex-step")}
    assert {len(run.solution.halved) for run in runs.values()} == {1}
    judge = runs.pop("complex-step")
    for run in runs.values():
        np.testing.assert_array_equal(run.solution.times, judge.solution.times)
        for response in ("max_stress", "drive_angle"):
            own, right = (np.array([each.gradients[response][x] for x in NAMES]) for each in (run, judge))
            np.testing.assert_allclose(own, right, rtol=1e-9)


def test_steps_that_all_fail_are_not_halved_one_after_the_other(tmp_path):
    torque = wing(WEIGHT, tmp_path).with_number("loads.drive.torque", 4.2e9)
    with pytest.raises(ConvergenceError, match=r"Newton stopped at .*Try a smaller solver.step.*(Halved down to|Halves of its)"):
        ffrf.compile(torque).simulate()


def test_a_trial_of_frames_that_fails_is_not_known_and_not_the_end(tmp_path, monkeypatch):
    solve = chosen_frames.solve

    def failing(system, kind):
        if system.scene.bodies["skin"].frames > 2:
            raise ConvergenceError("more frames than two fail")
        return solve(system, kind)

    monkeypatch.setattr(chosen_frames, "solve", failing)
    run = ffrf.compile(wing("", tmp_path, frames="auto")).simulate()
    (told,) = [caution for caution in run.verdict.warnings if caution.code == "frames-not-known"]
    assert "whether they suffice is not known" in told.text
    assert told.doubt


@pytest.mark.parametrize("thickness", [9.8, 9.9])
def test_a_skin_is_doubted_where_half_its_thickness_exceeds_the_radius_of_its_nose(thickness, tmp_path):
    """The section's smallest radius of curvature, by the spline through its points, is 4.93 mm."""
    verdict = ffrf.compile(wing("", tmp_path, frames=2).with_number("bodies.skin.thickness", thickness)).statics().verdict
    assert ("folded-skin" in verdict.codes) == (thickness > 2 * 4.93)
    assert verdict.trusted == (thickness < 2 * 4.93)


SLOPE = """units = "m-kg-s"
points.B = [0.0, 0.0]
bodies.block = { type = "rigid", mass = 2.0, center = "B", inertia = 0.01 }
joints.slope = { type = "slider", bodies = ["block", "ground"], point = "B", axis = [1.0, 0.0], lock_rotation = true }
loads.push = { type = "point-force", body = "block", point = "B", force = [3.0, 0.0] }
responses.x = { type = "displacement", body = "block", point = "B", component = "x" }
solver = { end_time = 1.0, step = 0.01 }

[loads.friction]
type = "sliding-friction"
bodies = ["block", "ground"]
point = "B"
axis = [1.0, 0.0]
level = 5.0
"""


def test_a_friction_whose_width_sets_the_step_is_named_with_its_time(tmp_path):
    """Below its width d it is a damper F / d, which stops the mass m in m d / F = 4e-6 s; a step of 0.01 s would do with 0.025 m/s."""
    path = tmp_path / "slope.toml"
    path.write_text(SLOPE + "width = 1e-5\n")
    system = compile_scene(read_scene(path))
    told = told_frictions(system, system.start()[0], 0.01)
    assert "width of 1e-05 m/s loads.friction stops what moves in 4e-06 s" in told
    assert "widen it to 0.025 m/s, or take steps of 4e-06" in told
    assert told_frictions(system, system.start()[0], 3e-6) == ""
