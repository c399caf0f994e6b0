"""The hard neighbour of the reference wing in motion: resolved by steps that are fine or chosen, refused or called coarse otherwise."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import ConvergenceError, LimitPointError
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene

WING = Path(__file__).parents[2] / "models" / "snap_through" / "scene.toml"
ANGLE = "rotation of body 'body2'"


def motion(**changes: str) -> Solution:
    return simulate(compile_scene(read_scene(WING, {f"solver.{name}": value for name, value in changes.items()})))


def angle(solution: Solution, times: np.ndarray) -> np.ndarray:
    """Of the driven rod, at any times."""
    return np.interp(times, solution.times, solution.q[:, solution.system.numbering.names.index(ANGLE)])


def limit_time() -> float:
    """When the load curve s(t) = t^3 (10 - 15 t + 6 t^2) reaches the limit load of statics."""
    with pytest.raises(LimitPointError) as found:
        solve_statics(compile_scene(read_scene(WING)))
    return next(r.real for r in np.roots([6, -15, 10, 0, 0, -found.value.load_factor]) if r.imag == 0 and 0 < r.real < 1)


@pytest.fixture(scope="module")
def fine() -> Solution:
    return motion(step="5e-5")


def test_chosen_steps_follow_the_snap_on_the_branch_of_a_fine_fixed_step(fine):
    chosen = motion(step="0.05", local_error="1e-5")
    before, after = np.linspace(0, 0.76, 50), np.linspace(0.83, 1.2, 400)
    # before the snap, at t = 0.77, the motion is nearly one of equilibria; the load's own vibration is 1e-4
    np.testing.assert_allclose(angle(chosen, before), angle(fine, before), atol=2e-4)
    # after it the wing rings without damping about the equilibrium beyond the snap: phases differ after dozens of periods, means hardly
    assert angle(chosen, after).mean() == pytest.approx(angle(fine, after).mean(), abs=0.01)
    beyond = solve_statics(compile_scene(read_scene(WING, {"solver.continuation": "arc-length"})))
    settled, waiting = beyond.q[0, beyond.system.numbering.names.index(ANGLE)], angle(fine, np.array([0.76]))[0]
    assert abs(angle(chosen, after).mean() - settled) < 0.3 * abs(waiting - settled)  # a large swing is not symmetric
    assert len(chosen.times) < len(fine.times) / 5
    assert chosen.local_error <= 1e-5


@pytest.mark.parametrize("step", ["0.1", "0.05"])
def test_coarse_steps_are_refused(step):
    # such a motion explodes: which of the two is seen first is chance
    with pytest.raises(
        ConvergenceError, match=r"(Newton stopped|the joints came apart).* t = .*Try a (smaller solver.step|tenth of it)"
    ):
        motion(step=step)


@pytest.mark.parametrize("step", ["0.02", "0.01"])
def test_steps_that_fail_in_the_snap_are_halved_there_and_called_coarse(fine, step):
    found = motion(step=step)
    assert all(0.7 < time < 0.9 for time in found.halved)
    assert np.diff(found.times).max() == pytest.approx(float(step))
    before = np.linspace(0, 0.7, 50)
    np.testing.assert_allclose(angle(found, before), angle(fine, before), atol=2e-3)
    assert any("steps are coarse" in reason for reason in found.verdict.reasons)
    assert "halved-steps" in found.verdict.codes


@pytest.mark.parametrize("changes", [{"step": "0.005"}, {"step": "0.01", "formulation": "index-3"}], ids=str)
def test_steps_that_come_through_without_resolving_the_snap_are_called_coarse(changes):
    found = motion(**changes)
    assert found.local_error > 1e-2  # 1 % of the model size in one step
    assert any("steps are coarse" in reason for reason in found.verdict.reasons)


def test_a_fine_step_is_not_called_coarse(fine):
    assert "coarse-steps" not in fine.verdict.codes


def test_without_inertia_the_run_ends_at_the_limit_point_of_statics():
    with pytest.raises(ConvergenceError, match=r"t = 0\.\d+") as found:
        motion(step="0.05", local_error="1e-3", quasi_static="true")
    time = float(str(found.value).split("t = ")[1].split(" ")[0].rstrip(":"))
    assert time == pytest.approx(limit_time(), abs=2e-6)  # six printed digits
