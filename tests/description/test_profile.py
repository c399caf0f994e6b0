"""Time curves: derivatives by time and by parameters, and what they refuse."""

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.interpolate import CubicSpline

from toolkit.description.profile import Constant, Sine, SmoothStep, Sum, Table, is_smooth

TIMES = np.linspace(-0.3, 2.3, 27)
CORNERS = np.array([0.0, 0.25, 0.5, 1.1, 1.75, 2.0])  # where the third derivative of some curve jumps
CURVES = [
    Constant(value=3.0),
    SmoothStep(height=2.0, start=0.25, duration=1.5),
    Sine(amplitude=2.0, frequency=0.7, phase=0.3),
    Table(times=(0.0, 0.5, 1.1, 2.0), values=(0.0, 1.0, -2.0, 0.5)),
    Table(times=(0.0, 0.5, 1.1, 2.0), values=(0.0, 1.0, -2.0, 0.5), interpolation="linear"),
    Sum(terms=(Constant(value=1.0), Sine(frequency=2.0), SmoothStep(duration=2.0))),
]


@pytest.mark.parametrize("curve", CURVES, ids=lambda curve: curve.type)
def test_rates_are_the_derivatives_of_the_curve(curve):
    h = 1e-5
    up, down, middle = (curve.evaluate(TIMES + shift) for shift in (h, -h, 0))
    inside = np.abs(TIMES[:, None] - CORNERS).min(axis=1) > 2 * h
    # truncation h^2 / 6 times a fourth derivative of 3e4 (sine of 2 Hz) = 4e-7, round-off 1e-9
    np.testing.assert_allclose(((up - down) / (2 * h))[inside, :2], middle[inside, 1:], atol=1e-5)


@pytest.mark.parametrize("curve", CURVES, ids=lambda curve: curve.type)
def test_every_number_can_be_complex_and_gives_the_parameter_derivative(curve):
    for path, value in curve.numbers():
        exact = curve.with_number(path, value + 1e-30j).evaluate(TIMES).imag / 1e-30
        up, down = (curve.with_number(path, value + h).evaluate(TIMES) for h in (1e-5, -1e-5))
        inside = np.abs(TIMES[:, None] - CORNERS).min(axis=1) > 1e-3
        # truncation 1e-10 f''' / 6, f''' below 1e4
        np.testing.assert_allclose(exact[inside], ((up - down) / 2e-5)[inside], atol=1e-5)


def test_a_table_goes_through_its_points_and_is_constant_outside():
    for kind in ("cubic", "linear"):
        table = Table(times=(0.0, 0.5, 2.0), values=(1.0, 3.0, -1.0), interpolation=kind)
        values = table.evaluate(np.array([-1.0, 0.0, 0.5, 2.0, 5.0]))
        np.testing.assert_allclose(values[:, 0], [1, 1, 3, -1, -1], atol=1e-14)
        assert values[0, 1] == values[-1, 1] == 0


def test_only_a_linear_table_is_not_smooth():
    line = Table(times=(0.0, 1.0), values=(0.0, 1.0), interpolation="linear")
    assert [is_smooth(curve) for curve in CURVES] == [getattr(curve, "interpolation", "") != "linear" for curve in CURVES]
    assert not is_smooth(line)
    assert not is_smooth(Sum(terms=(line,)))


def test_a_table_whose_times_do_not_increase_is_refused():
    with pytest.raises(ValidationError, match="times must increase"):
        Table(times=(0.0, 1.0, 1.0), values=(1.0, 2.0, 3.0))
    with pytest.raises(ValidationError, match="3 times but 2 values"):
        Table(times=(0.0, 1.0, 2.0), values=(1.0, 2.0))


def test_a_cubic_table_is_the_clamped_spline_of_scipy():
    table = CURVES[3]
    spline = CubicSpline(table.times, table.values, bc_type="clamped")
    inside = np.linspace(0.01, 1.99, 40)
    exact = np.stack([spline(inside, order) for order in range(3)], axis=1)
    np.testing.assert_allclose(table.evaluate(inside), exact, atol=1e-12)  # round-off of second derivatives of order 50


@pytest.mark.parametrize("hit", [0.0, 0.5, 1.1, 2.0])
def test_the_derivative_at_a_corner_that_is_hit_is_that_of_a_central_difference(hit):
    times = (0.0, 0.5, 1.1, 2.0)
    table, k, h = Table(times=times, values=(0.2, 1.0, -2.0, 0.5), interpolation="linear"), times.index(hit), 1e-6
    exact = table.with_number(f"times.{k}", hit + 1e-30j).evaluate(np.array([hit]))[0, 0].imag / 1e-30
    later, earlier = (table.with_number(f"times.{k}", hit + shift).evaluate(np.array([hit]))[0, 0] for shift in (h, -h))
    assert exact == pytest.approx((later - earlier) / (2 * h), abs=1e-4)  # truncation: h times a second derivative below 50
