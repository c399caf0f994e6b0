"""Fitted orders of the integration schemes, in states, multipliers and sensitivities, on a double pendulum in full swing."""

from __future__ import annotations

import numpy as np
import pytest

from toolkit.analyses.transient import simulate
from toolkit.components.bodies.rigid import Rigid, Rod
from toolkit.components.curves.oscillation import Sine
from toolkit.components.joints.revolute import Revolute
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.springs import RotationalSpringDamper
from toolkit.components.loads.torque import Torque
from toolkit.description.design import Point
from toolkit.description.run_options import Baumgarte, RunOptions
from toolkit.scene.scene import Scene
from toolkit.solvers.transient.scheme import constraint_levels, generalized_alpha
from toolkit.system.system import System, compile_scene

DURATION, SAMPLES = 0.8, 20
STEPS = (400, 800, 1600)
DESIGN = ["points.A.x", "points.B.y", "bodies.lower.density", "loads.gravity.acceleration.y"]
QUANTITIES = ("q", "v", "a", "multipliers", "dq", "dv", "da", "dmultipliers")
SECOND = 0.1
"""Tolerance of a fitted order: what the next power of the step, 0.8 / 400 against a time scale of 0.1, still contributes."""


@pytest.fixture(scope="module")
def system() -> System:
    scene = Scene(
        units="m-kg-s",
        points={"O": Point(x=0.0, y=0.0), "A": Point(x=0.8, y=0.3), "B": Point(x=1.7, y=0.0)},
        bodies={"upper": Rod(between=("O", "A"), area=1.0, density=1.0), "lower": Rod(between=("A", "B"), area=1.0, density=1.5)},
        joints={
            "O": Revolute(bodies=("upper", "ground"), point="O"),
            "A": Revolute(bodies=("upper", "lower"), point="A"),
        },
        loads={"gravity": Gravity(acceleration=(0.0, -9.81))},
    )
    return compile_scene(scene, DESIGN)


