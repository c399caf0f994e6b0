"""Time curves: derivatives by time and by parameters, closed forms, and what they refuse."""

from typing import Annotated

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.interpolate import CubicSpline, PchipInterpolator

from tests.models.curves import CURVES, RISING, ROUGH, ROWS, VALUES, built_in_curves
from toolkit.api.check import check_curve
from toolkit.components.curves.combined import Product, Sequence, Sum
from toolkit.components.curves.curve import Curve
from toolkit.components.curves.oscillation import Harmonic, Sine
from toolkit.components.curves.polynomial import Constant, Polynomial
from toolkit.components.curves.rise import Cycloid, Ramp, SmoothStep
from toolkit.components.curves.table import Table
from toolkit.description.description import Number, Quantity
from toolkit.foundation.errors import ConformanceError

TIMES = np.linspace(-0.3, 2.3, 27)


def test_the_list_has_every_kind():
    assert {curve.kind for curve in CURVES.values()} == built_in_curves()


@pytest.mark.parametrize("name", CURVES)
def test_every_derivative_is_exact(name):
    """By time to 1e-10 of a complex step; by every number a complex step is what differences extrapolate to."""
    check_curve(CURVES[name], (-0.3, 2.3))


@pytest.mark.parametrize("name", CURVES)
def test_a_corner_that_is_hit_counts_as_the_mean_of_both_sides(name):
    curve = CURVES[name]
    for corner in curve.corners():
        beside = curve.evaluate(np.array([corner - 1e-9, corner + 1e-9]))
        # second derivatives are below 100, third below 1000
        np.testing.assert_allclose(curve.evaluate(np.array([corner]))[0], beside.mean(axis=0), atol=2e-6)


@pytest.mark.parametrize(
    "curve", [SmoothStep(), Cycloid(), Ramp(smoothness="cubic"), CURVES["cubic table"], CURVES["monotone table"]]
)
def test_what_ends_at_rest_is_at_rest_at_its_end_to_the_last_digit(curve):
    """No round-off of the sides is left: a scene that rests is not said to spin."""
    first, last = curve.corners()[0], curve.corners()[-1]
    assert np.all(curve.evaluate(np.array([first, last]))[:, 1] == 0)


@pytest.mark.parametrize("name", CURVES)
def test_what_is_smooth_has_a_slope_that_jumps_nowhere(name):
    curve = CURVES[name]
    corners = np.array(curve.corners())
    sides = [curve.evaluate(np.nextafter(corners, side))[:, 1] for side in (-np.inf, np.inf)]
    assert bool(curve.kink()) == (name in ROUGH) == bool(np.any(np.abs(sides[1] - sides[0]) > 1e-9))


def test_a_table_goes_through_its_points_and_is_constant_outside():
    for kind in ("cubic", "monotone", "linear"):
        table = Table(times=(0.0, 0.5, 2.0), values=(1.0, 3.0, -1.0), interpolation=kind)
        values = table.evaluate(np.array([-1.0, 0.0, 0.5, 2.0, 5.0]))
        np.testing.assert_allclose(values[:, 0], [1, 1, 3, -1, -1], atol=1e-14)
        assert values[0, 1] == values[-1, 1] == 0


def test_a_table_whose_times_do_not_increase_is_refused():
    with pytest.raises(ValidationError, match="times must increase"):
        Table(times=(0.0, 1.0, 1.0), values=(1.0, 2.0, 3.0))
    with pytest.raises(ValidationError, match="3 times but 2 values"):
        Table(times=(0.0, 1.0, 2.0), values=(1.0, 2.0))


def test_a_cubic_table_is_the_clamped_spline_of_scipy():
    spline = CubicSpline(ROWS, VALUES, bc_type="clamped")
    inside = np.linspace(0.01, 1.99, 40)
    exact = np.stack([spline(inside, order) for order in range(3)], axis=1)
    # round-off of second derivatives of order 50
    np.testing.assert_allclose(CURVES["cubic table"].evaluate(inside), exact, atol=1e-12)


