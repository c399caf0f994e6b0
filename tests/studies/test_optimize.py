"""Optima of studies against closed forms; what must not come out as one; and what survives an interruption."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import rosen, rosen_der
from typer.testing import CliRunner

import ffrf
from preprocessing.elements.section import Section
from tests.models.beam_models import save_beam
from tests.models.truss import STIFFNESS, force, force_slope, height, limit_load, snapped_height, write_truss
from toolkit.analyses.sensitivity.certificate.certificate import NothingVerifiedError, certify
from toolkit.command_line.cli import app
from toolkit.foundation.errors import InputError
from toolkit.studies.design_work import Evaluator
from toolkit.studies.optimization.explored import Known, turned
from toolkit.studies.optimization.methods import METHODS, Functions
from toolkit.studies.optimization.optimize import STORE, _other_optima, _rank, _unfinished, optimized
from toolkit.studies.optimization.optimum import NoOptimumError, Optimum
from toolkit.studies.optimization.program import Program, Values, optimality_of
from toolkit.studies.optimization.verification import solved_again
from toolkit.studies.problem import Problem, problem_of
from toolkit.studies.store import DesignOutcome, DesignStore, JobState, StudyFileError
from toolkit.studies.study_file import read_study
from toolkit.studies.uncertain_study import uncertain_study

LOAD = '"loads.push.force.y"'
DROP = f"""
scene = "scene.toml"
[variables]
{LOAD} = {{ between = [-200.0, -10.0] }}
k = {{ of = ["loads.left.stiffness", "loads.right.stiffness"], between = [-300.0, 200.0] }}
[objective]
minimize = "rise"
[constraints]
load_margin = {{ above = 1.25 }}
"""
"""The largest drop with a quarter of the limit load in reserve: softest springs do not help, since load and limit load go together, so that
only the load times 1/stiffness counts; the load's own bound decides between them."""
QUICK = "\n[search]\ncertify = false\nwarm_starts = true\n"


SYMMETRIC = """units = "m-kg-s"
points = { P = [0.0, 0.5], L = [-1.0, 0.0], R = [1.0, 0.0] }
bodies = { tip = { type = "rigid", mass = 1.0, inertia = 1.0, center = "P" } }
[joints]
guide = { type = "slider", bodies = ["tip", "ground"], point = "P", axis = [0.0, 1.0], lock_rotation = true }
[loads]
left = { type = "spring-damper", bodies = ["tip", "ground"], points = ["P", "L"], stiffness = 1000.0 }
right = { type = "spring-damper", bodies = ["tip", "ground"], points = ["P", "R"], stiffness = 1000.0 }
push = { type = "point-force", body = "tip", point = "P", force = [0.0, -30.0] }
[responses]
rise = { type = "displacement", body = "tip", point = "P", component = "y" }
"""


def study(folder: Path, text: str, **scene: str) -> Problem:
    return problem_of(read_study(write_truss(folder, text, **scene)))


def only_load(folder: Path, rest: str = "", objective: str = 'minimize = "rise"', least: float = -200.0) -> Problem:
    """The truss with its load as the only variable."""
    text = f'scene = "scene.toml"\n[variables]\n{LOAD} = {{ between = [{least}, -10.0] }}\n[objective]\n{objective}\n'
    return study(folder, text + rest)


@pytest.mark.parametrize(
    ("method", "optimality", "close"),
    [
        ('"slsqp"', 1e-7, 1e-5),
        ('"trust-constr"', 1e-4, 1e-3),
        ('"mma"', 1e-5, 1e-4),
        ('"ccsa"', 1e-5, 1e-4),
        ('["ccsa", "slsqp"]\nevaluations = 25', 1e-7, 1e-5),
    ],
)
def test_the_drop_that_keeps_a_load_margin_and_its_price_are_those_of_the_closed_form(tmp_path, method, optimality, close):
    """What the residual leaves of the limit's slack is some ten times itself; the slope of the drop grows towards the limit point."""
    problem = only_load(
        tmp_path,
        f"[constraints]\nload_margin = {{ above = 1.25 }}\n[search]\nmethod = {method}\noptimality = {optimality}\ncertify = false\n",
    )
    found = optimized(problem)
    wanted = limit_load() / 1.25
    y = height(wanted)
    assert found.success, found.verdict
    assert -found.variables["loads.push.force.y"] == pytest.approx(wanted, rel=close)
    assert found.values["rise"] == pytest.approx(y - 0.5, rel=10 * close)
    assert found.values["load_margin"] == pytest.approx(1.25, rel=close)
    price = next(each for each in found.prices if each.name == "load_margin")
    exact = -limit_load() / 1.25**2 / force_slope(y)  # drise/dload dload/dmargin
    assert price.active
    assert price.price == pytest.approx(abs(exact), rel=20 * close)
    assert (price.unit, found.again.margins[""][1]) == ("m", True)
    assert found.evaluations < 40