def samples(system: System, steps: int, **options) -> list[np.ndarray]:
    """All quantities at the same few times."""
    # Newton's error has to stay below the smallest error of the scheme, 1e-6
    run = simulate(system, RunOptions(end_time=DURATION, step=DURATION / steps, tolerance=1e-13, **options))
    return [getattr(run, name)[:: steps // SAMPLES] for name in QUANTITIES]


@pytest.fixture(scope="module")
def reference(system) -> list[np.ndarray]:
    """Two fine runs, extrapolated: their own error is 1e-9."""
    coarse, fine = samples(system, 6400, rho_inf=1.0), samples(system, 12800, rho_inf=1.0)
    return [b + (b - a) / 3 for a, b in zip(coarse, fine, strict=True)]


def orders(system: System, reference: list[np.ndarray], **options) -> dict[str, float]:
    """Fitted order of every quantity, after the start (which is exact)."""
    errors = [
        [np.abs(ours - exact)[1:].max() for ours, exact in zip(samples(system, n, **options), reference, strict=True)]
        for n in STEPS
    ]
    return dict(zip(QUANTITIES, -np.polyfit(np.log(STEPS), np.log(errors), 1)[0], strict=True))


@pytest.mark.parametrize("rho_inf", [0.0, 0.5, 0.8, 1.0])
def test_arnold_bruels_is_of_second_order_for_every_rho_inf(system, reference, rho_inf):
    for name, order in orders(system, reference, scheme="arnold-bruels", rho_inf=rho_inf).items():
        assert order == pytest.approx(2.0, abs=SECOND), name


def test_the_papers_weighting_is_of_second_order_for_rho_inf_one(system, reference):
    for name, order in orders(system, reference, scheme="paper", rho_inf=1.0).items():
        assert order == pytest.approx(2.0, abs=SECOND), name


@pytest.mark.parametrize("rho_inf", [0.0, 0.5, 0.8])
def test_the_papers_weighting_is_of_first_order_for_smaller_rho_inf(system, reference, rho_inf):
    for name, order in orders(system, reference, scheme="paper", rho_inf=rho_inf).items():
        assert 0.9 <= order < 1.1, name


def test_constant_baumgarte_parameters_keep_the_order(system, reference):
    options = {"rho_inf": 0.5, "baumgarte": Baumgarte(damping=20.0, stiffness=20.0)}
    for name, order in orders(system, reference, scheme="arnold-bruels", **options).items():
        assert order == pytest.approx(2.0, abs=SECOND), name


@pytest.mark.parametrize(
    ("scheme", "rho_inf"), [("paper", 0.0), ("paper", 0.01), ("paper", 0.5), ("arnold-bruels", 0.0), ("arnold-bruels", 0.5)]
)
def test_sensitivities_are_exact_at_every_step_size(scheme, rho_inf):
    """They differentiate the discrete equations: a complex step of the whole run agrees however coarse the step is."""
    scene, design = driven_pendulum(), [*DESIGN, "bodies.lower.angular_velocity", "loads.motor.curve.phase"]
    options = RunOptions(end_time=0.8, step=0.05, scheme=scheme, rho_inf=rho_inf, tolerance=1e-13, drift_tolerance=1e-2)
    run = simulate(compile_scene(scene, design), options)
    for x, path in enumerate(design):
        stepped = simulate(compile_scene(scene.with_number(path, scene.number(path) + 1e-30j)), options)
        for name in ("q", "v", "a", "multipliers"):
            exact = getattr(stepped, name).imag / 1e-30
            ours = getattr(run, f"d{name}")[..., x]
            # round-off, multiplied by the condition of the multipliers' equations
            np.testing.assert_allclose(ours, exact, rtol=0, atol=1e-10 * np.abs(exact).max(), err_msg=f"{path} {name}")


def driven_pendulum() -> Scene:
    """A double pendulum that starts with a spin and is driven by a torque that acts from the start."""
    points = {"O": Point(x=0.0, y=0.0), "A": Point(x=0.8, y=0.3), "B": Point(x=1.7, y=0.0)}
    lower = Rod(between=("A", "B"), area=1.0, density=1.5, angular_velocity=0.28)
    bodies = {"upper": Rod(between=("O", "A"), area=1.0, density=1.0), "lower": lower}
    joints = {"O": Revolute(bodies=("upper", "ground"), point="O"), "A": Revolute(bodies=("upper", "lower"), point="A")}
    motor = Torque(body="upper", point="O", torque=1.3, curve=Sine(frequency=0.8, phase=0.5))
    loads = {"gravity": Gravity(acceleration=(0.0, -9.81)), "motor": motor}
    return Scene(units="m-kg-s", points=points, bodies=bodies, joints=joints, loads=loads)


@pytest.mark.parametrize("scheme", ["paper", "arnold-bruels"])
def test_one_variable_alone_has_the_sensitivity_that_it_has_among_others(scheme):
    options = RunOptions(end_time=0.8, step=0.05, scheme=scheme, tolerance=1e-13, drift_tolerance=1e-2)
    alone, all_of_them = (simulate(compile_scene(driven_pendulum(), names), options) for names in (DESIGN[:1], DESIGN))
    # blocks of four columns are solved in another order of the sums
    np.testing.assert_allclose(alone.dmultipliers[..., 0], all_of_them.dmultipliers[..., 0], rtol=1e-9, atol=1e-9)


def test_a_linear_problem_takes_one_iteration_per_step_and_now_and_then_a_second_to_see_that_the_first_was_exact():
    block = Rigid(mass=2.0, inertia=1.0, center="P")
    spring = RotationalSpringDamper(bodies=("block", "ground"), point="P", stiffness=3.0, rest_angle=0.2)
    scene = Scene(units="m-kg-s", points={"P": Point(x=1.0, y=0.0)}, bodies={"block": block}, loads={"spring": spring})
    run = simulate(compile_scene(scene), RunOptions(end_time=20.0, step=0.1))
    assert run.steps < run.newton_iterations <= 1.2 * run.steps  # every twentieth, and where the motion grows
    assert run.correction <= 1e-10  # the tolerance: after a good first guess a correction may be below that itself


def test_the_largest_accepted_correction_is_reported():
    options = RunOptions(end_time=0.8, step=0.05, tolerance=1e-6, drift_tolerance=1e-2)
    assert 1e-12 < simulate(compile_scene(driven_pendulum()), options).correction <= 1e-6


@pytest.mark.parametrize("rho_inf", [0.0, 0.6, 1.0])
@pytest.mark.parametrize("name", ["paper", "arnold-bruels"])
def test_every_step_satisfies_the_scheme_as_it_is_written(name, rho_inf):
    """The docstring of `Scheme`, line by line in numpy, for loads that act from the start."""
    system = compile_scene(driven_pendulum())
    options = RunOptions(end_time=0.4, step=0.02, scheme=name, rho_inf=rho_inf, tolerance=1e-13, drift_tolerance=1e-2)
    run, scheme, n_q = simulate(system, options), generalized_alpha(name, rho_inf, 0.02), system.n_q
    pad = np.zeros(system.n - n_q)

    def groups(n: int) -> tuple[np.ndarray, np.ndarray]:
        acc = np.concatenate([run.a[n], run.multipliers[n]])
        inputs = system.inputs(run.times[n], constraint_levels(options, np.array([0.02]))[0])
        terms = system.evaluate(inputs, np.append(run.q[n], pad), np.append(run.v[n], pad), acc)
        return terms.inertial, terms.applied

    h, w = scheme.h, run.a[0]
    for n in range(run.steps):
        w_new = scheme.new * run.a[n + 1] + scheme.old * run.a[n] - scheme.carry * w
        v = run.v[n] + h * ((1 - scheme.gamma) * w + scheme.gamma * w_new)
        q = run.q[n] + h * run.v[n] + h**2 * ((0.5 - scheme.beta) * w + scheme.beta * w_new)
        (inertial, applied), (inertial_n, applied_n) = groups(n + 1), groups(n)
        residual = scheme.weight_inertial * inertial + scheme.weight_applied * applied
        residual += scheme.carried_inertial * inertial_n + scheme.carried_applied * applied_n
        np.testing.assert_allclose(run.v[n + 1], v, atol=1e-12)  # round-off
        np.testing.assert_allclose(run.q[n + 1], q, atol=1e-13)
        np.testing.assert_allclose(residual, 0, atol=1e-8)  # Newton's tolerance 1e-13, over beta h^2 of the constraint rows
        w = w_new
