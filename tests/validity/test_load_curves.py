"""Loads and drivers that change between the times of a run, and tables that swing beyond their values, are named."""

from __future__ import annotations

import json
import re
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from typer.testing import CliRunner

from toolkit.analyses.sensitivity.direct import direct
from toolkit.analyses.sensitivity.run import Run
from toolkit.command_line.cli import app
from toolkit.components.curves.combined import Sum
from toolkit.components.curves.curve import Curve
from toolkit.components.curves.oscillation import Sine
from toolkit.components.curves.polynomial import Constant
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.curves.table import Table
from toolkit.description.run_options import time_grid
from toolkit.files.scene_reader import read_scene
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.system.quantities import curves_of
from toolkit.validity.curve_checks import LOST_VARIATION, loss_of

MODELS = Path(__file__).parents[2] / "models"
SLED = """
units = "m-kg-s"
[points]
O = [0.0, 0.0]
[bodies]
b = { type = "rigid", mass = 1.0, inertia = 1.0, center = "O" }
[joints]
x = { type = "slider", bodies = ["b", "ground"], point = "O", axis = [1.0, 0.0], lock_rotation = true }
DRIVER
[loads]
k = { type = "point-force", body = "b", point = "O", force = [0.01, 0.0] }
LOAD
[responses]
x = { type = "displacement", body = "b", point = "O", component = "x" }
[solver]
end_time = 1.0
step = 0.002
rho_inf = 0.8
"""
"""A mass of 1 kg on rails, pushed by 0.01 N, which moves it by 0.005 m in a second, and by a load with a time curve."""
SINE = '{ type = "sine", frequency = 1000.0 }'
ROWS, VALUES = (0.0, 0.5002, 0.501, 0.5018, 1.0), (0.0, 0.0, 1000.0, 0.0, 0.0)
TRIANGLE = f'type = "table", times = {list(ROWS)}, values = {list(VALUES)}'
LINEAR = f'{{ interpolation = "linear", {TRIANGLE} }}'
UP_AND_DOWN = (
    '{ type = "sum", terms = [{ type = "smooth-step", height = 1000.0, start = 0.4942, duration = 0.001 }, '
    '{ type = "smooth-step", height = -1000.0, start = 0.4954, duration = 0.0004 }] }'
)
STEPS = np.linspace(0, 1, 501)


def sled(folder: Path, load: str = "", driver: str = "", force: float = 1.0) -> Path:
    """File of a scene with these curves."""
    pushed = f'p = {{ type = "point-force", body = "b", point = "O", force = [{force}, 0.0], curve = {load} }}' if load else ""
    led = f'd = {{ type = "position-driver", bodies = ["b", "ground"], point = "O", axis = [1.0, 0.0], curve = {driver} }}'
    file = folder / "scene.toml"
    file.write_text(SLED.replace("DRIVER", led if driver else "").replace("LOAD", pushed))
    return file


def ran(file: Path, **changes: object) -> Run:
    return direct(read_scene(file, {path.replace("__", "."): str(value) for path, value in changes.items()}), [], "transient")


def said(found: Run, code: str = "load-curve") -> str:
    """What is said under a code, once."""
    (text,) = said_by(found, code)
    return text


def said_by(found: Run, code: str) -> list[str]:
    return [each.text for each in found.warnings if each.code == code]


def advised_step(found: Run) -> float:
    (step,) = re.findall(r"Fix: solver.step = ([\d.e-]+\d),", said(found))
    return float(step)


def by_sine(frequency: float) -> float:
    """x(1) = 100 / w (1 - sin(w) / w) of x'' = 100 sin(w t), and the way by the constant push."""
    w = 2 * np.pi * frequency
    return 100 / w * (1 - np.sin(w) / w) + 0.005


def by_step(start: float, duration: float) -> float:
    """x(1) = E((1 - t)^2) / 2 of x'' = s(t), t distributed as s' is: Beta(3, 3), of variance 1 / 28."""
    return ((1 - start - duration / 2) ** 2 + duration**2 / 28) / 2


PULSES = {
    LINEAR: 0.8 * (1 - 0.501) + 0.005,
    UP_AND_DOWN: 1000 * (by_step(0.4942, 0.001) - by_step(0.4954, 0.0004)) + 0.005,
}
"""Ways by pulses: an impulse of 0.8 Ns at the middle of the triangle."""