def test_a_variable_of_several_numbers_moves_them_from_where_they_stand(tmp_path):
    """With the load fixed the stiffest springs rise the most; both move by the same."""
    text = DROP.replace(f"{LOAD} = {{ between = [-200.0, -10.0] }}\n", "").replace("minimize", "maximize")
    found = optimized(study(tmp_path, text + QUICK))
    assert found.variables == {"k": 200.0}
    assert found.values["rise"] == pytest.approx(height(30.0, STIFFNESS + 200.0) - 0.5, rel=1e-9)
    stiff = [found.scene.number(f"loads.{side}.stiffness") for side in ("left", "right")]
    assert stiff == [STIFFNESS + 200.0] * 2
    price = next(each for each in found.prices if each.name == "k")
    y = height(30.0, 1200.0)
    assert price.price == pytest.approx(-force(y) / STIFFNESS / force_slope(y) * STIFFNESS / 1200.0, rel=1e-6)


CASES = """
[constraints]
rise = { above = -0.12 }
[cases.soft]
"loads.left.stiffness" = 900.0
"loads.right.stiffness" = 900.0
[cases.stiff]
"""


def test_every_case_keeps_the_constraints(tmp_path):
    found = optimized(only_load(tmp_path, CASES + QUICK + "optimality = 1e-8\n"))
    wanted = force(0.38, 900.0)
    assert -found.variables["loads.push.force.y"] == pytest.approx(wanted, rel=1e-6)
    assert found.values["soft.rise"] == pytest.approx(-0.12, rel=1e-5)
    assert found.values["stiff.rise"] == pytest.approx(height(wanted) - 0.5, rel=1e-5)
    assert [each.active for each in found.prices] == [True, False]
    assert "cases" not in found.verdict.codes  # one of them is the scene as it stands


def test_a_study_whose_cases_leave_the_scene_itself_out_says_so(tmp_path):
    found = optimized(only_load(tmp_path, CASES.replace("[cases.stiff]\n", "") + QUICK))
    assert found.verdict.trusted
    assert "the design is that for soft alone" in str(found.verdict)


FALL = """
scene = "scene.toml"
analysis = "motion"
[variables]
g_y = { between = [-12.0, -5.0] }
[objective]
minimize = "move_y"
[constraints]
move_x = { below = 0.2 }
[search]
certify = false
"""


def test_a_motion_is_optimised_too_and_its_price_is_that_of_differences(tmp_path):
    """The lowest a pendulum falls in half a second without going further aside than 0.2 m."""
    text = (Path(__file__).parents[2] / "models" / "pendulum" / "scene.toml").read_text()
    short = text.replace("end_time = 10.0", "end_time = 0.4").replace("step = 0.0005", "step = 0.01")
    (tmp_path / "scene.toml").write_text(short)
    (tmp_path / "study.toml").write_text(FALL)
    found = ffrf.optimize(tmp_path / "study.toml")
    assert found.success
    assert found.values["move_x"] == pytest.approx(0.2, rel=1e-2)  # with steps half as long
    assert found.design.values[0] == pytest.approx([found.objective, 0.2], rel=1e-3)
    model, g = ffrf.compile(ffrf.read_scene(tmp_path / "scene.toml")), found.variables["g_y"]
    sides = [model.simulate({"g_y": g + step}).values for step in (1e-4, -1e-4)]
    ratio = (sides[0]["move_y"] - sides[1]["move_y"]) / (sides[0]["move_x"] - sides[1]["move_x"])
    price = next(each for each in found.prices if each.name == "move_x")
    assert price.active
    assert price.price == pytest.approx(-ratio, rel=1e-3)  # what the residual leaves


BESIDE = {
    "[bodies]\n": """Q = [2.0, 0.0]
W = [3.0, 0.0]
[bodies]
ball = { type = "rigid", mass = 1.0, inertia = 1.0, center = "Q", velocity = [1.0, 0.0, 0.0] }
""",
    "[joints]\n": """[joints]
guide = { type = "slider", bodies = ["ball", "ground"], point = "Q", axis = [1.0, 0.0], lock_rotation = true }
""",
    "[loads]\n": """[loads]
spring = { type = "spring-damper", bodies = ["ball", "ground"], points = ["Q", "W"], stiffness = 900.0, length = 1.0 }
""",
    "[responses]\n": """[responses]
ball_x = { type = "displacement", body = "ball", point = "Q", component = "x" }
""",
    "end_time = 10.0": "end_time = 0.4",
    "step = 0.0005": "step = STEP",
}
"""A mass on a spring beside the pendulum: sin(30 t) / 30."""


@pytest.mark.parametrize(("step", "wrong"), [("0.01", True), ("0.0025", False)])
def test_an_optimum_is_trusted_where_its_own_simulation_is(tmp_path, step, wrong):
    """Steps half as long, with which it is solved again, resolve what the scene's own do not."""
    text = (Path(__file__).parents[2] / "models" / "pendulum" / "scene.toml").read_text()
    for old, new in BESIDE.items():
        text = text.replace(old, new.replace("STEP", step))
    (tmp_path / "scene.toml").write_text(text)
    (tmp_path / "study.toml").write_text(FALL)
    found = ffrf.optimize(tmp_path / "study.toml")
    run = ffrf.compile(found.scene).simulate()
    assert (abs(run.values["ball_x"] - np.sin(12.0) / 30) > 0.05 / 30) == wrong
    assert run.verdict.codes == (("steps",) if wrong else ())
    assert found.success
    assert (found.verdict.codes, found.verdict.trusted) == (run.verdict.codes, run.verdict.trusted)


