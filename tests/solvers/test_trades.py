"""What a run can trade: formulation of the joints, kept factors, inertia, chosen and given steps; each with its order and its gradients."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from tests.models.directions import check_states
from tests.models.scenes import HANGING_DESIGN, WING, hanging_skin
from tests.solvers.test_orders import DESIGN, driven_pendulum
from toolkit.analyses.sensitivity.adjoint import adjoint
from toolkit.analyses.sensitivity.certificate.certificate import certify
from toolkit.analyses.sensitivity.direct import direct, numerical
from toolkit.analyses.sensitivity.preparation import frozen, prepare, solve
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.rigid import Rigid, Rod
from toolkit.components.curves.combined import Sum
from toolkit.components.curves.oscillation import Sine
from toolkit.components.curves.polynomial import Constant
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.curves.table import Table
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.point_force import PointForce
from toolkit.components.loads.springs import SpringDamper
from toolkit.components.loads.torque import Torque
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import ConvergenceError, InputError
from toolkit.responses.motion import Rotation
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene
from toolkit.validity.energy_balance import energy_balance

UNEVEN = tuple(0.05 * np.round(np.cumsum([0, *np.tile([1, 2, 0.5], 4)]), 12))
"""Times of steps that change their length every time."""
WING_CHANGES = {"solver.scheme": "arnold-bruels"}


def uneven(steps: int, end: float = 0.8) -> tuple[float, ...]:
    """Times with steps that are alternately long and short, 2 : 1."""
    times = np.append(0, np.cumsum(np.tile([2.0, 1.0], steps // 2)))
    return (*(float(t) for t in times[:-1] * end / times[-1]), end)


@pytest.fixture(scope="module")
def exact() -> Solution:
    """A fine run in another formulation and with another rho_inf; its own error is 1e-7."""
    return simulate(
        compile_scene(driven_pendulum(), DESIGN), RunOptions(end_time=0.8, step=0.8 / 12800, rho_inf=1.0, tolerance=1e-13)
    )


def fitted_orders(exact: Solution, steps: tuple[int, ...], options) -> dict[str, float]:
    """Order of the error at the end of the motion, by halved steps."""
    errors = {name: [] for name in ("q", "v", "dq", "dv")}
    for count in steps:
        run = simulate(compile_scene(driven_pendulum(), DESIGN), options(count))
        for name, found in errors.items():
            found.append(np.abs(getattr(run, name)[-1] - getattr(exact, name)[-1]).max())
    return {name: -np.polyfit(np.log(steps), np.log(found), 1)[0] for name, found in errors.items()}


@pytest.mark.parametrize(
    ("formulation", "rho_inf"), [("index-1", 0.0), ("index-1", 0.5), ("index-1", 1.0), ("index-3", 0.0), ("index-3", 0.5)]
)
def test_steps_of_changing_length_keep_the_second_order(exact, formulation, rho_inf):
    def options(count: int) -> RunOptions:
        times = uneven(count)
        return RunOptions(end_time=0.8, times=times, formulation=formulation, rho_inf=rho_inf, tolerance=1e-13)

    for name, order in fitted_orders(exact, (200, 400, 800), options).items():
        assert 1.85 < order < 3.1, name  # the next power of the step contributes, mostly to the better


@pytest.mark.parametrize("rho_inf", [0.0, 0.5, 0.8])
def test_index_3_is_of_second_order_and_keeps_joints_closed_to_round_off(exact, rho_inf):
    def options(count: int) -> RunOptions:
        return RunOptions(end_time=0.8, step=0.8 / count, formulation="index-3", rho_inf=rho_inf, tolerance=1e-13)

    for name, order in fitted_orders(exact, (200, 400, 800), options).items():
        assert 1.85 < order < 2.4, name
    assert simulate(compile_scene(driven_pendulum()), options(100)).drift <= 1e-14  # a few roundings of positions of size 1


@pytest.mark.parametrize(
    "options",
    [
        {"formulation": "index-3"},
        {"formulation": "index-3", "rho_inf": 0.8},
        {"newton": "modified"},
        {"times": UNEVEN},
        {"times": UNEVEN, "formulation": "index-3", "rho_inf": 0.0},
        {"times": UNEVEN, "scheme": "paper"},
        {"local_error": 1e-4},
        {"local_error": 1e-4, "formulation": "index-3", "newton": "modified"},
    ],
    ids=str,
)
def test_gradients_of_all_states_are_exact(options):
    """Against a complex step of all numbers through the same accepted steps."""
    scene, design = driven_pendulum(), [*DESIGN, "bodies.lower.angular_velocity", "loads.motor.curve.phase"]
    end = UNEVEN[-1] if "times" in options else 0.8
    run_options = RunOptions(end_time=end, step=0.05, tolerance=1e-13, drift_tolerance=1e-2, **options)
    scene = scene.model_copy(update={"solver": run_options})
    run = simulate(compile_scene(scene, design))
    check_states(scene, run, 1e-10)  # round-off, multiplied by the condition of the multipliers' equations


@pytest.mark.parametrize(
    "options",
    [
        {"formulation": "index-3"},
        {"newton": "modified", "tolerance": 1e-13},
        {"quasi_static": True},
        {"times": (0.0, 0.05, 0.15, 0.2, 0.3, 0.4)},
    ],
    ids=str,
)
def test_the_wings_gradients_agree_by_all_exact_methods(options):
    scene = read_scene(WING, {"solver.scheme": "arnold-bruels", "solver.step": "0.1"})
    scene = scene.model_copy(update={"solver": RunOptions(**{**dict(scene.solver), "end_time": 0.4, **options})})
    exact = direct(scene, ["t_w", "x_A"], "transient")
    steady = frozen(scene, exact.solution)
    others = adjoint(scene, ["t_w", "x_A"], "transient"), numerical(steady, ["t_w", "x_A"], "transient", "complex-step")
    for other in others:
        for response, slopes in exact.gradients.items():
            for x, slope in slopes.items():
                # 1e-9: the wing's round-off, as for its other runs; shape errors are differences of nearly equal positions
                assert other.gradients[response][x] == pytest.approx(
                    slope, rel=2e-8 if scene.solver.newton == "modified" else 5e-9
                )


@pytest.mark.parametrize(
    "changes", [{"times": (0.0, 0.001, 0.003, 0.004, 0.0045, 0.006, 0.008, 0.01)}, {"formulation": "index-3"}]
)
def test_the_adjoint_in_windows_follows_every_kind_of_step(changes):
    scene = hanging_skin()
    solver = {**dict(scene.solver), "scheme": "arnold-bruels", "end_time": 0.01, "tolerance": 1e-13, **changes}
    scene = scene.model_copy(update={"solver": RunOptions(**solver)})
    whole = direct(scene, HANGING_DESIGN[:3], "transient").gradients
    small = scene.model_copy(update={"solver": scene.solver.model_copy(update={"memory": 1e-6})})
    windows = adjoint(small, HANGING_DESIGN[:3], "transient").gradients
    for response, slopes in whole.items():
        largest = max(map(abs, slopes.values()))
        for x, slope in slopes.items():
            assert windows[response][x] == pytest.approx(slope, rel=1e-7, abs=1e-9 * largest)  # round-off of the skin's stiffness


@pytest.mark.parametrize("changes", [{"local_error": 1e-5}, {"local_error": 1e-3, "quasi_static": True, "step": 0.2}], ids=str)
def test_chosen_steps_of_the_wing_are_differentiated_alike_forwards_and_backwards(changes):
    scene = read_scene(WING, WING_CHANGES)
    scene = scene.model_copy(update={"solver": RunOptions(**{**dict(scene.solver), **changes})})
    exact, other = (method(scene, ["t_w", "x_A"], "transient") for method in (direct, adjoint))
    for response, slopes in exact.gradients.items():
        for x, slope in slopes.items():
            assert other.gradients[response][x] == pytest.approx(slope, rel=5e-9)  # round-off of the thin skin


def test_kept_factors_lead_to_the_same_motion_in_fewer_factorizations():
    full, modified = (
        solve(prepare(read_scene(WING, {**WING_CHANGES, "solver.newton": kind})), "transient") for kind in ("full", "modified")
    )
    # Newton's tolerance is 1e-10 of the model size, which is 80 mm
    np.testing.assert_allclose(modified.q, full.q, atol=1e-7)
    assert modified.newton_iterations > full.newton_iterations  # linear instead of quadratic convergence: it did keep them


def damped_slider(curve, **solver) -> Scene:
    """A block on a rail, held by a spring and a damper, pushed by a force."""
    return Scene(
        units="m-kg-s",
        points={"P": Point(x=1.0, y=0.0), "W": Point(x=0.0, y=0.0)},
        bodies={"block": Rigid(mass=2.0, inertia=1.0, center="P")},
        joints={"rail": Slider(bodies=("block", "ground"), point="P", axis=(1.0, 0.0), lock_rotation=True)},
        loads={
            "spring": SpringDamper(bodies=("block", "ground"), points=("P", "W"), stiffness=3.0, damping=0.6),
            "push": PointForce(body="block", point="P", force=(0.3, 0.0), curve=curve),
        },
        solver=RunOptions(**solver),
    )


def test_without_inertia_a_damped_spring_creeps_to_its_force_in_first_order():
    """c x' + k x = F: x = F/k (1 - exp(-k t / c)) for a force that is there at once, from rest at time 0 just before it."""
    errors = []
    for steps in (200, 400, 800):
        # the force rises within the first thousandth of the motion
        scene = damped_slider(Table(times=(0.0, 1e-4), values=(0.0, 1.0), interpolation="linear"), quasi_static=True)
        times = (0.0, 1e-4, *(1e-4 + 0.5 * n / steps for n in range(1, steps + 1)))
        run = simulate(compile_scene(scene), RunOptions(quasi_static=True, end_time=times[-1], times=times))
        exact = 0.1 * (1 - np.exp(-5.0 * (times[-1] - 0.5e-4)))
        errors.append(abs(run.q[-1, 0] - 1.0 - exact))
    assert errors[-1] < 1e-4
    assert np.log2(errors[0] / errors[2]) / 2 == pytest.approx(1.0, abs=0.1)


