"""Options of the steps at their extremes: chosen and given steps, motion without inertia, kept factors. Gradients at a limit point and at a
bifurcation are refused in tests/solvers/test_snap_through.py."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from tests.models.scenes import WING
from tests.solvers.test_trades import damped_slider, swinging
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.components.curves.polynomial import Constant
from toolkit.components.curves.table import Table
from toolkit.components.loads.torque import Torque
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import ConvergenceError, SingularSystemError
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene

FORMULATIONS = pytest.mark.parametrize("formulation", ["index-1", "index-3", "ggl"])


@pytest.fixture(scope="module")
def exact() -> np.ndarray:
    """The end of the swinging pendulum: two fine runs whose steps hit all corners, extrapolated; the difference of the two is 1e-7."""
    coarse, fine = (
        simulate(compile_scene(swinging()), RunOptions(end_time=1.0, step=step, rho_inf=1.0, tolerance=1e-13))
        for step in (2e-4, 1e-4)
    )
    return fine.q[-1] + (fine.q[-1] - coarse.q[-1]) / 3


@FORMULATIONS
@pytest.mark.parametrize("allowed", [1e-11, 1e-8, 1e-6, 1e-4, 1e-2, 0.1])
def test_any_local_error_is_kept_or_the_run_refused(exact, allowed, formulation):
    system = compile_scene(swinging(local_error=allowed, formulation=formulation, step=1.0))
    if formulation == "index-1" and allowed >= 1e-2:
        with pytest.raises(ConvergenceError, match="joints came apart"):
            simulate(system)
        return
    run = simulate(system)
    assert run.local_error <= allowed
    # n local errors, n ~ allowed^(-1/3), through a motion that doubles them in a second; what is left of the reference
    assert np.abs(run.q[-1] - exact).max() < 4 * run.steps * allowed + 1e-9
    assert {0.0, 0.113, 0.377, 0.6, 1.0} <= set(run.times)


def test_a_local_error_of_1e_12_is_kept_in_thousands_of_steps():
    options = RunOptions(end_time=0.1, step=0.1, local_error=1e-12, tolerance=1e-13)
    run = simulate(compile_scene(swinging()), options)
    assert run.local_error <= 1e-12
    assert run.steps > 1000  # the third root of it
    assert run.drift < 1e-11


@FORMULATIONS
@pytest.mark.parametrize("allowed", [1e-7, 1e-4])
def test_a_first_step_that_is_a_thousand_times_too_long_is_shortened(allowed, formulation):
    """The wing's whole motion in one step of 1.2 s is asked for; fixed steps of 1 ms make about 1e-7."""
    system = compile_scene(read_scene(WING, {"solver.scheme": "arnold-bruels"}))
    run = simulate(system, RunOptions(end_time=1.2, step=1.2, local_error=allowed, formulation=formulation))
    assert run.local_error <= allowed
    still = solve_statics(system)
    np.testing.assert_allclose(run.q[-1], still.q[0], rtol=0, atol=137 * run.steps * allowed)  # every step's error, of 137 mm


@FORMULATIONS
def test_a_first_step_that_is_a_million_times_shorter_does_no_harm(exact, formulation):
    """Times 0, 1e-8, 0.01, 0.02, ..."""
    system, grid = compile_scene(swinging()), [0.01 * n for n in range(1, 100)]
    plain, other = (
        simulate(system, RunOptions(end_time=1.0, times=(0.0, *first, *grid, 1.0), formulation=formulation))
        for first in ((), (1e-8,))
    )
    errors = [np.abs(run.q[-1] - exact).max() for run in (plain, other)]
    assert errors[1] < 1.2 * errors[0] < 1e-3
    np.testing.assert_allclose(other.multipliers[-1], plain.multipliers[-1], rtol=1e-3)


def short_step(formulation: str, rho_inf: float, ratio: float, often: bool) -> Solution:
    """Steps of 0.01 s with one, or every second, that is shorter by a ratio."""
    times = [0.0]
    for n in range(1, 51):
        times.append(0.01 * n)
        if n < 50 and (often or n == 10):
            times.append(0.01 * (n + 1 / ratio))
    options = RunOptions(end_time=times[-1], times=tuple(times), formulation=formulation, rho_inf=rho_inf)
    return simulate(compile_scene(swinging()), options)


BLOW = pytest.mark.xfail(
    strict=True,
    reason="a tiny step after a long one turns what velocities miss of the constraint into a blow; only local_error tells",
)
SHORT = [(kind, rho_inf, ratio) for kind in ("index-1", "index-3", "ggl") for rho_inf in (0.0, 0.5) for ratio in (10.0, 1e3, 1e6)]


@pytest.mark.parametrize("case", SHORT, ids=str)
def test_short_steps_between_all_long_ones_are_right_or_refused(case):
    right_or_refused(*case, often=True)


@pytest.mark.parametrize("case", SHORT, ids=str)
def test_a_short_step_between_long_ones_is_right_or_refused(case):
    right_or_refused(*case, often=False)