COLUMN = """units = "m-kg-s"
points = { T = { body = "beam", interface = "tip" } }
bodies = { beam = { type = "flexible", model = "beam.h5", frame = "grounded" } }
loads = { push = { type = "point-force", body = "beam", point = "T", force = [-1000.0, 0.0] } }
responses = { x = { type = "displacement", body = "beam", point = "T", component = "x" } }
solver = { end_time = 1.0 }
"""
SHORTER = """scene = "scene.toml"
[variables]
"loads.push.force.x" = { between = [LEAST, -100.0] }
[objective]
minimize = "x"
[search]
certify = false
"""


@pytest.mark.parametrize("margin", ["", "[constraints]\nload_margin = { above = 1.5 }\n"])
def test_the_load_margin_of_a_column_in_one_frame_is_not_trusted(tmp_path, margin):
    """Euler's column at 0.8 of pi^2 E I / (4 L^2) buckles at 1.25 times its load: its shortening is right, its margin of 1.5 is not."""
    section = Section(youngs_modulus=210e9, density=7800.0, thickness=0.02, width=0.02)
    save_beam(tmp_path / "beam.h5", np.column_stack([np.linspace(0, 1, 9), np.zeros(9)]), section, {"root": 0.0, "tip": 1.0})
    (tmp_path / "scene.toml").write_text(COLUMN)
    least = -0.8 * np.pi**2 / 4 * 210e9 * 0.02**4 / 12
    (tmp_path / "study.toml").write_text(SHORTER.replace("LEAST", str(least)) + margin)
    found = ffrf.optimize(tmp_path / "study.toml")
    assert found.success
    assert found.variables["loads.push.force.x"] == pytest.approx(least)
    doubts = [each.code for each in found.verdict.warnings if each.doubt]
    assert doubts == (["critical-load"] if margin else [])
    assert ffrf.compile(found.scene).statics().verdict.trusted


@pytest.mark.parametrize(
    "objective",
    [
        "minimize = { rise = 2.0, load_margin = -0.3 }",
        "maximize = { rise = 2.0, load_margin = -0.3 }",
        'minimize = "rise"\nover_cases = "worst"\naggregation = 30.0',
        'maximize = { rise = 0.5, load_margin = 1.0 }\nover_cases = "worst"\naggregation = 30.0',
    ],
)
def test_slopes_of_sums_and_of_the_worst_case_are_those_of_a_complex_step_and_of_differences(tmp_path, objective):
    problem = only_load(tmp_path, CASES, objective)
    program, evaluator = Program(problem), Evaluator(problem, DesignStore())
    design = np.array([-34.0])  # the soft case snaps through at 38.6
    found = evaluator(0, design, False)
    value, slopes = program.objective(found.values)
    for place in np.ndindex(found.values.shape):
        stepped = found.values.astype(complex)
        stepped[place] += 1e-30j
        assert program.objective(stepped)[0].imag / 1e-30 == pytest.approx(slopes[place], rel=1e-10, abs=1e-14)
    if "worst" in objective:
        each = found.values @ np.array([problem.study.objective.weights.get(name, 0.0) for name in problem.responses])
        worst = (max if "minimize" in objective else min)(each)
        assert 0 <= (value - worst) * problem.study.objective.sign <= np.log(2) / 30
    step = 1e-3
    sides = [program.values(evaluator(0, design + sign * step, False)) for sign in (1, -1)]
    exact, size = program.values(found), problem.scales[0]
    assert (sides[0].f - sides[1].f) / (2 * step) * size == pytest.approx(exact.df[0], rel=1e-6)  # the square of the step
    assert (sides[0].c - sides[1].c) / (2 * step) * size == pytest.approx(exact.dc[:, 0], rel=1e-6)


def test_curvature_of_known_designs_makes_a_narrow_valley_round():
    """z^T A z / 2 with curvatures from 1e-3 to 10 in slanting directions, and a constraint whose multiplier and curvature count too."""
    random = np.random.default_rng(2)
    axes, _ = np.linalg.qr(random.normal(size=(4, 4)))
    matrix, bent = (axes * [1e-3, 0.1, 1.0, 9.0]) @ axes.T, (axes * [0.0, 0.0, 0.0, -0.5]) @ axes.T

    def functions(z: np.ndarray) -> Values:
        return Values(z @ matrix @ z / 2, matrix @ z, np.array([z @ bent @ z / 2]), (bent @ z)[None])

    centre, *others = (Known(z, functions(z)) for z in 0.5 + 0.1 * random.normal(size=(13, 4)))
    found = turned(centre, others, np.array([2.0]), np.ones(4))
    assert found is not None
    whole = matrix - 2 * bent
    assert np.linalg.cond(found.axes.T @ whole @ found.axes) < 0.05 * np.linalg.cond(
        whole
    )  # what a dozen designs tell, at random
    assert turned(centre, others[:3], np.array([2.0]), np.ones(4)) is None
    of, y = found.functions(functions), random.normal(size=4)
    assert found.z(np.zeros(4)) == pytest.approx(centre.z)
    assert of(y).c[1:] == pytest.approx([*found.z(y), *(1 - found.z(y))])
    for way in np.eye(4):
        ends = of(y + way), of(y - way)  # exact for squares
        assert of(y).df @ way == pytest.approx((ends[0].f - ends[1].f) / 2, rel=1e-10)
        assert of(y).dc @ way == pytest.approx((ends[0].c - ends[1].c) / 2, rel=1e-10)


