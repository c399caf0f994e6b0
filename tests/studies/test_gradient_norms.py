"""Norms of gradients as responses of studies, against complex steps through the closed form of the truss."""

from __future__ import annotations

import numpy as np
import pytest

import ffrf
from tests.models.truss import HALF, REST, STIFFNESS, height, write_truss
from toolkit.foundation.errors import InputError
from toolkit.studies.problem import problem_of
from toolkit.studies.solved_design import solve_design
from toolkit.studies.study_file import read_study
from toolkit.studies.sweep import run_sweep, sweep_problem
from toolkit.studies.uncertain_study import uncertain_study

LOADS, SPRINGS = (-40.0, -10.0), (-200.0, 300.0)
SLOPE = f"""
scene = "scene.toml"
[variables]
"loads.push.force.y" = {{ between = {list(LOADS)} }}
k = {{ of = ["loads.left.stiffness", "loads.right.stiffness"], between = {list(SPRINGS)} }}
[objective]
minimize = "rise"
[constraints]
"gradient of rise" = {{ below = 0.12 }}
[search]
certify = false
optimality = 1e-5
"""
"""The largest drop that changes by no more than 0.12 m, to first order, over the ranges of load and springs."""


def norm(load: complex, k: complex) -> complex:
    """sqrt((s_F dy/dF)^2 + (s_k dy/dk)^2) where the height y depends on F/k alone: 2 y (L_0/L - 1) = F/k."""
    y = complex(height(load.real, k.real))
    for _ in range(4):
        length = (HALF**2 + y * y) ** 0.5
        y -= (2 * y * (REST / length - 1) - load / k) / (2 * (REST * HALF**2 / length**3 - 1))
    slope = 1 / (2 * (REST * HALF**2 / (HALF**2 + y * y) ** 1.5 - 1))
    by_load, by_k = slope / k, -slope * load / k**2
    return ((by_load * (LOADS[1] - LOADS[0])) ** 2 + (by_k * (SPRINGS[1] - SPRINGS[0])) ** 2) ** 0.5


def test_the_norm_is_exact_and_its_derivative_that_of_a_complex_step_to_the_stated_error(tmp_path):
    problem = problem_of(read_study(write_truss(tmp_path, SLOPE)))
    assert problem.responses == ("rise", "gradient of rise")
    found = solve_design(problem, 0, np.array([-25.0, 50.0]), None)
    step, k = 1e-30, STIFFNESS + 50.0
    assert found.values[0, 1] == pytest.approx(norm(25.0, k).real, rel=1e-10)  # round-off
    by_load, by_k = -norm(25.0 + 1j * step, k).imag / step, norm(25.0, k + 1j * step).imag / step
    assert found.gradients[0, 1] == pytest.approx([by_load, by_k], rel=1e-7)  # of differences
    alone = solve_design(problem, 0, np.array([-25.0, 50.0]), None, gradients=False)
    assert alone.values[0, 1] == found.values[0, 1]


def test_an_optimum_keeps_a_limit_on_the_norm_of_a_gradient_and_says_how_exact_it_is(tmp_path):
    found = ffrf.optimize(write_truss(tmp_path, SLOPE))
    assert found.success, found.verdict
    load, k = -found.variables["loads.push.force.y"], STIFFNESS + found.variables["k"]
    assert norm(load, k).real == pytest.approx(0.12, rel=1e-5)
    (said,) = [each for each in found.verdict.warnings if each.code == "differences"]
    assert "that of rise by " in said.text
    assert not said.doubt
    (price,) = [each for each in found.prices if each.name == "gradient of rise"]
    assert (price.active, price.unit) == (True, "m/m")


def test_a_sweep_has_norms_without_gradients_too(tmp_path):
    text = SLOPE + '[sweep]\npoints = "sobol"\ncount = 4\ngradients = false\nresponses = ["gradient of rise"]\n'
    found = run_sweep(sweep_problem(read_study(write_truss(tmp_path, text))))
    wanted = [norm(-load, STIFFNESS + k).real for load, k in found.designs]
    assert found.values("gradient of rise") == pytest.approx(wanted, rel=1e-9)


def test_uncertain_numbers_have_no_scales_for_a_norm(tmp_path):
    text = SLOPE + '[uncertain]\n"loads.push.force.y" = { distribution = "normal", sigma = 1.0 }\n'
    assert uncertain_study(read_study(write_truss(tmp_path, text))).problem.norms == ()
    asked = text + '[uncertainty]\nresponses = ["gradient of rise"]\n'
    with pytest.raises(InputError, match=r"uncertainty.responses: .* no scales"):
        uncertain_study(read_study(write_truss(tmp_path, asked)))


WRONG = {
    "unknown": (SLOPE.replace("of rise", "of fall"), "constraints.gradient of fall: no response 'fall'"),
    "margin": (SLOPE.replace("of rise", "of load_margin"), "cut off there: its gradient leaps"),
    "twice": (SLOPE.replace("of rise", "of gradient of rise"), "differences of differences. Write 'gradient of rise'"),
    "robust": (SLOPE.replace("below = 0.12", "below = 0.12, robust = 1.0"), "Leave out `robust`"),
}


@pytest.mark.parametrize("name", WRONG)
def test_norms_that_cannot_be_are_refused_in_words(tmp_path, name):
    text, words = WRONG[name]
    uncertain = '[uncertain]\n"points.P.x" = { distribution = "normal", sigma = 1.0 }\n'
    with pytest.raises(InputError, match=words):
        problem_of(read_study(write_truss(tmp_path, text + uncertain if name == "robust" else text)))