def right_or_refused(formulation: str, rho_inf: float, ratio: float, often: bool) -> None:
    plain = simulate(compile_scene(swinging()), RunOptions(end_time=0.5, step=0.01, formulation=formulation, rho_inf=rho_inf))
    try:
        run = short_step(formulation, rho_inf, ratio, often)
    except (ConvergenceError, SingularSystemError, ValidationError):
        return
    # the error of the equal steps is 3e-3 at rho_inf = 0, and twice that where every long step after a short one begins anew
    np.testing.assert_allclose(run.q[-1], plain.q[-1], rtol=0, atol=1e-2)
    assert np.abs(run.multipliers).max() < 1.5 * np.abs(plain.multipliers).max()


GAPS = [(kind, gap) for kind in ("index-1", "index-3", "ggl") for gap in (1e-3, 1e-5, 1e-8)]
SPIKES = [("index-3", 1e-5), ("index-3", 1e-8)]


@pytest.mark.parametrize(
    ("formulation", "gap"), [pytest.param(*case, marks=BLOW if case in SPIKES else (), id=f"{case}") for case in GAPS]
)
def test_corners_of_a_load_that_lie_close_together_leave_no_spike_in_the_joint_forces(gap, formulation):
    curve = Table(times=(0.1, 0.1 + gap, 0.3, 0.3 + gap, 0.6), values=(0.0, 1.0, 0.5, 0.2, 0.3), interpolation="linear")
    scene = swinging()
    loads = {**scene.loads, "motor": Torque(body="rod", point="O", torque=1.0, curve=curve)}
    system = compile_scene(scene.model_copy(update={"loads": loads}))
    fine = simulate(system, RunOptions(end_time=1.0, step=2e-4, rho_inf=0.5))
    run = simulate(system, RunOptions(end_time=1.0, step=0.2, local_error=1e-5, formulation=formulation))
    np.testing.assert_allclose(run.q[-1], fine.q[-1], rtol=0, atol=4 * run.steps * 1e-5)
    assert np.abs(run.multipliers).max() < 1.05 * np.abs(fine.multipliers).max()


@pytest.mark.parametrize("solver", [{}, {"local_error": 1e-6}, {"times": (0.0, 1e-6, 1.0)}], ids=str)
def test_without_inertia_and_with_constant_loads_nothing_moves(solver):
    options = RunOptions(end_time=1.0, step=0.1, quasi_static=True, **solver)
    run = simulate(compile_scene(damped_slider(Constant(value=1.0))), options)
    np.testing.assert_allclose(run.q[:, 0], 1.0 + 0.3 / 3.0, rtol=1e-14)  # force over stiffness, at once
    np.testing.assert_allclose(run.v, 0, atol=1e-9)  # round-off over the shortest step


def test_a_wing_without_inertia_under_a_constant_torque_rests_where_statics_has_it():
    scene = read_scene(WING, {"solver.scheme": "arnold-bruels"})
    drive = scene.loads["drive"].model_copy(update={"curve": Constant(value=1.0)})
    system = compile_scene(scene.model_copy(update={"loads": {"drive": drive}}), ["t_w", "M_t"])
    still = solve_statics(system)
    run = simulate(system, RunOptions(end_time=1.2, step=0.1, quasi_static=True))
    for name in ("q", "dq", "multipliers", "dmultipliers"):
        expected = getattr(still, name)[0]
        # Newton stops at 1e-10 of 137 mm, or at the round-off of the thin skin
        np.testing.assert_allclose(
            getattr(run, name), [expected] * 13, rtol=0, atol=1e-9 * max(np.abs(expected).max(), 1), err_msg=name
        )


@pytest.mark.parametrize("newton", ["full", "modified"])
def test_one_iteration_is_refused_where_it_is_not_enough(newton):
    with pytest.raises(ConvergenceError, match=r"Newton stopped at t = 0.05 after 1 iterations"):
        simulate(compile_scene(read_scene(WING)), RunOptions(end_time=1.2, step=0.05, newton=newton, max_iterations=1))


@pytest.mark.parametrize("newton", ["full", "modified"])
def test_one_iteration_with_chosen_steps_shortens_them_until_it_is_enough(newton):
    system, options = compile_scene(damped_slider(Constant(value=1.0))), {"end_time": 0.2, "step": 0.01}
    run = simulate(system, RunOptions(newton=newton, max_iterations=1, local_error=1e-6, **options))
    x = np.real(_damped(0.2))
    assert run.q[-1, 0] == pytest.approx(x, abs=run.steps * 1e-6)


def _damped(time: float) -> complex:
    """m x'' + c x' + k (x - 1) = F from rest at 1, m = 2, c = 0.6, k = 3, F = 0.3."""
    root = (-0.6 + 1j * np.sqrt(4 * 2 * 3 - 0.36)) / 4
    # y = F/k (1 - (s_2 e^(s_1 t) - s_1 e^(s_2 t)) / (s_2 - s_1)) with s_2 the conjugate of s_1
    other = np.conj(root)
    return 1 + 0.1 * (1 - (other * np.exp(root * time) - root * np.exp(other * time)) / (other - root))