def _begun_anew(method: str, functions: Functions, here: np.ndarray, top: np.ndarray) -> np.ndarray:
    """The best design that a method accepts among three, in variables by the curvature where it begins."""
    found, reached, free = turned(Known(here, functions(here)), [], np.empty(0), top, 1.0), [here], np.full(len(top), np.inf)
    assert found is not None
    METHODS[method].run(found.functions(functions), np.zeros(len(top)), -free, free, lambda y: reached.append(found.z(y)), 3)
    return min(reached, key=lambda z: functions(np.clip(z, 0.0, top)).f)


@pytest.mark.parametrize("method", ["slsqp", "mma", "ccsa"])
def test_methods_are_at_the_end_of_a_narrow_valley_at_once_where_its_curvature_is_told(method):
    """A mean square of curvatures from 1e-3 to 10 in slanting directions, the least of it at a bound: a tenth of the designs, or less."""
    axes, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(4, 4)))
    matrix, least, top = (axes * [1e-3, 0.1, 1.0, 10.0]) @ axes.T, np.array([1.3, 0.4, 0.6, 0.2]), np.ones(4)
    solved: list[np.ndarray] = []

    def functions(z: np.ndarray) -> Values:
        if not any(np.array_equal(z, each) for each in solved):
            solved.append(z.copy())
        off = z - least
        return Values(off @ matrix @ off / 2, matrix @ off, np.empty(0), np.empty((0, 4)), matrix)

    begin = np.full(4, 0.5)
    METHODS[method].run(functions, begin, np.zeros(4), top, lambda _: None, 40)
    best = least[1:] + np.linalg.solve(matrix[1:, 1:], matrix[1:, 0] * (least[0] - 1.0))  # with the first at its bound
    value = functions(np.concatenate([[1.0], best])).f
    crawled = [functions(z).f - value for z in solved[:40]]
    solved.clear()
    here = begin
    for _ in range(4):  # begun anew with the best design
        here = _begun_anew(method, functions, here, top)
    assert functions(here).f - value < 1e-6
    assert len(solved) <= 16
    assert method == "slsqp" or min(crawled) > 1e-4


def test_multipliers_of_a_quadratic_program_balance_its_slopes(tmp_path):
    """min (z0 - 2)^2 + (z1 - 2)^2 with z0 + z1 <= 1 and z within [0, 1]: at (1/2, 1/2) with the multiplier 3."""
    program = Program(study(tmp_path, DROP))
    z = np.array([0.5, 0.5])
    values = Values(4.5, 2 * (z - 2), np.array([0.0]), np.array([[-1.0, -1.0]]))
    left = optimality_of(program, z, values, 3.0)
    assert left.multipliers == pytest.approx([3.0])
    assert left.residual < 1e-15
    elsewhere = np.array([0.6, 0.4])
    away = optimality_of(program, elsewhere, values._replace(df=2 * (elsewhere - 2)), 3.0)
    assert not away.met(1e-2, 1e-6)


def test_a_search_that_ends_at_a_cliff_is_no_success(tmp_path):
    """Without a load margin the largest drop is at the limit point, beyond which there is nothing."""
    found = optimized(only_load(tmp_path, "[search]\ncertify = false\nevaluations = 60\n"))
    assert found.failed > 0
    assert -found.variables["loads.push.force.y"] < limit_load()
    assert not found.success
    assert "not-optimal" in found.verdict.codes
    with pytest.raises(NoOptimumError, match="KKT residual"):
        found.check()
    assert all(each.values.size == 0 for each in found.solved if each.failed)


def test_a_number_added_to_the_objective_changes_nothing(tmp_path):
    """The mass is the same for all designs."""
    rest = CASES.replace("-0.12", "-0.11") + '[responses]\nweight = { type = "mass" }' + QUICK
    plain, added = (optimized(only_load(tmp_path, rest, f"minimize = {{ rise = 1.0, weight = {w} }}")) for w in (1e-9, 1e4))
    assert added.objective - plain.objective == pytest.approx(2e4)
    assert added.evaluations == plain.evaluations
    assert added.variables["loads.push.force.y"] == pytest.approx(plain.variables["loads.push.force.y"], rel=1e-6)
    assert added.optimality == pytest.approx(plain.optimality, rel=1e-2, abs=1e-6)  # round-off of 1e4