def test_a_quasi_static_wing_is_in_equilibrium_at_every_time():
    scene = read_scene(WING, {**WING_CHANGES, "solver.quasi_static": "true"})
    run = simulate(compile_scene(scene, ["t_w", "x_A"]))
    for step in (5, 10, len(run.times) - 1):
        options = scene.solver.model_copy(update={"end_time": float(run.times[step])})
        state = solve_statics(compile_scene(scene, ["t_w", "x_A"]), options)
        np.testing.assert_allclose(run.q[step], state.q[0], atol=1e-8)  # Newton's tolerance, 1e-10 of 80 mm
        np.testing.assert_allclose(run.dq[step], state.dq[0], atol=1e-6 * np.abs(state.dq[0]).max())
    assert not np.any(run.a)


def test_the_work_done_on_a_quasi_static_wing_is_its_strain_energy_to_second_order():
    def defect(step: str) -> float:
        scene = read_scene(WING, {**WING_CHANGES, "solver.quasi_static": "true", "solver.step": step})
        return energy_balance(simulate(compile_scene(scene))).relative_defect

    assert np.log2(defect("0.05") / defect("0.025")) == pytest.approx(2.0, abs=0.3)  # the next power of the step


def test_a_quasi_static_run_refuses_to_jump():
    """A shallow arch of two springs is pushed through: there is no equilibrium near the limit point."""
    scene = Scene(
        units="m-kg-s",
        points={"P": Point(x=0.0, y=0.2), "L": Point(x=-1.0, y=0.0), "R": Point(x=1.0, y=0.0)},
        bodies={"apex": Rigid(mass=1.0, inertia=1.0, center="P")},
        joints={"guide": Slider(bodies=("apex", "ground"), point="P", axis=(0.0, 1.0), lock_rotation=True)},
        loads={
            "left": SpringDamper(bodies=("apex", "ground"), points=("P", "L"), stiffness=100.0),
            "right": SpringDamper(bodies=("apex", "ground"), points=("P", "R"), stiffness=100.0),
            "push": PointForce(body="apex", point="P", force=(0.0, -2.0), curve=SmoothStep(duration=1.0)),
        },
        solver=RunOptions(end_time=1.0, step=0.01, quasi_static=True),
    )
    # the spring force 2 k y (l_0 / l - 1) has its largest value, 0.3 N, at 0.117 m: 15 % of the load
    with pytest.raises(ConvergenceError, match=r"jumps at t = 0\.\d+: .*limit point|Newton stopped"):
        simulate(compile_scene(scene))