def test_a_monotone_table_is_the_pchip_of_scipy_between_its_inner_rows():
    """At both ends its slope is zero, which scipy's is not."""
    inside = np.linspace(ROWS[1] + 0.01, ROWS[2] - 0.01, 40)
    pchip = PchipInterpolator(ROWS, RISING)
    exact = np.stack([pchip(inside, order) for order in range(3)], axis=1)
    np.testing.assert_allclose(CURVES["monotone table"].evaluate(inside), exact, atol=1e-12)


def test_a_monotone_table_never_leaves_the_values_beside_it():
    rng = np.random.default_rng(3)
    for _ in range(50):
        rows, values = np.cumsum(rng.uniform(0.01, 1, 8)), rng.choice([0.0, 1.0, 2.5, -3.0], 8)
        f = Table(times=tuple(rows), values=tuple(values), interpolation="monotone").evaluate(np.linspace(rows[0], rows[-1], 999))
        k = np.clip(np.searchsorted(rows, np.linspace(rows[0], rows[-1], 999), "right") - 1, 0, 6)
        low, high = np.minimum(values[k], values[k + 1]), np.maximum(values[k], values[k + 1])
        assert np.all(f[:, 0] >= low - 1e-12)
        assert np.all(f[:, 0] <= high + 1e-12)


def test_the_derivative_of_a_monotone_table_by_equal_values_is_that_of_a_central_difference():
    table, h, at = Table(times=ROWS, values=(0.0, 1.0, 1.0, 2.0), interpolation="monotone"), 1e-6, np.array([0.3, 0.8, 1.4])
    exact = table.with_number("values.1", 1.0 + 1e-30j).evaluate(at).imag[:, 0] / 1e-30
    up, down = (table.with_number("values.1", 1.0 + shift).evaluate(at)[:, 0] for shift in (h, -h))
    np.testing.assert_allclose(exact, (up - down) / (2 * h), atol=1e-5)  # truncation: h times a second derivative below 10


@pytest.mark.parametrize("hit", ROWS)
def test_the_derivative_at_a_corner_that_is_hit_is_that_of_a_central_difference(hit):
    table, k, h = Table(times=ROWS, values=(0.2, 1.0, -2.0, 0.5), interpolation="linear"), ROWS.index(hit), 1e-6
    exact = table.with_number(f"times.{k}", hit + 1e-30j).evaluate(np.array([hit]))[0, 0].imag / 1e-30
    later, earlier = (table.with_number(f"times.{k}", hit + shift).evaluate(np.array([hit]))[0, 0] for shift in (h, -h))
    assert exact == pytest.approx((later - earlier) / (2 * h), abs=1e-4)  # truncation: h times a second derivative below 50


def test_closed_forms():
    u = (TIMES - 0.2) / 1.3
    cycloid = np.where(u < 0, 0, np.where(u > 1, 1, u - np.sin(2 * np.pi * u) / (2 * np.pi)))
    cubic = np.interp(TIMES, [0.3, 1.2], [0, 1])
    expected = {
        "cycloid": -1.4 * cycloid,
        "linear ramp": np.interp(TIMES, [0.3, 1.2], [0.4, -1.0]),
        "cubic ramp": 0.4 - 1.4 * (3 * cubic**2 - 2 * cubic**3),
        "polynomial": np.polynomial.Polynomial([0.3, -1.1, 0.7, 0.2])(TIMES - 0.6),
        "harmonic": -0.8 + 1.2 * np.cos(1.2 * np.pi * TIMES + 0.4),
    }
    for name, values in expected.items():
        np.testing.assert_allclose(CURVES[name].evaluate(TIMES)[:, 0], values, atol=1e-14)


def test_a_cycloid_has_neither_slope_nor_curvature_at_both_ends_and_twice_the_mean_slope_between():
    f = Cycloid(height=3.0, start=0.5, duration=2.0).evaluate(np.array([0.5, 1.5, 2.5]))
    np.testing.assert_allclose(f, [[0, 0, 0], [1.5, 3.0, 0], [3.0, 0, 0]], atol=1e-14)