def test_a_method_whose_package_is_missing_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "nlopt", None)
    with pytest.raises(InputError, match=r"ffrf-toolkit\[nlopt\]"):
        optimized(only_load(tmp_path, '[search]\nmethod = "mma"\n'))


def test_slsqp_goes_on_where_little_of_the_first_slope_is_left():
    """Rosenbrock's valley, a billionth as steep as it is usually, to its minimum at (1, 1)."""
    visited: list[np.ndarray] = []

    def valley(z: np.ndarray) -> Values:
        return Values(1e-9 * rosen(z), 1e-9 * rosen_der(z), np.empty(0), np.empty((0, 2)))

    METHODS["slsqp"].run(valley, np.array([-1.2, 1.0]), np.full(2, -2.0), np.full(2, 2.0), visited.append, 1000)
    assert visited[-1] == pytest.approx([1.0, 1.0], rel=1e-3)  # so far off there are still 1e-15 to be gained


def test_half_of_the_way_to_a_failed_design_is_left(tmp_path):
    """Towards the cliff of a snap-through, where the objective leads to the edge of every box: a tenth of the way is left at the end."""
    found = optimized(only_load(tmp_path, "[search]\ncertify = false\nmost_failures = 8\n"))
    good, start = np.nan, 30.0
    for earlier, later in pairwise(found.solved):
        if not earlier.failed:
            good = -earlier.design[0]
        else:
            assert -later.design[0] - good == pytest.approx((-earlier.design[0] - good) / 2, rel=1e-9)
    assert found.failed == 8
    assert 0 < limit_load() - -found.variables["loads.push.force.y"] < 0.1 * (limit_load() - start)


def test_the_scale_of_an_objective_says_when_a_search_ends(tmp_path):
    objective = 'minimize = "rise"\nscale = 1e-9'
    left = optimized(only_load(tmp_path, "[search]\ncertify = false\noptimality = 0.5", objective, least=-36.0))
    assert left.optimality < 0.5
    assert left.success


def test_an_optimum_comes_before_a_better_design_that_is_none_and_that_is_said(tmp_path):
    found = optimized(only_load(tmp_path, QUICK, least=-30.5))
    assert found.search.arrived
    better = optimized(only_load(tmp_path, QUICK, least=-36.0)).search
    unfinished = replace(better, arrived=False)
    assert _rank(found.search) < _rank(unfinished)
    assert _rank(better) < _rank(found.search)
    codes = [each.code for each in _other_optima(found.problem, found.search, [found.search, unfinished])]
    assert codes == ["better-designs"]
    assert [each.code for each in _other_optima(found.problem, better, [better, replace(found.search, arrived=False)])] == []
    (said,) = _unfinished(found.search, [found.search, unfinished])
    assert said.text.startswith("1 of 2 searches ended at no optimum (start 1: the conditions")
    assert not list(_unfinished(found.search, [found.search, better]))
    assert not list(_unfinished(unfinished, [unfinished]))


def test_searches_that_end_at_one_objective_with_other_designs_say_that_it_is_flat(tmp_path):
    """Drop and margin depend on the load over the stiffness alone; where the load is the only variable there is one such design."""
    two = optimized(study(tmp_path, DROP + "[search]\ncertify = false\nstarts = 3\noptimality = 1e-4\n"))
    assert "flat-optimum" in two.verdict.codes
    (said,) = [each.text for each in two.verdict.warnings if each.code == "flat-optimum"]
    assert "with k from -" in said
    one = optimized(only_load(tmp_path, "[constraints]\nload_margin = { above = 1.25 }\n[search]\ncertify = false\nstarts = 3\n"))
    assert "flat-optimum" not in one.verdict.codes


@pytest.mark.parametrize(("wish", "bound", "best"), [("maximize", 0.4, 0.4), ("maximize", 0.3, 0.3), ("minimize", 0.3, 0.0)])
def test_a_symmetric_start_is_no_optimum_because_its_slopes_vanish(tmp_path, wish, bound, best):
    """Two springs to L and R, moved along together: the tip sinks most where it stands in the middle, at the start."""
    (tmp_path / "scene.toml").write_text(SYMMETRIC)
    text = f'scene = "scene.toml"\n[variables]\nshift = {{ between = [-0.3, {bound}], of = ["points.L.x", "points.R.x"] }}\n'
    (tmp_path / "study.toml").write_text(f'{text}[objective]\n{wish} = "rise"\n')
    found = ffrf.optimize(tmp_path / "study.toml")
    assert abs(found.variables["shift"]) == pytest.approx(best, abs=1e-6)
    assert found.success
    assert "depends on shift" not in str(found.verdict)