CORNERS = (0.113, 0.377, 0.6)


def swinging(**solver) -> Scene:
    """A pendulum under a torque with corners."""
    torque = Sum(
        terms=(Table(times=CORNERS, values=(0.0, 1.0, 0.3), interpolation="linear"), Sine(frequency=0.7), Constant(value=0.1))
    )
    return Scene(
        units="m-kg-s",
        points={"O": Point(x=0.0, y=0.0), "A": Point(x=0.9, y=0.3)},
        bodies={"rod": Rod(between=("O", "A"), area=1.0, density=1.0)},
        joints={"O": Revolute(bodies=("rod", "ground"), point="O")},
        loads={"weight": Gravity(acceleration=(0.0, -9.81)), "motor": Torque(body="rod", point="O", torque=1.0, curve=torque)},
        responses={"early": Rotation(body="rod", point="O", time=0.25), "end": Rotation(body="rod", point="O")},
        solver=RunOptions(**{"end_time": 1.0, "step": 0.2, "tolerance": 1e-13, **solver}),
    )


def test_steps_hit_corners_of_loads_and_times_of_responses_exactly():
    run = simulate(compile_scene(swinging(local_error=1e-5)))
    assert {0.0, *CORNERS, 0.25, 1.0} <= set(run.times)
    assert all(a < b for a, b in pairwise(run.times))
    assert np.diff(run.times).max() <= 0.2 * (1 + 1e-12)