def test_a_sequence_goes_on_from_the_value_that_was_reached():
    """Up by 2 from 1, a rest, and back down by 3; the third begins at its own time zero."""
    up, down = Ramp(initial=1.0, final=3.0), Ramp(initial=0.0, final=-3.0, end=0.5)
    f = Sequence(curves=(up, Constant(value=77.0), down), times=(1.0, 2.0)).evaluate(np.array([-1, 0.5, 1.0, 1.7, 2.25, 9.0]))
    np.testing.assert_allclose(f[:, 0], [1.0, 2.0, 3.0, 3.0, 1.5, 0.0], atol=1e-14)


def test_a_product_is_switched_on_and_a_sum_of_products_is_a_closed_form():
    """sin(a) (1 + cos(2 a) / 2): by factors as well as by sines of a and 3 a, sin(a) cos(2 a) = (sin(3 a) - sin(a)) / 2."""
    wave = Product(curve=Sine(frequency=0.5), factors=(Harmonic(offset=1.0, amplitude=0.5, frequency=1.0),))
    same = Sum(terms=(Sine(amplitude=0.75, frequency=0.5), Sine(amplitude=0.25, frequency=1.5)))
    np.testing.assert_allclose(wave.evaluate(TIMES), same.evaluate(TIMES), atol=1e-13)  # f'' of order 10


def test_wrong_curves_are_refused_in_words():
    with pytest.raises(
        ValidationError, match=r"end = 0.2 is not after start = 0.5; times of a ramp increase, its values may fall"
    ):
        Ramp(start=0.5, end=0.2)
    with pytest.raises(ValidationError, match="2 curves but 2 times; give one time less than curves"):
        Sequence(curves=(Constant(), Constant()), times=(0.1, 0.2))
    with pytest.raises(ValidationError, match="times must increase from curve to curve"):
        Sequence(curves=(Constant(), Constant(), Constant()), times=(0.2, 0.1))
    nested: Curve = Constant()
    for _ in range(3):
        nested = Sequence(curves=(Sum(terms=(nested,)), Constant()), times=(1.0,))
    with pytest.raises(ValidationError, match="sequences stand in each other more than 3 deep; write one"):
        Sequence(curves=(nested, Constant()), times=(1.0,))
    jumping = Sequence(curves=(Polynomial(coefficients=(0.0, 2.0)), Constant()), times=(0.5,))
    assert "the slope jumps, from 2 to 0 at t = 0.5, where its curve 1 takes over from curve 0" in jumping.kink()
    for rough in (CURVES["linear ramp"], CURVES["linear table"]):
        for whole in (
            Sum(terms=(rough,)),
            Product(curve=rough, factors=(Sine(frequency=1.0),)),
            Sequence(curves=(rough, Constant()), times=(9.0,)),
        ):
            assert whole.kink() == rough.kink()


class Decay(Curve):
    """f(t) = exp(-rate t)."""

    kind = "decay"

    rate: Annotated[Number, Quantity("1/time")] = 1.3

    def rates(self, time):
        f = np.exp(-self.rate * time)
        return f, -self.rate * f, self.rate**2 * f


class Turned(Decay):
    """The sign of f'' is wrong."""

    kind = "turned"

    def rates(self, time):
        f, slope, curvature = super().rates(time)
        return f, slope, -curvature


class Dropped(Decay):
    """An imaginary part is dropped."""

    kind = "dropped"

    def rates(self, time):
        f = np.exp(-np.real(self.rate) * time)
        return f, -self.rate * f, self.rate**2 * f


class Short(Decay):
    """A rate is missing."""

    kind = "short"

    def rates(self, time):
        return super().rates(time)[:2]


def test_a_curve_of_ones_own_is_checked():
    check_curve(Decay())
    for wrong, words in {
        Turned: r"f'' of the time curve 'turned' is wrong at \(t = .*a complex step gives",
        Dropped: r"the derivative of f of the time curve 'dropped' by rate is wrong .* no abs, no real part",
        Short: r"`rates` of the time curve 'short' gives 2 arrays; three are needed",
    }.items():
        with pytest.raises(ConformanceError, match=words):
            check_curve(wrong())