@pytest.mark.parametrize(
    ("frequency", "changes"),
    [
        (501.0, {}),
        (1000.0, {}),
        (100.0, {"solver__local_error": 1e-5, "solver__step": 0.02}),
        (333.4, {"solver__formulation": "index-3"}),
    ],
)
def test_a_sine_faster_than_the_steps_is_doubted_and_the_advice_follows_it(frequency, changes, tmp_path):
    """All were trusted with up to 437 times the way: runs with other steps see the same values of the sine."""
    file, true = sled(tmp_path, SINE, force=100.0), by_sine(frequency)
    found = ran(file, **changes, loads__p__curve__frequency=frequency)
    assert abs(found.values["x"] / true - 1) > 0.5
    assert not found.verdict.trusted
    assert "loads.p.curve" in said(found)
    assert "shortest period" in said(found)
    better = ran(file, **(changes | {"solver__step": advised_step(found)}), loads__p__curve__frequency=frequency)
    assert "load-curve" not in better.verdict.codes
    assert better.values["x"] == pytest.approx(true, rel=0.04)  # (w h)^2 / 12 = 3.3 % with ten steps a period


@pytest.mark.parametrize("curve", list(PULSES))
def test_a_pulse_between_two_times_is_doubted_and_the_advice_follows_it(curve, tmp_path):
    file = sled(tmp_path, curve)
    found = ran(file)
    assert found.values["x"] == pytest.approx(0.005)
    assert not found.verdict.trusted
    assert "shortest piece" in said(found)
    better = ran(file, solver__step=advised_step(found))
    assert "load-curve" not in better.verdict.codes
    assert better.values["x"] == pytest.approx(PULSES[curve], rel=5e-3)


def test_times_with_the_corners_of_a_table_of_straight_lines_see_it_whole(tmp_path):
    file = sled(tmp_path, LINEAR)
    corners = re.findall(r"its corners \((.*)\)", said(ran(file)))[0].split(", ")
    beside = np.linspace(0.5, 0.502, 11)  # the corners among them
    times = sorted({*map(float, corners), *np.round(STEPS, 6).tolist(), *np.round(beside, 6).tolist()})
    found = ran(file, solver__times=times)
    assert "load-curve" not in found.verdict.codes
    assert found.values["x"] == pytest.approx(PULSES[LINEAR], rel=5e-3)
    whole = sorted({*map(float, corners), *np.round(STEPS, 6).tolist()})
    assert part(Table(times=ROWS, values=VALUES, interpolation="linear"), np.array(whole)) < 1e-9


def test_steps_that_are_chosen_hit_the_corners_of_a_pulse_and_are_not_doubted(tmp_path):
    found = ran(sled(tmp_path, LINEAR), solver__local_error=1e-6)
    assert "load-curve" not in found.verdict.codes
    assert found.values["x"] == pytest.approx(PULSES[LINEAR], rel=5e-3)


@pytest.mark.parametrize("curve", [SINE, *PULSES])
def test_the_command_says_it_too(curve, tmp_path):
    file = str(sled(tmp_path, curve))
    record = json.loads(CliRunner().invoke(app, ["simulate", file, "--json"]).stdout)
    assert "load-curve" in [each["code"] for each in record["warnings"]]
    assert not record["verdict"]["trusted"]
    assert any("loads.p.curve changes between the times" in reason for reason in record["verdict"]["reasons"])
    shown = CliRunner().invoke(app, ["simulate", file]).stdout
    assert "NOT TO BE TRUSTED" in shown
    assert "loads.p.curve changes between the times" in shown


def test_start_and_end_of_the_run_are_no_corners(tmp_path):
    table = '{ type = "table", interpolation = "linear", times = [0.0, 0.05, 0.1], values = [0.0, 1.0, 0.0] }'
    assert "its corners (0.05, 0.1) and" in said(ran(sled(tmp_path, table), solver__step=0.2))
    one = ran(sled(tmp_path, '{ type = "smooth-step", duration = 3.0 }'), solver__step=1.0)
    assert said(one).endswith("Fix: solver.step = 0.1, a tenth of its shortest piece.")