@pytest.mark.parametrize("rho_inf", [0.0, 0.5, 1.0])
def test_the_estimate_is_the_local_error_of_a_step(rho_inf):
    """Fourth step of four, a body on a spring with a large swing, against fine steps over the same time from the same state."""
    spring = SpringDamper(bodies=("block", "ground"), points=("P", "W"), stiffness=3.0, length=0.5)
    scene = Scene(
        units="m-kg-s",
        points={"P": Point(x=1.0, y=0.0), "W": Point(x=0.0, y=0.0)},
        bodies={"block": Rigid(mass=2.0, inertia=1.0, center="P", velocity=(0.3, 0.9, 0.0))},
        loads={"spring": spring, "weight": Gravity(acceleration=(0.0, -1.0))},
    )
    alpha_m, alpha_f = (2 * rho_inf - 1) / (rho_inf + 1), rho_inf / (rho_inf + 1)
    beta, system, off = (1 - alpha_m + alpha_f) ** 2 / 4, compile_scene(scene), []
    for h in (0.04, 0.02, 0.01):
        run = simulate(system, RunOptions(end_time=4 * h, step=h, rho_inf=rho_inf, tolerance=1e-13))
        w = [run.a[0]]
        for n in range(4):
            w.append(((1 - alpha_f) * run.a[n + 1] + alpha_f * run.a[n] - alpha_m * w[n]) / (1 - alpha_m))
        estimate = (beta + (alpha_m - alpha_f) / 2 - 1 / 6) * h**2 * (w[4] - w[3])[:2]
        fine = simulate(system, RunOptions(end_time=h, step=h / 400, rho_inf=1.0, tolerance=1e-13), run.q[3], run.v[3])
        off.append(np.abs(estimate / (run.q[4] - fine.q[-1])[:2] - 1).max())
    assert off[2] < 0.1  # what is left of the first w, a_0, which at most halves from step to step, and terms of higher order


def test_a_smaller_local_error_gives_a_smaller_error_at_the_price_of_steps():
    exact = simulate(compile_scene(swinging(step=1e-4, rho_inf=1.0)))
    errors, steps = [], []
    for allowed in (1e-4, 1e-7):
        run = simulate(compile_scene(swinging(local_error=allowed, formulation="index-3")))
        errors.append(abs(run.q[-1] - exact.q[-1]).max())
        steps.append(run.steps)
    # a local error of third order: over three decades errors go with its 2/3 and steps with its -1/3, roughly, as errors may cancel
    assert np.log10(errors[0] / errors[1]) == pytest.approx(2, abs=0.5)
    assert np.log10(steps[1] / steps[0]) == pytest.approx(1, abs=0.2)


def test_a_run_can_be_repeated_with_the_times_that_it_chose():
    scene = swinging(local_error=1e-5)
    chosen = simulate(compile_scene(scene))
    repeated = simulate(compile_scene(frozen(scene, chosen)))
    np.testing.assert_allclose(repeated.q, chosen.q, atol=1e-12)  # lengths are differences of times, which are rounded


def test_the_certificate_of_chosen_steps_holds_them_fixed():
    found = certify(swinging(local_error=1e-4), ["points.A.x", "loads.motor.torque"], "transient")
    found.check(1e-9)
    for rate in found.rates.values():
        assert rate == pytest.approx(2.0, abs=0.1)  # third-order terms of the remainder


def test_the_adjoint_of_chosen_steps_never_falls_back_on_coarse_ones():
    """Beyond `solver.memory` other runs are repeated in windows of equal steps; this one keeps its steps, or is refused."""
    with pytest.raises(InputError, match=r"more than solver.memory = 1e-06 GB. Choose a larger solver.local_error"):
        adjoint(swinging(local_error=1e-4, memory=1e-6), ["loads.motor.torque"], "transient")


def test_an_error_below_round_off_is_refused():
    with pytest.raises(ConvergenceError, match=r"no step at t = .* is short enough"):
        simulate(compile_scene(swinging(local_error=1e-40)))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"times": (0.0, 0.5, 0.4, 1.0)}, "must increase from 0 to end_time"),
        ({"times": (0.1, 1.0)}, "must increase from 0"),
        ({"times": (0.0, 0.7)}, "end_time = 1"),
        ({"times": (0.0, 1.0), "local_error": 1e-3}, "leave one of them out"),
        ({"scheme": "paper", "local_error": 1e-3}, "has no estimate of its local error"),
        ({"formulation": "index-3", "rho_inf": 1.0, "local_error": 1e-3}, "rho_inf of at most 0.5"),
        (
            {"formulation": "index-3", "rho_inf": 0.85},
            "of at most 0.8: .* while the motion still looks right",
        ),
        ({"scheme": "paper", "formulation": "index-3"}, "is of index 1"),
    ],
)
def test_options_that_do_not_fit_together_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        RunOptions(end_time=1.0, **options)
