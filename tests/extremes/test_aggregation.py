"""Smooth maxima from nearly the mean to nearly the maximum, in MPa and in Pa."""

from __future__ import annotations

import numpy as np
import pytest

from tests.models.scenes import WING
from toolkit.analyses.sensitivity.direct import direct
from toolkit.analyses.sensitivity.preparation import prepare, solve
from toolkit.files.scene_reader import read_scene
from toolkit.responses.stress import KSStress, MaxStress, gap_bound, kreisselmeier_steinhauser, stress_field

RATES = [1e-6, 1e-3, 1.0, 1e3, 1e6]
"""rho in 1/MPa."""
VALUES = np.random.default_rng(4).normal(20.0, 30.0, (12, 50))


@pytest.fixture(scope="module")
def wing():
    return solve(prepare(read_scene(WING), ["t_w"]), "transient")


@pytest.mark.parametrize("aggregation", RATES)
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6, 1e12])
def test_a_unit_of_stress_changes_the_smooth_maximum_in_proportion(aggregation, scale):
    """KS(c g; rho / c) = c KS(g; rho); weights are pure numbers. From MPa to TPa, to Pa, and absurdly far."""
    value, weights = kreisselmeier_steinhauser(VALUES, aggregation)
    other, same = kreisselmeier_steinhauser(scale * VALUES, aggregation / scale)
    # ln(n) / rho of 6e6 at 1e-6 has its round-off, too
    assert other / scale == pytest.approx(value, rel=1e-12)
    np.testing.assert_allclose(same, weights, rtol=1e-9, atol=1e-300)  # round-off of the exponent, up to 1e8 x 1e-16


@pytest.mark.parametrize("aggregation", [*RATES, 1e300, 1e-12])
def test_the_smooth_maximum_is_between_the_maximum_and_its_bound_without_overflow(aggregation):
    for scale in (1e-6, 1.0, 1e6):
        with np.errstate(all="raise", under="ignore"):
            value, weights = kreisselmeier_steinhauser(scale * VALUES, aggregation)
        largest = scale * VALUES.max()
        assert largest <= value <= (largest + gap_bound(VALUES.size, aggregation)) * (1 + 1e-12)
        assert weights.sum() == pytest.approx(1, rel=1e-12)


def test_its_limits_are_the_maximum_and_the_mean():
    """rho -> 0: max + ln(n)/rho from below, with KS - ln(n)/rho -> mean + rho variance / 2; rho -> infinity: the maximum."""
    for rho in (1e-6, 1e-4):
        value, weights = kreisselmeier_steinhauser(VALUES, rho)
        mean = value - np.log(VALUES.size) / rho
        # round-off of ln(n)/rho = 6.4 / rho, and the third moment
        assert mean == pytest.approx(VALUES.mean() + rho * VALUES.var() / 2, abs=1e-14 / rho + 1e5 * rho**2)
        np.testing.assert_allclose(weights * VALUES.size, 1, rtol=1e2 * rho)  # the largest value times rho
    value, weights = kreisselmeier_steinhauser(VALUES, 1e6)
    assert value == VALUES.max()
    assert weights.flat[np.argmax(VALUES)] == 1


@pytest.mark.parametrize("aggregation", RATES)
def test_the_stress_of_the_wing_and_its_slope_are_bounded_by_those_of_the_field(wing, aggregation):
    field, slopes = stress_field(wing, "skin")
    value, (slope,) = KSStress(body="skin", aggregation=aggregation).evaluate(wing)
    assert field.max() <= value <= field.max() + gap_bound(field.size, aggregation)
    assert slopes.min() <= slope <= slopes.max()
    if aggregation == 1e6:
        top, (top_slope,) = MaxStress(body="skin").evaluate(wing)
        assert value == pytest.approx(top, rel=1e-12)
        assert slope == pytest.approx(top_slope, rel=1e-9)
    if aggregation == 1e-6:
        assert slope == pytest.approx(slopes.mean(), rel=1e-2)  # rho times the spread of the stress, over a small mean


@pytest.mark.parametrize("rho", RATES)
def test_a_reference_stress_makes_it_a_pure_number(wing, rho):
    plain = KSStress(body="skin", aggregation=rho).evaluate(wing)
    divided = KSStress(body="skin", aggregation=1e6 * rho, reference_stress=1e6).evaluate(wing)
    assert divided[0] == pytest.approx(plain[0], rel=1e-12)
    np.testing.assert_allclose(divided[1], plain[1], rtol=1e-9)


@pytest.mark.parametrize("rho", RATES)
def test_stresses_in_pa_with_a_parameter_in_1_per_pa_have_the_same_sharpness(rho):
    """The rotating beam, m-kg-s."""
    path = WING.parents[1] / "rotating_beam" / "scene.toml"
    scene = read_scene(path, {"solver.end_time": "0.01"})
    responses = {
        "pa": KSStress(body="beam", aggregation=rho * 1e-6),
        "relative": KSStress(body="beam", aggregation=rho, reference_stress=1e6),
        "top": MaxStress(body="beam"),
    }
    found = direct(scene.model_copy(update={"responses": responses}), ["t", "E"], "transient")
    assert found.values["pa"] == pytest.approx(found.values["relative"], rel=1e-12)
    assert found.values["pa"] >= found.values["top"]
    for x in ("t", "E"):
        assert found.gradients["pa"][x] == pytest.approx(found.gradients["relative"][x], rel=1e-9)
        assert np.isfinite(found.gradients["pa"][x])