@pytest.mark.parametrize("off", [1e-5, 1e-3])
def test_a_derivative_that_vanishes_at_an_optimum_is_certified_by_what_its_response_is(tmp_path, off):
    """In the middle between both supports what is left of it is round-off, which no other method repeats; neither do differences."""
    (tmp_path / "scene.toml").write_text(SYMMETRIC.replace("[-1.0, 0.0]", f"[{-1.0 + off!r}, 0.0]"))
    text = 'scene = "scene.toml"\n[variables]\nshift = { between = [-0.3, 0.3], of = ["points.L.x", "points.R.x"] }\n'
    (tmp_path / "study.toml").write_text(f'{text}[objective]\nminimize = "rise"\n[search]\noptimality = 1e-9\n')
    found = ffrf.optimize(tmp_path / "study.toml")
    assert found.variables["shift"] == pytest.approx(-off / 2, abs=1e-8)  # what the residual leaves
    assert found.verdict.trusted, found.verdict
    certificate = certify(found.scene, ["shift"], "static")
    assert certificate.verified(1e-8) == 0  # round-off has no digits in common
    assert certificate.vanish(1e-8)
    assert certificate.verdict.trusted
    certificate.check(1e-8)
    with pytest.raises(NothingVerifiedError):
        replace(certificate, zeros={"rise": {"shift": 1e-7}}).check(1e-8)


def test_a_load_margin_that_is_cut_off_decides_nothing_and_that_is_said(tmp_path):
    """From a tenth of the limit load on nothing is seen of it: the largest margin is at least 10."""
    variables = f'scene = "scene.toml"\n[variables]\n{LOAD} = {{ between = [-12.0, -2.0] }}\n'
    wishes = {
        '[objective]\nmaximize = "load_margin"\n': (True, "up to 10 times the load: load_margin is at least that"),
        '[objective]\nminimize = "rise"\n[constraints]\nload_margin = { above = 1.1 }\n': (False, "limits on it are not active"),
    }
    for wish, (doubt, words) in wishes.items():
        found = optimized(study(tmp_path, variables + wish + "[search]\ncertify = false\n", **{"-30.0": "-8.0"}))
        (said,) = [each for each in found.verdict.warnings if each.code == "margin-cut-off"]
        assert said.doubt == doubt
        assert words in said.text


def test_a_study_may_stop_at_the_first_failed_design(tmp_path):
    found = optimized(only_load(tmp_path, '[search]\ncertify = false\nfailures = "stop"\n'))
    assert found.failed == 1
    assert "says to stop" in found.search.ended


def snapped(problem: Problem, load: float) -> DesignOutcome:
    """The start design as one would have it who has passed a snap-through: a stable equilibrium, but no path leads there."""
    y = snapped_height(load)
    clean = Evaluator(problem, DesignStore())(0, problem.start, False)
    q = clean.states[0].q.copy()
    q[np.argmax(np.abs(q - _undeformed(problem)))] += y - height(load)
    warm = replace(clean, states=(JobState(q, clean.states[0].multipliers),))
    store = DesignStore()
    store.keep(warm.key, warm)
    found = Evaluator(problem, store)(0, problem.start + 1e-3, True)
    assert found.values[0, 0] == pytest.approx(snapped_height(load - 1e-3) - 0.5, rel=1e-9)
    return replace(found, design=problem.start.copy())


def _undeformed(problem: Problem) -> np.ndarray:
    scene = problem.scene.with_number("loads.push.force.y", -1e-6)
    return Evaluator(replace(problem, scene=scene), DesignStore())(0, np.array([-1e-6]), False).states[0].q


def test_an_equilibrium_beyond_a_snap_through_is_found_out_and_the_search_repeated_from_the_unloaded_state(tmp_path):
    problem = only_load(tmp_path, "[constraints]\nrise = { above = -1.5 }" + QUICK, least=-40.0)
    beyond = snapped(problem, 30.0)
    again = solved_again(problem, beyond)
    assert "beyond a snap-through" in again.refusal
    folder = tmp_path / "kept"
    folder.mkdir()
    store = DesignStore(folder / STORE, problem.fingerprint)
    store.keep(beyond.key, beyond)  # as if a warm start had led the search there
    store.write()
    found = optimized(problem, folder)
    assert found.searches[0].lane == 1  # repeated without warm starts
    assert found.success
    assert found.values["rise"] == pytest.approx(height(40.0) - 0.5, rel=1e-9)


def same(one: Optimum, other: Optimum) -> None:
    """All designs of two runs to the bit."""
    assert len(one.solved) == len(other.solved)
    for a, b in zip(one.solved, other.solved, strict=True):
        assert (a.lane, a.design.tobytes(), a.reason, a.values.tobytes(), a.gradients.tobytes()) == (
            b.lane, b.design.tobytes(), b.reason, b.values.tobytes(), b.gradients.tobytes(),
        )  # fmt: skip
        assert [(s.q.tobytes(), s.multipliers.tobytes()) for s in a.states] == [
            (s.q.tobytes(), s.multipliers.tobytes()) for s in b.states
        ]


KILLED = """
import os, signal, sys
import ffrf
ffrf.optimize(sys.argv[1], output=sys.argv[2], progress=lambda done, total: os.kill(os.getpid(), signal.SIGKILL) if done > 5 else None)
"""