def test_drivers_are_looked_at_too(tmp_path):
    """At steps of 0.002 s a sine of 500.25 / s has the values of one of 0.25 / s; x(1) = 0.01 sin(2 pi 1.25) with a slow one."""
    driver = '{ type = "sine", amplitude = 0.01, frequency = 500.25 }'
    file = sled(tmp_path, driver=driver)
    text = said(ran(file, solver__formulation="index-3", solver__rho_inf=0.5))
    assert text.startswith("joints.d.curve changes between the times")
    found = ran(file, solver__formulation="index-3", solver__rho_inf=0.5, joints__d__curve__frequency=1.25)
    assert "load-curve" not in found.verdict.codes
    assert found.values["x"] == pytest.approx(0.01)


@pytest.mark.parametrize("steps", ["", ', smoothness = "linear"'])
@pytest.mark.parametrize("local_error", [None, 1e-5])
def test_derivatives_by_the_time_of_a_jump_within_a_step_are_doubted(steps, local_error, tmp_path):
    """1 kg under 0.01 N, and 1 N from t_0 on: x(1) = 0.005 + (1 - t_0)^2 / 2, so that dx / dt_0 = t_0 - 1; of a rise in 0.04 s likewise."""
    ends = [f"loads.p.curve.{name}" for name in ("start", "end")]
    chosen = {"solver.local_error": str(local_error)} if local_error else {}

    def found(start: float, end: float) -> Run:
        file = sled(tmp_path, f'{{ type = "ramp", start = {start}, end = {end}{steps} }}')
        return direct(read_scene(file, chosen), ends, "transient")

    jump, rise = found(0.5011, 0.501101), found(0.4811, 0.5211)
    assert jump.values["x"] == pytest.approx(0.005 + 0.4989**2 / 2, rel=0.01)  # half a step of the second that is left
    assert abs(sum(jump.gradients["x"].values()) / -0.4989 - 1) > 0.5
    assert said_by(jump, "gradient-curve")[0].startswith("derivatives by loads.p.curve.start miss 100%")
    assert "gradient-curve" not in rise.verdict.codes
    assert sum(rise.gradients["x"].values()) == pytest.approx(-0.4989, rel=0.01)


def part(curve: Curve, times: np.ndarray = STEPS, has_zero: bool = True) -> float:
    found = loss_of(curve, times, has_zero)
    assert found is not None
    return found.part


@pytest.mark.parametrize("samples", [2, 4, 6, 8, 16, 50])
def test_what_is_lost_of_a_sine_is_that_of_its_chords(samples):
    """The area below half a sine is P / pi, that below its chords h cot(pi / n), n = P / h."""
    exact = 1 - np.pi / samples / np.tan(np.pi / samples)
    assert part(Sine(frequency=500 / samples), STEPS) == pytest.approx(exact, rel=0.03, abs=1e-3)
    assert (exact > LOST_VARIATION) == (samples <= 4)


def test_a_sine_with_whole_periods_in_a_step_is_lost_though_no_impulse_is():
    assert part(Sine(frequency=1000.0)) == pytest.approx(1, rel=0.02)
    assert part(Sine(frequency=1000.0, phase=np.pi / 2)) == pytest.approx(np.pi / 2, rel=0.02)  # lines at 1, mean of |cos| 2 / pi


@pytest.mark.parametrize("phase", [0.0, 0.7, 1.5, 2.4])
@pytest.mark.parametrize("samples", [8.0, 8.3, 11.7])
def test_eight_samples_in_a_period_are_enough(samples, phase):
    assert part(Sine(frequency=500 / samples, phase=phase)) < LOST_VARIATION / 2
    assert part(Sine(frequency=500 / samples, phase=phase), has_zero=False) < LOST_VARIATION / 2


@pytest.mark.parametrize("start", [0.0, 0.0003, 0.2501, 0.5003, 0.9])
def test_a_smooth_step_within_a_time_step_is_no_doubt(start):
    """Half a step of its height, at most, of 0.1 s and more that it lasts."""
    assert part(SmoothStep(start=start, duration=1e-3)) < 0.025
    assert part(SmoothStep(start=start, duration=1e-3), has_zero=False) < 0.025


def test_a_load_that_vanishes_within_the_first_step_is_doubted():
    """The area below the straight line is half of 0.002, its own half of 0.0002, as the step is symmetric."""
    vanishing = Sum(terms=(Constant(value=1.0), SmoothStep(height=-1.0, duration=2e-4)))
    assert part(vanishing) == pytest.approx((1e-3 - 1e-4) / 1e-4, rel=0.02)


