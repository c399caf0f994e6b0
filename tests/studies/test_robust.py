"""Robust optima, mean + k sigma over uncertain numbers, against closed forms and random designs."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import ffrf
from tests.models.truss import HALF, HEIGHT, REST, force, force_slope, height, write_truss
from toolkit.command_line.cli import app
from toolkit.foundation.errors import InputError
from toolkit.studies.optimization.optimize import optimized
from toolkit.studies.problem import Problem, problem_of
from toolkit.studies.solved_design import solve_design
from toolkit.studies.study_file import read_study
from toolkit.studies.sweep import run_sweep, sweep_problem

LOAD = '"loads.push.force.y"'
SPRINGS = '["loads.left.stiffness", "loads.right.stiffness"]'
ROBUST = f"""
scene = "scene.toml"
[variables]
{LOAD} = {{ between = [-60.0, -10.0] }}
[uncertain]
{LOAD} = {{ distribution = "normal", sigma = 1.5 }}
k = {{ distribution = "uniform", between = [-120.0, 120.0], of = {SPRINGS} }}
[objective]
maximize = "rise"
[constraints]
rise = {{ below = -0.06, robust = 2.0 }}
[search]
certify = false
optimality = 1e-6
"""
"""The least load under which 2 sigma of all trusses sink by 0.06 m: load and both springs, by the same, are not known exactly."""
SIGMAS = 1.5, 120.0 / np.sqrt(3.0)


def study(folder: Path, text: str = ROBUST) -> Problem:
    return problem_of(read_study(write_truss(folder, text)))


def drop(load: complex, stiffness: float) -> complex:
    """What `height` is less the height without load, in complex numbers: Newton's iterations from the real root."""
    y = complex(height(load.real, stiffness))
    for _ in range(3):
        length = (HALF**2 + y * y) ** 0.5
        y -= (2 * stiffness * y * (REST / length - 1) - load) / (2 * stiffness * (REST * HALF**2 / length**3 - 1))
    return y - HEIGHT


def test_the_gradient_of_mean_and_sigma_is_that_of_a_complex_step_through_the_closed_form(tmp_path):
    """Over the points of the problem; deviation of the load and of the springs, far from one another in size."""
    problem = study(tmp_path)
    found = solve_design(problem, 0, np.array([-20.0]), None)
    step = 1e-30
    points, fit = problem.points, problem.points.fit
    values = np.array(
        [drop(20.0 - points.shifts[k, 0] - 1j * step, points.at(k)["k"]) for k in range(len(points))]
    )  # the force grows downwards
    coefficients = fit @ values
    mean, sigma = coefficients[0], np.sqrt(np.sum(coefficients[1:] ** 2))
    at = {name: (found.values[0, k], found.gradients[0, k, 0]) for k, name in enumerate(problem.responses)}
    assert list(at) == ["rise", "rise + 2 sigma", "mean of rise", "sigma of rise"]
    for name, wanted in {"rise + 2 sigma": mean + 2 * sigma, "mean of rise": mean, "sigma of rise": sigma}.items():
        assert at[name] == pytest.approx((wanted.real, wanted.imag / step), rel=1e-10), name
    assert at["rise"][0] == pytest.approx(height(20.0) - HEIGHT, rel=1e-9)


def test_curvatures_of_mean_and_sigma_are_differences_of_their_gradients(tmp_path):
    """Of squares of what grows linearly, whose curvature is told exactly; by central differences, off by the square of the step."""
    random = np.random.default_rng(4)
    points = study(tmp_path).points
    rates, x = random.normal(size=(len(points), 3)), np.array([0.7, -0.4, 1.1])

    def at(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return (rates @ x) ** 2, 2 * (rates @ x)[:, None] * rates

    def slopes(x: np.ndarray) -> np.ndarray:
        _, by_mean, _, by_sigma = points.statistics(*at(x), 0.0)
        return np.array([by_mean, by_sigma])

    found = points.curvatures(*at(x), 2 * rates[:, :, None] * rates[:, None, :], 0.0)
    exact = np.stack([(slopes(x + 1e-4 * way) - slopes(x - 1e-4 * way)) / 2e-4 for way in np.eye(3)], axis=-1)
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-7 * np.abs(exact).max())


def test_mean_and_sigma_of_the_optimum_are_those_of_random_trusses(tmp_path):
    """10000 of the closed form: their standard errors, and what a polynomial of degree 2 leaves, half a per cent of sigma."""
    found = optimized(study(tmp_path))
    assert found.success, found.verdict
    load, random = -found.variables["loads.push.force.y"], np.random.default_rng(5)
    loads, springs = random.normal(load, 1.5, 10_000), random.uniform(880.0, 1120.0, 10_000)
    drops = np.array([height(a, b) for a, b in zip(loads, springs, strict=True)]) - HEIGHT
    mean, sigma = np.mean(drops), np.std(drops)
    assert found.values["mean of rise"] == pytest.approx(mean, abs=0.02 * sigma)
    assert found.values["sigma of rise"] == pytest.approx(sigma, rel=0.03)
    assert found.values["rise + 2 sigma"] == pytest.approx(-0.06, rel=1e-5)
    (judged,) = found.robust
    assert judged.judged == pytest.approx((mean, sigma), rel=0.03)
    assert load > force(HEIGHT - 0.06) + 2.0  # without a spread the limit load would do


