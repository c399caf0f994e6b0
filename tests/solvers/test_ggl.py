"""Stabilised index 2: joints closed by positions and velocities at every step, second order in everything, exact gradients."""

from __future__ import annotations

import numpy as np
import pytest

from tests.models.directions import check_states
from tests.models.four_bars import four_bars
from tests.models.scenes import HANGING_DESIGN, hanging_skin
from tests.scenes.test_benchmarks import slider_crank
from tests.solvers.test_orders import DESIGN, SECOND, driven_pendulum, orders
from tests.solvers.test_orders import reference as reference
from tests.solvers.test_orders import system as system
from toolkit.analyses.sensitivity.certificate.certificate import certify
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.sensitivity.preparation import prepare
from toolkit.analyses.transient import simulate
from toolkit.components.loads.gravity import Gravity
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import NeedsDirectError
from toolkit.linear.sparse_analysis import analyse
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Rotation
from toolkit.scene.scene import Scene
from toolkit.solvers.transient.ggl_step import ggl_pattern
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene
from toolkit.validity.energy_balance import energy_balance

PENDULUM_DESIGN = [*DESIGN, "bodies.lower.angular_velocity", "loads.motor.curve.phase"]
CRANK_DESIGN = ["points.T.y", "bodies.crank.inertia", "bodies.rod.mass", "loads.spring.stiffness", "loads.force.force.x"]
ROUND_OFF = 1e-14
"""A few roundings of positions of size 1, and of velocities of size 10."""


def ggl(**changes) -> RunOptions:
    return RunOptions(**{"end_time": 0.8, "step": 0.02, "tolerance": 1e-13, "formulation": "ggl", **changes})