def test_a_ripple_counts_beside_a_constant_unless_it_is_tiny():
    """The constant may be in balance. A thousandth of it changes a load by as much, but all that a driver does."""
    ripple = [Sum(terms=(Constant(value=5.0), Sine(amplitude=5 * each, frequency=1000.0))) for each in (0.1, 0.001)]
    assert part(ripple[0]) == pytest.approx(1, rel=0.02)
    assert part(ripple[1]) < LOST_VARIATION / 2
    assert part(ripple[1], has_zero=False) == pytest.approx(1, rel=0.02)


@pytest.mark.parametrize("steps", [20, 50, 100])
def test_a_load_switched_on_within_the_first_step_is_no_doubt(steps, tmp_path):
    found = ran(sled(tmp_path, '{ type = "smooth-step", duration = 0.001 }'), solver__step=1 / steps)
    assert "load-curve" not in found.verdict.codes


def test_a_pulse_is_not_hidden_by_a_slow_load(tmp_path):
    """0.8 Ns beside the 20 / pi = 6.4 Ns of a slow sine, without sign: 11 %, all in one step."""
    both = f'{{ type = "sum", terms = [{{ type = "sine", amplitude = 10.0, frequency = 1.0 }}, {LINEAR}] }}'
    file, true = sled(tmp_path, both), by_sine(1.0) / 10 + 0.8 * (1 - 0.501) + 0.0045
    found = ran(file)
    assert abs(found.values["x"] / true - 1) > 0.1
    assert "within one step" in said(found)
    better = ran(file, solver__step=advised_step(found))
    assert "load-curve" not in better.verdict.codes
    assert better.values["x"] == pytest.approx(true, rel=5e-3)


def test_few_steps_may_lose_more_each_where_nothing_hides_in_them():
    """Four steps along a cubic: each loses up to a twentieth, which runs with other steps show."""
    table = Table(times=(0.0, 0.1393, 0.3342, 0.5942), values=(0.5482, 0.6925, -0.5488, 0.5558))
    loss = loss_of(table, np.linspace(0, 0.2489, 5))
    assert loss is not None
    assert loss.in_one == 0
    assert 0.05 < loss.part < LOST_VARIATION


def test_sums_are_judged_whole():
    """Two steps that are no doubt each make a pulse; a fast sine counts by what the rest of the curve does."""
    up, down = SmoothStep(start=0.4942, duration=1e-3), SmoothStep(height=-1.0, start=0.4954, duration=4e-4)
    assert max(part(up), part(down)) < 0.01
    assert part(Sum(terms=(up, down))) == pytest.approx(1, rel=0.02)
    slow = SmoothStep(duration=1.0)
    fast = [part(Sum(terms=(slow, Sine(amplitude=each, frequency=1000.0)))) for each in (0.01, 1.0)]
    assert fast[0] < LOST_VARIATION / 2 < LOST_VARIATION < fast[1]


def test_an_aliased_sine_in_a_sum_with_a_long_table_has_its_advice():
    rows = np.linspace(0, 1, 401)
    table = Table(times=tuple(rows), values=tuple(np.sin(rows)), interpolation="linear")
    loss = loss_of(Sum(terms=(table, Sine(frequency=3000.0))), STEPS)
    assert loss is not None
    assert loss.part > LOST_VARIATION
    assert len(loss.corners) == 399
    assert loss.shortest == pytest.approx(1 / 400)


def test_constants_and_what_rests_lose_nothing():
    assert loss_of(Constant(value=3.0), STEPS) is None
    assert loss_of(Sum(terms=(Constant(), Constant())), STEPS) is None
    assert loss_of(SmoothStep(start=2.0), STEPS) is None  # begins after the run
    assert part(Table(times=(0.0, 1.0), values=(2.0, 2.0))) < 1e-12


@pytest.mark.parametrize("file", sorted(MODELS.glob("*/*scene*.toml")), ids=lambda file: f"{file.parent.name}/{file.stem}")
def test_models_are_not_doubted(file):
    scene = read_scene(file)
    assert isinstance(scene, Scene)
    for (group, _), curve in curves_of(loaded(scene)):
        loss = loss_of(curve, time_grid(scene.solver), group == "loads")
        assert loss is None or loss.part < 0.02