@pytest.mark.robustness
def test_a_killed_study_goes_on_to_the_same_bits_and_solves_nothing_twice(tmp_path):
    text = DROP + "[search]\ncertify = false\nstarts = 2\nwarm_starts = true\n"
    path, folder = write_truss(tmp_path, text), tmp_path / "kept"
    run = subprocess.run([sys.executable, "-c", KILLED, path, folder], env=os.environ, cwd=Path(__file__).parents[2], check=False)
    assert run.returncode == -signal.SIGKILL
    problem = problem_of(read_study(path))
    kept = DesignStore(folder / STORE, problem.fingerprint)
    assert 0 < kept.found < 7  # what was solved within the last moment may be lost
    found, whole = optimized(problem, folder), optimized(problem)
    same(found, whole)
    assert found.failed == whole.failed
    again = DesignStore(folder / STORE, problem.fingerprint)
    assert again.found == len(whole.solved) > kept.found
    solved = {(each.lane, each.design.tobytes()) for each in again}
    assert len(solved) == again.found


def test_a_store_of_another_study_is_left_as_it_is(tmp_path):
    folder = tmp_path / "kept"
    folder.mkdir()
    optimized(only_load(tmp_path, QUICK.replace("certify", "evaluations = 3\ncertify")), folder)
    before = (folder / STORE).read_bytes()
    with pytest.raises(StudyFileError, match="belongs to another study"):
        optimized(only_load(tmp_path, "[constraints]\nrise = { above = -0.1 }"), folder)
    assert (folder / STORE).read_bytes() == before


def test_optima_and_uncertain_numbers_too_are_kept_for_the_order_of_their_tables(tmp_path):
    """Arrays are kept by the places of variables, cases and responses."""
    springs = [f"loads.{side}.stiffness" for side in ("left", "right")]
    loads = [f"[cases.{name}]\n{LOAD} = {load}\n" for name, load in (("more", -20.0), ("less", -10.0))]
    for first, second in (
        ("variables", "{ between = [900.0, 1100.0] }"),
        ("uncertain", '{ distribution = "normal", sigma = 9.0 }'),
    ):
        keys = set()
        for names in (springs, springs[::-1]):
            for cases in (loads, loads[::-1]):
                numbers = "".join(f'"{name}" = {second}\n' for name in names)
                text = f'scene = "scene.toml"\n[{first}]\n{numbers}[objective]\nminimize = "rise"\n{"".join(cases)}'
                described = read_study(write_truss(tmp_path, text))
                problem = problem_of(described) if first == "variables" else uncertain_study(described).problem
                keys.add(problem.fingerprint)
        assert len(keys) == 4


PLAIN = 'scene = "scene.toml"\n[variables]\n' + LOAD + " = { between = [-60.0, -10.0] }\n[objective]\n" + 'minimize = "rise"\n'
WRONG = {
    "unknown variable": (PLAIN.replace("push.force.y", "pull.force.y"), "unknown design variable 'loads.pull.force.y'", 3),
    "unknown response": (
        PLAIN.replace('"rise"', '"fall"'),
        "objective: no response 'fall', there is none of that name; possible here: ",
        4,
    ),
    "misspelt response": (
        PLAIN.replace('"rise"', '"rize"'),
        "objective: no response 'rize', there is none of that name, did you mean 'rise'; possible",
        4,
    ),
    "unknown constraint": (PLAIN + "[constraints]\nfall = { below = 1.0 }", "constraints.fall: no response 'fall'", 7),
    "unknown key": (PLAIN + "[serach]\nstarts = 2", "did you mean 'search'", 6),
    "empty bounds": (PLAIN.replace("[-60.0, -10.0]", "[-10.0, -60.0]"), "holds nothing", 3),
    "start outside": (
        PLAIN.replace("[-60.0, -10.0]", "[-60.0, -40.0]"),
        "the scene stands at -30, which is not between -60 and -40",
        3,
    ),
    "contradiction": (PLAIN + "[constraints]\nrise = { above = 1.0, below = 0.5 }", "contradict each other", 7),
    "no limit": (PLAIN + "[constraints]\nrise = { scale = 1.0 }", "needs a limit", 7),
    "two objectives": (PLAIN + 'maximize = "rise"', "one of `minimize` and `maximize`", 4),
    "analysis": ('analysis = "buckling"\n' + PLAIN, "'statics', 'motion' or 'modes'", 1),
    "margin of a motion": (
        'analysis = "motion"\n' + PLAIN + "[constraints]\nload_margin = { above = 1.1 }",
        'Write analysis = "statics"',
        8,
    ),
    "case of a variable": (PLAIN + f"[cases.more]\n{LOAD} = -40.0", "is driven by the variable", 6),
    "unknown number of a case": (PLAIN + '[cases.more]\n"loads.pull.torque" = 1.0', "cases.more: ", 6),
    "worst of nothing": (PLAIN + 'over_cases = "worst"', "`aggregation`", 4),
    "unknown response kind": (PLAIN + '[responses]\nnew = { type = "nothing" }', "responses.new.type = 'nothing' is unknown", 7),
    "response of an unknown body": (
        PLAIN + '[responses]\nnew = { type = "displacement", body = "tp", point = "P", component = "y" }',
        "responses.new names body 'tp'",
        7,
    ),
    "response of the scene": (
        PLAIN + '[responses]\nrise = { type = "displacement", body = "tip", point = "P", component = "y" }',
        "another name",
        7,
    ),
    "factors": (
        PLAIN.replace(
            "[objective]", 'k = { of = ["loads.left.stiffness"], factors = [1.0, 2.0], between = [0.0, 1.0] }\n[objective]'
        ),
        "1 paths but 2 factors",
        4,
    ),
    "the path of another number": (
        PLAIN.replace(f"{LOAD} = {{ between", '"points.P.y" = { of = ["loads.push.force.y"], between'),
        "variables.points.P.y: that is the path of a number, and the variable drives loads.push.force.y instead",
        3,
    ),
    "one number twice": (
        PLAIN.replace("[objective]", f"k = {{ of = [{LOAD}], between = [0.0, 1.0] }}\n[objective]"),
        "are the same number",
        2,
    ),
    "method": (PLAIN + '[search]\nmethod = ["mma", "sqp"]', "search.method.1: input should be 'slsqp'", 7),
    "idle objective": (PLAIN.replace("rise", "sway"), "no variable moves sway", 4),
}
"""Study -> what is said of it, and of which line."""