def uneven(steps: int, end: float = 0.8) -> tuple[float, ...]:
    """Times with steps that are alternately long and short, 2 : 1."""
    times = np.append(0, np.cumsum(np.tile([2.0, 1.0], steps // 2)))
    return (*(float(t) for t in times[:-1] * end / times[-1]), end)


def largest_rate(run: Solution) -> float:
    """Largest violation of a joint by velocities, |phi_q v + phi_t|, relative to the model size."""
    system, n_q = run.system, run.system.n_q
    pad = np.zeros(system.n - n_q)
    rates = []
    for time, q, v in zip(run.times, run.q, run.v, strict=True):
        inputs = system.inputs(time, np.array([0.0, 1.0, 0.0]))
        terms = system.evaluate(inputs, np.append(q, pad), np.append(v, pad), np.zeros(system.n))
        rates.append(np.abs(terms.applied[n_q:] * system.weights[n_q:]).max())
    return max(rates)


# --- accuracy -------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rho_inf", [0.0, 0.5, 1.0])
def test_states_joint_forces_and_their_sensitivities_are_of_second_order(system, reference, rho_inf):
    """Also joint forces for rho_inf = 1, where those of index 3 keep an oscillation that nothing damps."""
    for name, order in orders(system, reference, formulation="ggl", rho_inf=rho_inf).items():
        assert order == pytest.approx(2.0, abs=SECOND), name


@pytest.fixture(scope="module")
def exact() -> Solution:
    """A fine run of a pendulum that starts with a spin, in another formulation; its own error is 1e-7."""
    return simulate(
        compile_scene(driven_pendulum(), DESIGN), RunOptions(end_time=0.8, step=0.8 / 12800, rho_inf=1.0, tolerance=1e-13)
    )


@pytest.mark.parametrize("rho_inf", [0.0, 0.5, 1.0])
def test_steps_of_changing_length_keep_the_second_order(exact, rho_inf):
    """Joint forces too where rho_inf damps what every new length excites; for rho_inf = 1 that stays, and is of first order."""
    counts, ours = (200, 400, 800), compile_scene(driven_pendulum(), DESIGN)
    runs = [simulate(ours, ggl(times=uneven(count), rho_inf=rho_inf)) for count in counts]
    for name in ("q", "v", "dq", "dv", "multipliers"):
        errors = [np.abs(getattr(run, name)[-1] - getattr(exact, name)[-1]).max() for run in runs]
        order = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
        expected = 1.0 if name == "multipliers" and rho_inf == 1.0 else 2.0
        assert order == pytest.approx(expected, abs=0.15), name  # the next power of the step contributes


def test_all_formulations_tend_to_the_same_motion():
    """They differ by errors of second order: 16 times less at a quarter of the step."""
    apart = {}
    for step in (4e-3, 1e-3):
        runs = [simulate(compile_scene(driven_pendulum()), ggl(step=step, formulation=f)) for f in ("index-1", "index-3", "ggl")]
        apart[step] = [np.abs(run.q - runs[2].q).max() for run in runs[:2]]
    assert np.divide(apart[4e-3], apart[1e-3]) == pytest.approx(16, rel=0.05)


# --- what it is for -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "options", [{}, {"rho_inf": 1.0}, {"times": uneven(40)}, {"local_error": 1e-4}, {"newton": "modified"}], ids=str
)
def test_joints_are_closed_by_positions_and_velocities_at_every_step(options):
    run = simulate(compile_scene(driven_pendulum()), ggl(**options))
    # what kept factors leave, tolerance (h / T)^2, is a velocity over c_v
    allowed = 1e-12 if options.get("newton") == "modified" else ROUND_OFF
    assert run.drift <= allowed
    assert largest_rate(run) <= allowed


def test_velocities_leave_the_joints_in_other_formulations():
    """What the one above would miss if `largest_rate` always found zero: a violation of second order."""
    for formulation in ("index-1", "index-3"):
        run = simulate(compile_scene(driven_pendulum()), ggl(formulation=formulation, drift_tolerance=1e-2))
        assert largest_rate(run) > 1e-3


def test_energy_of_a_free_pendulum_stays_within_the_error_of_the_step():
    """10 s of chaotic swings without numerical damping: a defect of second order, which does not grow."""
    scene = driven_pendulum().model_copy(update={"loads": {"gravity": Gravity(acceleration=(0.0, -9.81))}})
    for step in (0.004, 0.002):
        run = simulate(compile_scene(scene), ggl(end_time=10.0, step=step, rho_inf=1.0))
        balance, fastest = energy_balance(run), np.abs(run.v[:, [2, 5]]).max()
        defect = np.abs(balance.defect) / (balance.kinetic + balance.strain).max()
        assert defect.max() < (fastest * step) ** 2
        third = len(defect) // 3
        assert defect[-third:].max() < defect[:third].max()


def test_four_bars_pass_singular_positions_as_in_index_1():
    """The mechanism folds ten times; energy and angle are as exact as those of the default formulation, at a coarse step too."""
    for rho_inf in (0.8, 1.0):
        run = simulate(compile_scene(four_bars(2)), ggl(end_time=10.0, step=0.01, rho_inf=rho_inf))
        usual = simulate(compile_scene(four_bars(2)), ggl(end_time=10.0, step=0.01, rho_inf=rho_inf, formulation="index-1"))
        assert run.drift <= ROUND_OFF
        defects = [energy_balance(each).relative_defect for each in (run, usual)]
        assert defects[0] < 1.2 * defects[1]


def noise_of_joint_forces(formulation: str, step: float) -> float:
    """Largest second difference of joint forces, relative to them: on the curve it would be (step x 10/s)^2."""
    run = simulate(
        compile_scene(driven_pendulum()), ggl(end_time=1000 * step, step=step, formulation=formulation, tolerance=1e-12)
    )
    settled = run.multipliers[500:]
    return np.abs(np.diff(settled, n=2, axis=0)).max() / np.abs(settled).max()


def test_joint_forces_stay_quiet_with_tiny_steps():
    """They carry round-off of velocities over the step, 1e-16 x 10 / 1e-7; other formulations that of positions over its square."""
    assert noise_of_joint_forces("ggl", 1e-7) < 1e-7
    assert noise_of_joint_forces("index-1", 1e-7) > 1e-4


# --- gradients ------------------------------------------------------------------------------------------------------------------


def check_against_complex_step(scene: Scene, design: list[str], tolerance: float) -> None:
    """Derivatives of all states, against a complex step through the same accepted steps, relative to the largest of a state."""
    run = simulate(prepare(scene, design))
    for name in ("q", "v", "a", "multipliers"):
        assert np.isfinite(getattr(run, f"d{name}")).all()
    check_states(scene, run, tolerance)


@pytest.mark.parametrize(
    "options",
    [{}, {"rho_inf": 0.0}, {"rho_inf": 1.0, "times": uneven(16)}, {"local_error": 1e-4}, {"newton": "modified"}],
    ids=str,
)
def test_gradients_of_all_states_are_exact(options):
    scene = driven_pendulum().model_copy(update={"solver": ggl(step=0.05, **options)})
    check_against_complex_step(
        scene, PENDULUM_DESIGN, 1e-10
    )  # round-off, multiplied by the condition of the multipliers' equations


def test_gradients_of_a_slider_crank_are_exact():
    scene = slider_crank().model_copy(update={"solver": ggl(end_time=1.0, step=0.05)})
    check_against_complex_step(scene, CRANK_DESIGN, 1e-10)


def test_gradients_of_a_flexible_skin_with_moving_frame_are_exact():
    """Every kind of joint but drivers; the states' round-off is multiplied by the ratio of the skin's stiffnesses, 1e6."""
    scene = hanging_skin(responses={}, solver=ggl(end_time=0.003, step=0.001))
    check_against_complex_step(scene, HANGING_DESIGN, 1e-7)


def test_the_certificate_compares_what_there_is():
    """A complex step, and Taylor's remainder along real changes of the design: W must not follow them."""
    responses = {"angle": Rotation(body="crank", point="O"), "force": JointForce(joint="O", component="magnitude")}
    scene = slider_crank().model_copy(update={"responses": responses, "solver": ggl(end_time=0.5, step=0.05)})
    found = certify(scene, CRANK_DESIGN, "transient")
    assert list(found.differences) == ["complex-step"]
    found.check(1e-11)
    assert all(rate > 1.9 for rate in found.rates.values())


def test_the_adjoint_refuses_and_auto_takes_direct_differentiation():
    responses = {"angle": Rotation(body="crank", point="O")}
    scene = slider_crank().model_copy(update={"responses": responses, "solver": ggl(end_time=0.2, step=0.05)})
    with pytest.raises(NeedsDirectError, match=r"stabilised index 2.*Use the direct method"):
        gradients_by("adjoint", scene, CRANK_DESIGN, "transient")
    assert gradients_by("auto", scene, CRANK_DESIGN, "transient").method == "direct"
    assert gradients_by("adjoint", scene, CRANK_DESIGN, "static").method == "adjoint"


# --- options --------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "message"),
    [({"quasi_static": True}, "leave out one of formulation and quasi_static"), ({"scheme": "paper"}, "index 1")],
)
def test_options_that_do_not_go_with_it_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        ggl(**options)


def test_error_control_keeps_its_promise():
    """Each of a hundred steps or so may err by the part that was asked for, and neighbouring motions part in full swing."""
    fine = simulate(compile_scene(driven_pendulum()), ggl(step=2e-4, rho_inf=1.0))
    errors = []
    for allowed in (1e-4, 1e-5, 1e-6):
        run = simulate(compile_scene(driven_pendulum()), ggl(step=0.1, local_error=allowed))
        assert len(np.unique(np.diff(run.times).round(12))) > 3
        errors.append(np.abs(run.q[-1] - fine.q[-1]).max())
        assert errors[-1] < 10 * run.steps * allowed
    assert errors[0] > errors[1] > errors[2]


# --- the matrix -----------------------------------------------------------------------------------------------------------------


def test_the_pattern_holds_all_products():
    """Against dense matrices with random values at the places of a scene's pattern."""
    system, rng = prepare(hanging_skin(responses={})), np.random.default_rng(1)
    n, n_q, n_lam = system.n, system.n_q, system.n - system.n_q
    pattern = ggl_pattern(system.plan.indptr, system.plan.indices, n_q)
    analyse(pattern.indptr, pattern.indices, n_q)  # refuses a pattern that is not symmetric, sorted, with a full diagonal
    base, S = rng.normal(size=len(pattern.base)), rng.normal(size=len(pattern.row))
    dense = np.zeros((n, n))
    dense[np.repeat(np.arange(n), np.diff(system.plan.indptr)), system.plan.indices] = base
    spread = np.zeros((n_q, n_lam))
    spread[pattern.coordinate, pattern.row] = S
    expected = np.zeros((n + n_lam, n + n_lam))
    expected[:n, :n], expected[n:, :n_q] = dense, dense[n_q:, :n_q]
    expected[:n, n:], expected[n:, n:] = dense[:, :n_q] @ spread, dense[n_q:, :n_q] @ spread
    values, phi_q = np.zeros(len(pattern.indices)), base[pattern.lower]
    values[pattern.base] = base
    values[pattern.position] = phi_q
    np.add.at(values, pattern.bent.place, base[pattern.bent.left] * S[pattern.bent.right])
    np.add.at(values, pattern.closing.place, phi_q[pattern.closing.left] * S[pattern.closing.right])
    found = np.zeros_like(expected)
    found[np.repeat(np.arange(n + n_lam), np.diff(pattern.indptr)), pattern.indices] = values
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13)  # sums of a dozen products of size 1
    assert np.array_equal(pattern.indices[pattern.base], system.plan.indices)
    assert np.array_equal(system.plan.indices[pattern.upper], n_q + pattern.row)


def test_a_change_of_units_changes_nothing_but_round_off():
    """W compares metres with radians, and follows the unit of length exactly."""
    metres = driven_pendulum()
    points = {name: Point(x=1e3 * point.x, y=1e3 * point.y) for name, point in metres.points.items()}
    bodies = {name: rod.model_copy(update={"area": 1e6, "density": 1e-12 * rod.density}) for name, rod in metres.bodies.items()}
    loads = {
        "gravity": Gravity(acceleration=(0.0, -9810.0)),
        "motor": metres.loads["motor"].model_copy(update={"torque": 1300.0}),
    }
    millimetres = Scene(units="mm-t-s", points=points, bodies=bodies, joints=metres.joints, loads=loads)
    one, other = (simulate(compile_scene(scene), ggl(step=0.05)) for scene in (metres, millimetres))
    lengths = np.tile([1e3, 1e3, 1.0], 2)
    # a double pendulum multiplies round-off by some hundreds in 0.8 s
    np.testing.assert_allclose(other.q / lengths, one.q, rtol=0, atol=1e-12)
    np.testing.assert_allclose(other.v / lengths, one.v, rtol=0, atol=1e-11)
