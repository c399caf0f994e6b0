"""When Newton's iteration of a step stops: its first guess, what a correction leaves, and that nothing of it is ever felt."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tests.benchmarks.space import hanging
from tests.models.scenes import WING
from toolkit.analyses.run_start import run_start
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.rigid import Rod
from toolkit.components.curves.table import Table
from toolkit.components.joints.revolute import Revolute
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.torque import Torque
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.compiled.rows import LANES
from toolkit.foundation.kernel import plain
from toolkit.scene.scene import Scene
from toolkit.solvers.transient.newton import SINGULAR
from toolkit.solvers.transient.run import Integration, allocate_history, failure_of_step, prepare_run, take_steps
from toolkit.solvers.transient.scheme import generalized_alpha
from toolkit.solvers.transient.step_memory import (
    AWAY,
    EXPECTED,
    HIGHEST_ORDER,
    ITERATIONS,
    LAST,
    ORDER,
    fit_trend,
    guess,
    learn_trend,
)
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene

FOUR_BARS = Path(__file__).parents[2] / "models" / "four_bar_chain" / "scene.toml"
LEFT = 1e-15
"""What a step may leave, a part of the model size or in rad, as docs/theory.md promises."""


def jerked(**solver) -> Scene:
    """A double pendulum whose motor starts within a twentieth of a step, in the middle of a quiet motion."""
    motor = Torque(
        body="upper", point="O", torque=20.0, curve=Table(times=(0.5001, 0.5006), values=(0.0, 1.0), interpolation="linear")
    )
    return Scene(
        units="m-kg-s",
        points={"O": Point(x=0.0, y=0.0), "A": Point(x=0.8, y=0.3), "B": Point(x=1.7, y=0.0)},
        bodies={name: Rod(between=pair, area=1.0, density=1.0) for name, pair in (("upper", ("O", "A")), ("lower", ("A", "B")))},
        joints={"O": Revolute(bodies=("upper", "ground"), point="O"), "A": Revolute(bodies=("upper", "lower"), point="A")},
        loads={"weight": Gravity(acceleration=(0.0, -9.81)), "motor": motor},
        solver=RunOptions(**solver),
    )


@pytest.fixture
def with_and_without(monkeypatch) -> Callable[[Scene], tuple[Solution, Solution]]:
    """A run that stops by what it estimates to be left, and one that never stops before its second correction, which is exact."""

    def thorough(*given) -> Integration:
        run = prepare_run(*given)
        return run._replace(control=run.control._replace(thorough=True))

    def both(scene: Scene) -> tuple[Solution, Solution]:
        system = compile_scene(scene)
        run = simulate(system)
        with monkeypatch.context() as patch:
            patch.setattr("toolkit.analyses.transient.prepare_run", thorough)
            return run, simulate(system)

    return both


def apart(one: Solution, other: Solution) -> float:
    """Largest difference at any time, of the model size or in rad."""
    return float(np.abs(one.system.weights[: one.system.n_q] * (other.q - one.q)).max())


def felt(run: Solution) -> float:
    """What LEFT at every step can come to: as an acceleration over h^2 it moves bodies by (T / h)^2 times as much until the end."""
    return LEFT * run.steps**2


@pytest.mark.parametrize("formulation", ["index-1", "index-3"])
def test_a_smooth_motion_takes_one_correction_a_step_and_loses_nothing(with_and_without, formulation):
    run, thorough = with_and_without(read_scene(FOUR_BARS, {"solver.end_time": "0.5", "solver.formulation": formulation}))
    assert run.newton_iterations <= 1.1 * run.steps  # every twentieth step may look, and the first ones
    assert thorough.newton_iterations >= 2 * run.steps
    assert apart(run, thorough) <= felt(run)


@pytest.mark.parametrize("step", [2e-2, 1e-2, 5e-3])
def test_coarse_steps_stop_only_where_nothing_is_left(with_and_without, step):
    run, thorough = with_and_without(read_scene(FOUR_BARS, {"solver.end_time": "0.5", "solver.step": str(step)}))
    assert run.newton_iterations < thorough.newton_iterations
    assert apart(run, thorough) <= felt(run)


def test_a_thin_skin_feels_nothing_of_it_either(with_and_without):
    run, thorough = with_and_without(
        read_scene(WING, {"solver.scheme": "arnold-bruels", "solver.step": "0.002", "solver.end_time": "0.4"})
    )
    assert (
        run.newton_iterations <= 1.9 * run.steps
    )  # what is not the first of its step is by the same factors, if those are as good
    assert apart(run, thorough) <= felt(run)


def test_a_blow_is_looked_into_at_once(with_and_without):
    """What was learnt of a quiet motion says nothing about the step in which a motor starts."""
    run, thorough = with_and_without(jerked(end_time=1.0, step=0.01))
    assert apart(run, thorough) <= felt(run)


def test_what_newton_reports_is_what_it_left():
    """Not the last correction, which may be larger than the tolerance where nothing is left after it."""
    scene = read_scene(FOUR_BARS, {"solver.end_time": "0.5", "solver.step": "0.005", "solver.tolerance": "1e-13"})
    assert simulate(compile_scene(scene)).correction <= 1e-13


def test_a_complex_step_never_stops_after_its_first_correction():
    """Decisions look at real parts; imaginary ones are exact one correction later."""
    scene = read_scene(FOUR_BARS, {"solver.end_time": "0.02"})
    path = "bodies.coupler1.density"
    run = simulate(compile_scene(scene.with_number(path, scene.number(path) + 1e-30j)))
    assert run.newton_iterations >= 2 * run.steps


def learnt_from(values: list[float], h: float = 1e-3) -> SimpleNamespace:
    """Memory after steps through these accelerations of one coordinate, in the model size."""
    memory, plan = (
        SimpleNamespace(trend=np.zeros((HIGHEST_ORDER, 1)), guess=np.zeros(1), learnt=np.zeros(10)),
        SimpleNamespace(n=1, n_q=1),
    )
    for before, after in pairwise(values):
        step = np.array([before]), np.array([after])
        plain(learn_trend)(plan, generalized_alpha("arnold-bruels", 0.8, h), np.ones(1), *step, memory)
    return memory


def guessed(memory: SimpleNamespace, last: float, ratio: float = 1.0) -> float:
    out = np.zeros(1)
    plain(guess)(SimpleNamespace(n=1, n_q=1), ratio, memory, np.array([last]), out)
    return float(out[0])


@pytest.mark.parametrize("degree", range(2, HIGHEST_ORDER + 1))
def test_the_first_guess_continues_a_polynomial(degree):
    values = [float(3 + 2 * n - 0.5 * n**degree) for n in range(3 * degree + 1)]  # whole numbers and halves: no round-off
    memory = learnt_from(values[:-1], h=1e-7)
    assert memory.learnt[ORDER] == degree
    assert guessed(memory, values[-2]) == pytest.approx(values[-1], rel=1e-14)


def test_the_first_guess_after_a_step_of_another_length_continues_a_line_and_promises_nothing():
    memory = learnt_from([1.0, 3.0, 5.0, 7.0])
    assert guessed(memory, 7.0, ratio=0.5) == pytest.approx(8.0, rel=1e-14)
    assert memory.learnt[EXPECTED] == 0


def fitted_to(values: list[np.ndarray]) -> SimpleNamespace:
    """Memory after a fit through accelerations (n,) of the last steps."""
    n = len(values[0])
    memory = SimpleNamespace(
        trend=np.zeros((HIGHEST_ORDER, n)),
        fitted=np.zeros(HIGHEST_ORDER),
        fit_sums=np.zeros((HIGHEST_ORDER, LANES)),
        fit_rows=np.zeros((n, LANES)),
        fit_columns=np.zeros((HIGHEST_ORDER, n)),
        fit_root=np.zeros((HIGHEST_ORDER, HIGHEST_ORDER)),
    )
    for before, after in pairwise(values):
        change = after - before
        memory.missed = plain(fit_trend)(n, 1.0, np.ones(n), change, memory)
        for k in range(HIGHEST_ORDER):
            memory.trend[k], change = change, change - memory.trend[k]
    return memory


def test_fitted_differences_continue_vibrations_that_no_polynomial_does():
    """A mean that drifts, and two frequencies of 0.7 and 1.9 rad in a step: five of their differences determine the next one.

    What the ridge of 1e-13 and the fading leave of the first steps is some 1e-6 of the motion.
    """
    phases = np.random.default_rng(0).uniform(0, 6.0, (2, 5))
    values = [0.1 * n + np.sin(0.7 * n + phases[0]) + 0.3 * np.sin(1.9 * n + phases[1]) for n in range(40)]
    memory = fitted_to(values[:-1])
    missed = values[-1] - values[-2] - memory.fitted @ memory.trend
    assert np.abs(missed).max() < 1e-5
    by_order = np.abs(np.diff(values[-1 - HIGHEST_ORDER :], axis=0)[-1]).max()
    assert np.abs(missed).max() < 1e-4 * by_order


def test_a_fit_of_nothing_is_the_last_state():
    still = [np.zeros(2)] * 9
    assert not np.any(fitted_to(still).fitted)


def test_a_beam_that_vibrates_takes_fewer_corrections(with_and_without, tmp_path):
    """They are 1.9 a step by polynomials, which its frequencies are too high for. What is fitted loses nothing."""
    scene = hanging(tmp_path, 1, 8)
    scene = scene.model_copy(update={"solver": scene.solver.model_copy(update={"end_time": 0.4})})
    run, thorough = with_and_without(scene)
    assert run.newton_iterations < 1.65 * run.steps
    assert apart(run, thorough) <= felt(run)


@pytest.mark.parametrize("values", [[1.0, -0.5, 0.25, -0.125, 0.0625], [0.0, 0.0, 0.0, 5.0, 5.0]], ids=["alternates", "jumps"])
def test_what_has_no_trend_is_guessed_as_it_was(values):
    memory = learnt_from(values)
    assert guessed(memory, values[-1]) == values[-1]


def test_coarse_steps_begin_at_the_last_state():
    """Where a guess of higher order misses by more than 1e-4 of the model size the equations may have a solution next to it, too."""
    values = [float(n**3) for n in range(6)]
    assert learnt_from(values, h=1e-3).learnt[ORDER] == 3
    assert learnt_from(values, h=1e-1).learnt[ORDER] == 0


def test_a_flexible_body_in_space_makes_one_jacobian_a_step_and_loses_nothing(with_and_without, tmp_path):
    """Its stiff modes keep the first guess from being so good that one correction is enough; the second one takes the same factors."""
    scene = hanging(tmp_path, 1, 4)
    scene = scene.model_copy(update={"solver": scene.solver.model_copy(update={"end_time": 0.1})})
    run, thorough = with_and_without(scene)
    assert apart(run, thorough) <= felt(run)
    steps = prepare_run(run.system)
    history = allocate_history(run.system, steps.options, len(steps.times), run_start(run.system, steps.options))
    ways = []
    for step in range(run.steps):
        take_steps(steps, history, run.system.curves(steps.times), step == 0, step, step + 1)
        if steps.outcome.counts[ITERATIONS] > 1:
            ways.append(steps.memory.learnt[AWAY] > 10 * steps.outcome.correction[LAST])
    assert len(ways) > 0.5 * run.steps
    assert np.mean(ways) > 0.9  # of the last correction alone it would be if that had factors of its own


@pytest.mark.parametrize(
    ("step", "iterations", "said"), [(0, 1, "redundant joints, or"), (0, 3, "Try a tenth"), (3, 1, "Try a tenth")]
)
def test_a_singular_step_is_blamed_on_the_joints_at_the_start_alone(step, iterations, said):
    times, scene = 0.1 * np.arange(6), SimpleNamespace(names=["x of body 'rod'"])
    outcome = SimpleNamespace(counts=[SINGULAR, step, iterations, 0, 0])
    run = SimpleNamespace(
        outcome=outcome, times=times, lengths=np.diff(times), system=SimpleNamespace(numbering=scene), options=RunOptions()
    )
    assert said in str(failure_of_step(run))  # type: ignore[arg-type]