def test_a_robust_objective_is_worse_than_its_mean_on_the_side_that_hurts(tmp_path):
    text = ROBUST.replace("[constraints]\nrise = { below = -0.06, robust = 2.0 }\n", "")
    for wish, sign, bound in (("maximize", -1, -10.0), ("minimize", 1, -30.5)):
        wanted = text.replace('maximize = "rise"', f'{wish} = "rise"\nrobust = 3.0').replace("[-60.0,", "[-30.5,")
        found = optimized(study(tmp_path, wanted))
        assert found.variables["loads.push.force.y"] == pytest.approx(bound)
        mean, sigma = found.values["mean of rise"], found.values["sigma of rise"]
        assert found.objective == pytest.approx(mean + 3 * sign * sigma, rel=1e-12)
        assert sigma > 0.01 * abs(mean)


def test_weighted_responses_of_cases_are_robust_together(tmp_path):
    """mean and sigma of 2 rise - rise are those of the rise."""
    both = ROBUST.replace('maximize = "rise"', "robust = 1.0\n[objective.maximize]\nrise = 2.0\nagain = -1.0")
    again = '[responses]\nagain = { type = "displacement", body = "tip", point = "P", component = "y" }\n'
    cases = '[cases.soft]\n"points.L.y" = -0.01\n[cases.firm]\n'
    problem = study(tmp_path, both + again + cases)
    found = solve_design(problem, 0, np.array([-20.0]), None)
    place = {name: k for k, name in enumerate(problem.responses)}
    assert found.values[:, place["sigma of the objective"]] == pytest.approx(found.values[:, place["sigma of rise"]], rel=1e-12)
    assert found.values[0, place["sigma of rise"]] != found.values[1, place["sigma of rise"]]
    assert problem.weights == {"the objective - 1 sigma": 1.0}


def test_a_sweep_of_a_robust_study_has_its_means_and_deviations(tmp_path):
    text = ROBUST + "[sweep]\nlevels = 2\n"
    found = run_sweep(sweep_problem(read_study(write_truss(tmp_path, text.replace("-60.0", "-20.0")))))
    first = force_slope(height(10.0))
    slopes = np.array([1 / first, (HEIGHT - height(10.0, 1001.0)) - (HEIGHT - height(10.0))])
    linear = float(np.hypot(slopes[0] * SIGMAS[0], slopes[1] * SIGMAS[1]))
    assert found.values("sigma of rise")[1] == pytest.approx(linear, rel=0.05)  # far from the limit load: nearly straight
    assert np.all(np.isfinite(found.gradients("sigma of rise")))


WRONG = {
    "nothing uncertain": (
        re.sub(r"\[uncertain\](.|\n)*?\[objective\]", "[objective]", ROBUST),
        "constraints.rise: nothing is uncertain",
    ),
    "bounds of a variable": (
        ROBUST.replace("sigma = 1.5", "sigma = 1.5, between = [-70.0, 0.0]"),
        'a new name with of = ["loads',
    ),
    "one of several": (
        ROBUST.replace("[uncertain]", f"s = {{ of = {SPRINGS}, between = [-9.0, 9.0] }}\n[uncertain]").replace(
            f"of = {SPRINGS} }}\n[obj", 'of = ["loads.left.stiffness"] }\n[obj'
        ),
        "uncertain.k: loads.left.stiffness is moved by the variable 's' too",
    ),
    "too few points": (ROBUST + "[uncertainty]\npoints = 4\n", "points = 4 are too few for 2 uncertain numbers. Give at least 5"),
    "margin": (ROBUST.replace("rise = { below = -0.06", "load_margin = { above = 1.1"), "cut off there: it has no mean"),
    "case": (ROBUST + '[cases.soft]\n"loads.left.stiffness" = 900.0\n', "is driven by the"),
    "unknown number": (
        ROBUST.replace(f"{LOAD} = {{ distribution", '"loads.pull.force.y" = { distribution'),
        "uncertain.loads.pull",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_cannot_be_robust_is_refused_in_words(tmp_path, name):
    text, words = WRONG[name]
    with pytest.raises(InputError) as error:
        ffrf.optimize(write_truss(tmp_path, text))
    assert words in str(error.value)
    assert str(error.value).startswith("study.toml: ")


def test_points_that_cannot_see_the_spread_are_told_by_the_judgement_at_the_optimum(tmp_path):
    """Straight lines near the limit load, where the drop bends most."""
    text = ROBUST.replace("rise = { below = -0.06, robust = 2.0 }", "").replace("sigma = 1.5", "sigma = 3.0")
    text = text.replace('maximize = "rise"', 'minimize = "rise"\nrobust = 0.0').replace("-60.0, -10.0", "-32.0, -28.0")
    few = optimized(study(tmp_path, text + "[uncertainty]\npoints = 5\n"))
    assert "robust-points" in few.verdict.codes


def test_the_command_prints_what_the_json_holds(tmp_path):
    path = write_truss(tmp_path, ROBUST)
    run = CliRunner().invoke(app, ["optimize", str(path), "--json", "--quiet", "--no-pictures", "-o", str(tmp_path / "out")])
    assert run.exit_code == 0, run.output
    record = json.loads(run.stdout)
    found = ffrf.optimize(path, output=tmp_path / "out")  # from the store
    assert record["optimum"]["responses"]["sigma of rise"] == {"value": found.values["sigma of rise"], "unit": "m"}
    assert record["optimum"]["robust"]["rise"]["judged"]["sigma"] == found.robust[0].judged[1]
    assert any(line.startswith("rise, by values and gradients: mean -0.0") for line in found.said)