@pytest.mark.parametrize("name", WRONG)
def test_wrong_studies_are_refused_in_clear_words_with_the_line(tmp_path, name):
    text, words, line = WRONG[name]
    with pytest.raises(InputError) as error:
        ffrf.optimize(write_truss(tmp_path, text))
    assert words in str(error.value)
    assert str(error.value).startswith("study.toml: ")
    assert re.findall(r"\(line (\d+)\)", str(error.value)) == [str(line)]


def test_a_study_of_which_no_start_can_be_solved_says_why(tmp_path):
    text = PLAIN.replace("[-60.0, -10.0]", "[-500.0, -300.0]") + "[search]\nstarts = 3\n"
    problem = study(tmp_path, text, **{"-30.0": "-400.0"})
    with pytest.raises(NoOptimumError, match=r"not one design could be solved(.|\n)*start 3: the static path ends at"):
        optimized(problem)


def test_python_and_the_command_give_the_same_optimum(tmp_path):
    path = write_truss(tmp_path, PLAIN.replace("-60.0", "-36.0"))  # with its gradients certified
    run = CliRunner().invoke(app, ["optimize", str(path), "--json", "--quiet", "-o", str(tmp_path / "out")])
    assert run.exit_code == 0, run.output
    record = json.loads(run.stdout)
    found = ffrf.optimize(path, output=tmp_path / "out")  # from the store
    assert record["optimum"]["variables"] == found.variables
    assert record["optimum"]["responses"]["rise"] == {"value": found.values["rise"], "unit": "m"}
    assert record["optimality"] == found.optimality < 1e-3
    assert (record["evaluations"], record["failed"], record["success"]) == (found.evaluations, found.failed, True)
    assert record["verdict"]["trusted"] == found.verdict.trusted
    assert record["optimum"]["snap_through"] == {"load_factor": pytest.approx(limit_load() / 36, rel=1e-6), "found": True}
    price = {each["of"]: each for each in record["optimum"]["multipliers"]}["loads.push.force.y"]
    assert price["price"] == pytest.approx(-1 / force_slope(height(36.0)), rel=1e-6)
    assert record["wall_s"] > 0
    assert json.loads((tmp_path / "out" / "optimum.json").read_text()) == record
    head, *rows = ((tmp_path / "out" / "history.csv").read_text()).splitlines()
    assert head == "search,design,loads.push.force.y,rise,failed because"
    assert len(rows) == found.evaluations
    best = min(rows, key=lambda row: float(row.split(",")[3])).split(",")
    assert [float(each) for each in best[2:4]] == [found.variables["loads.push.force.y"], found.design.values[0, 0]]
    drawn = {file.relative_to(tmp_path / "out").as_posix() for file in (tmp_path / "out").rglob("*.png")}
    assert {"history.png", "before/step-0.png", "after/step-0.png"} <= drawn


def test_the_command_exits_with_an_error_where_there_is_no_optimum(tmp_path):
    path = write_truss(tmp_path, PLAIN.replace("-60.0", "-200.0") + "[search]\ncertify = false\nevaluations = 4\n")
    run = CliRunner().invoke(app, ["optimize", str(path), "--quiet", "--no-pictures", "-o", str(tmp_path / "out")])
    assert run.exit_code == 1
    assert "no optimum was found" in run.stderr
    assert "NOT TO BE TRUSTED" in run.stdout
    told = CliRunner().invoke(app, ["optimize", str(path), "--quiet", "--json", "--no-pictures", "-o", str(tmp_path / "out")])
    assert (told.exit_code, json.loads(told.stdout)["verdict"]["trusted"]) == (
        1,
        False,
    )  # one object, though there is an error too
    assert "no optimum was found" in told.stderr