@pytest.mark.parametrize("steps", [1_000_000, 3_000_000])
def test_long_runs_cost_little(steps):
    """Pulses of 20 steps are seen, those within one are not, and neither takes memory for every step."""
    times = np.linspace(0, 1, steps + 1)
    h, middle = 1 / steps, 0.5 + 0.1 / steps
    tracemalloc.start()
    for width, expected in ((20 * h, 0.0), (0.8 * h, 1.0)):
        pulse = Table(times=(middle, middle + width / 2, middle + width), values=(0.0, 1.0, 0.0), interpolation="linear")
        assert part(pulse, times) == pytest.approx(expected, abs=0.05)
    assert part(Sine(frequency=steps / 8), times) == pytest.approx(1 - np.pi / 8 / np.tan(np.pi / 8), rel=0.03)
    assert part(Sine(frequency=1.0), times) < 1e-3
    assert tracemalloc.get_traced_memory()[1] < 40e6
    tracemalloc.stop()


def test_a_cubic_table_that_swings_far_beyond_its_values_is_doubted(tmp_path):
    """x = -39 km by a pulse of at most 1000 N, and no word."""
    found = ran(sled(tmp_path, f"{{ {TRIANGLE} }}"))
    assert found.values["x"] < -3e4
    spline = CubicSpline(ROWS, VALUES, bc_type="clamped")
    turns = spline.derivative().roots(extrapolate=False)
    worst = turns[np.argmax(np.abs(spline(turns)))]
    text = said(found, "curve-overshoot")
    assert f"reaches {spline(worst):.4g} at t = {worst:.4g}, {-spline(worst) / 1000:.3g} times" in text
    assert 'loads.p.curve.interpolation = "monotone" or "linear"' in text
    assert text in found.verdict.reasons


def test_one_that_swings_a_little_beyond_is_remarked_on(tmp_path):
    curve = '{ type = "table", times = [0.0, 0.25, 0.5, 0.75, 1.0], values = [0.0, 0.0, 1.0, 1.0, 1.0] }'  # 19 % by its step
    found = ran(sled(tmp_path, curve))
    assert said(found, "curve-overshoot") not in found.verdict.reasons


@pytest.mark.parametrize(
    ("curve", "changes"),
    [
        (LINEAR, {}),
        (f"{{ {TRIANGLE} }}", {"solver__end_time": 0.002}),
        ('{ type = "table", times = [0.0, 0.25, 0.5, 0.75, 1.0], values = [0.0, 0.2, 0.5, 0.8, 1.0] }', {}),
        ('{ type = "table", times = [0.0, 1.0], values = [3.0, 3.0] }', {}),
    ],
)
def test_other_tables_are_not(curve, changes, tmp_path):
    assert "curve-overshoot" not in ran(sled(tmp_path, curve), **changes).verdict.codes


def test_tables_within_sums_are_found(tmp_path):
    curve = f'{{ type = "sum", terms = [{{ type = "constant" }}, {{ {TRIANGLE} }}] }}'
    file = sled(tmp_path, curve)
    assert said(ran(file), "curve-overshoot").startswith("loads.p.curve.terms.1 swings")
    linear = ran(file, loads__p__curve__terms__1__interpolation="linear")
    assert "curve-overshoot" not in linear.verdict.codes


@pytest.mark.parametrize(
    ("load", "words"),
    [
        (
            '{ type = "ramp", start = 1.5, end = 2.0 }',
            r"loads.p.curve keeps its first value until t = 1.5, and the run ends at t = 1: ",
        ),
        (
            '{ type = "sequence", curves = [{ type = "sine", frequency = 1.0 }, { type = "constant" }], times = [1.0] }',
            r"loads.p.curve.curves.1 takes over at t = 1, and the run ends at t = 1: it has no effect. Fix: a later solver.end_time",
        ),
        (
            '{ type = "sum", terms = [{ type = "sequence", curves = [{ type = "constant" }, { type = "sine", frequency = 1.0 }], '
            "times = [2.0] }] }",
            r"loads.p.curve.terms.0.curves.1 takes over at t = 2",
        ),
    ],
)
def test_what_a_curve_does_after_the_end_is_told(load, words, tmp_path):
    found = ran(sled(tmp_path, load))
    assert re.search(words, said(found, "idle-curve"))
    assert found.verdict.trusted


@pytest.mark.parametrize(
    "load",
    [
        '{ type = "ramp", start = 0.5, end = 2.0 }',
        '{ type = "constant" }',
        '{ type = "smooth-step", start = 0.2, duration = 0.8 }',
    ],
)
def test_curves_that_act_before_the_end_are_not_told(load, tmp_path):
    assert "idle-curve" not in [each.code for each in ran(sled(tmp_path, load)).warnings]
