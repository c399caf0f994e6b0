"""Contour and skin: closed forms on circles and ellipses, and the stations of the reference scene."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ellipeinc

from preprocessing.airfoil.airfoil_file import read_airfoil
from preprocessing.airfoil.contour import Contour
from preprocessing.airfoil.skin import Skin
from toolkit.foundation.errors import InputError

DATA = Path(__file__).parents[1] / "data"
MORPHING = Path(__file__).parents[2] / "models" / "morphing_wing"
CHORD = 550.0  # mm
F_ROW, G_ROW = 50, 170


def circle(n: int) -> np.ndarray:
    """Circle of diameter 1 from its tail (1, 0) anticlockwise, rows (n + 1, 2)."""
    angle = np.linspace(0, 2 * np.pi, n + 1)
    return 0.5 + 0.5 * np.column_stack([np.cos(angle), np.sin(angle)]) - [0, 0.5]


def rate(errors: list[float]) -> float:
    """Order of convergence from errors at numbers of rows that double."""
    return float(np.mean(-np.diff(np.log2(errors))))


@pytest.fixture(scope="module")
def high() -> Contour:
    return Contour.through(read_airfoil(MORPHING / "high_speed.dat").points, CHORD)


@pytest.fixture(scope="module")
def low() -> Contour:
    return Contour.through(read_airfoil(MORPHING / "low_speed.dat").points, CHORD)


@pytest.fixture(scope="module")
def skin(high) -> Skin:
    return Skin(high, high.at_x(137.5, "upper"), high.at_x(137.5, "lower"))


@pytest.fixture(scope="module")
def reference() -> np.ndarray:
    """Columns node, s, x and y of the high-speed shape, x and y of the low-speed shape."""
    return np.loadtxt(DATA / "skin_nodes.csv", delimiter=",", skiprows=1)


# --- curve -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("degree", "order_position", "order_curvature"), [(3, 4, 2), (5, 6, 4)])
def test_spline_of_a_circle_converges_with_the_order_of_its_degree_up_to_the_ends(degree, order_position, order_curvature):
    position, curvature, angle = [], [], []
    for n in (24, 48, 96):
        contour = Contour.through(circle(n), 2.0, degree)
        s = np.linspace(0, contour.length, 500)
        turn = s * 2 * np.pi / contour.length
        exact = 1 + np.column_stack([np.cos(turn), np.sin(turn)]) - [0, 1]
        position.append(np.abs(contour.position(s) - exact).max())
        curvature.append(np.abs(contour.curvature(s) - 1).max())
        angle.append(np.abs(contour.tangent_angle(s) - np.pi / 2 - turn).max())
    # Two doublings: the measured rate has not quite settled. Not-a-knot ends keep the full order.
    assert rate(position) > order_position - 0.4
    assert rate(curvature) > order_curvature - 0.4
    assert rate(angle) > order_position - 1.4


def test_arc_length_of_an_ellipse_is_the_elliptic_integral():
    angle = np.linspace(0, 2 * np.pi, 401)
    contour = Contour.through(np.column_stack([0.5 + 0.5 * np.cos(angle), 0.06 * np.sin(angle)]), CHORD, degree=5)
    # Ellipse with half axes a, b: s(angle) = b E(angle | 1 - a^2/b^2); the nose radius b^2/a is 4 mm.
    exact = CHORD * 0.06 * ellipeinc(angle, 1 - (0.5 / 0.06) ** 2)
    np.testing.assert_allclose(contour.curve.point_s, exact, atol=1e-6)  # sixth order, 400 rows: 1.4e-7
    assert contour.curvature(contour.length / 2) == pytest.approx(0.5 / (CHORD * 0.06**2), rel=1e-4)


@pytest.mark.parametrize("name", ["fx63120.dat", "naca23015.af", "e171.dat"])
def test_arc_length_is_true_between_coarse_rows_too(name):
    contour = Contour.through(read_airfoil(DATA / "airfoils" / name).points, CHORD)
    s = np.linspace(0, contour.length, 20001)
    steps = np.linalg.norm(np.diff(contour.position(s), axis=0), axis=1)
    # A chord of length h on curvature kappa is short by kappa^2 h^2 / 24: 1.8e-5 at the sharpest nose (0.37 / mm), h = 0.057 mm.
    np.testing.assert_allclose(steps, contour.length / 20000, rtol=2e-5)
    np.testing.assert_allclose(steps.sum(), contour.length, rtol=1e-7)  # the same, mean over the loop


def test_contour_passes_through_its_rows(high):
    rows = read_airfoil(MORPHING / "high_speed.dat").points * CHORD
    s = high.curve.point_s
    np.testing.assert_allclose(high.position(s), rows, atol=1e-10)  # round-off of 550 mm
    np.testing.assert_array_less(0, np.diff(s))


def test_chord_only_scales(high):
    unit = Contour.through(read_airfoil(MORPHING / "high_speed.dat").points, 1.0)
    s = np.linspace(0, 1, 50)
    np.testing.assert_allclose(high.position(s * high.length), CHORD * unit.position(s * unit.length), atol=1e-9)  # round-off
    np.testing.assert_allclose(high.tangent_angle(s * high.length), unit.tangent_angle(s * unit.length), atol=1e-9)
    assert high.leading_edge == pytest.approx(CHORD * unit.leading_edge, rel=1e-9)


def test_tangent_angle_and_curvature_are_derivatives_of_position_and_angle(skin):
    s, h = np.linspace(1, skin.length - 1, 200), 1e-4
    angle = skin.tangent_angle(s)
    direction = (skin.position(s + h) - skin.position(s - h)) / (2 * h)
    np.testing.assert_allclose(np.column_stack([np.cos(angle), np.sin(angle)]), direction, atol=1e-8)  # h^2 kappa^2
    slope = (skin.tangent_angle(s + h) - skin.tangent_angle(s - h)) / (2 * h)
    np.testing.assert_allclose(slope, skin.curvature(s), atol=1e-8)  # h times the change of curvature at a row


def test_tangent_angle_is_continuous_from_tail_to_tail(high):
    angle = high.tangent_angle(np.linspace(0, high.length, 5000))
    assert np.abs(np.diff(angle)).max() < 0.1  # 0.25 mm at a nose radius of 4.9 mm
    assert angle[0] == pytest.approx(np.pi, abs=0.2)  # towards the nose
    assert angle[-1] == pytest.approx(2 * np.pi, abs=0.2)  # back to the tail, one half turn later


@pytest.mark.parametrize("side", ["upper", "lower"])
@pytest.mark.parametrize("x", [0.5, 5.0, 137.5, 412.3, 549.0])
def test_at_x_is_a_point_with_that_abscissa_on_that_side(x, side, high):
    s = high.at_x(x, side)
    assert high.position(s)[0] == pytest.approx(x, abs=1e-9)  # round-off
    assert (s < high.leading_edge) == (side == "upper")


def test_at_x_of_a_row_is_the_arc_length_of_the_row(high):
    assert high.at_x(137.5, "upper") == pytest.approx(high.curve.point_s[F_ROW], abs=1e-9)
    assert high.at_x(137.5, "lower") == pytest.approx(high.curve.point_s[G_ROW], abs=1e-9)
    assert high.at_x(550.0, "upper") == 0.0
    assert high.at_x(550.0, "lower") == high.length


def test_leading_edge_is_the_farthest_point_and_not_the_row_of_smallest_x():
    contour = Contour.through(read_airfoil(DATA / "airfoils" / "fx63120.dat").points, 1.0)
    tail = contour.position(0.0)
    distance = np.linalg.norm(contour.position(np.linspace(0, contour.length, 20000)) - tail, axis=1)
    nose = contour.position(contour.leading_edge)
    assert np.linalg.norm(nose - tail) >= distance.max() - 1e-12  # round-off
    assert np.degrees(np.arctan2(nose[1], 1 - nose[0])) == pytest.approx(0.26, abs=0.02)  # row of smallest x: (0, 0)


def test_nearest_point_is_the_foot_of_the_normal(high):
    s = np.array([100.0, 500.0, high.leading_edge, 700.0])
    angle = high.tangent_angle(s)
    outside = high.position(s) + 2.0 * np.column_stack([np.sin(angle), -np.cos(angle)])
    np.testing.assert_allclose([high.nearest(point) for point in outside], s, atol=1e-8)  # round-off through the root


@pytest.mark.parametrize(("call", "message"), [
    (lambda c: c.at_x(560.0, "upper"), "upper side does not reach x = 560; it runs from x = .* to 550"),
    (lambda c: c.at_x(-5.0, "lower"), "lower side does not reach x = -5"),
    (lambda c: c.at_x(10.0, "top"), "side 'top' is unknown; available: upper, lower"),
    (lambda _: Contour.through(circle(20), 0.0), "chord 0.0 must be a positive length"),
    (lambda _: Contour.through(circle(20), 1.0, degree=4), "spline degree 4: available are 3 .* 5"),
    (lambda _: Contour.through(circle(20)[:3], 1.0), "at least 4 points"),
    (lambda _: Contour.through(np.repeat(circle(20), 2, axis=0), 1.0), "rows 0 and 1 .* are equal"),
    (lambda _: Contour.through(circle(20) * [1, np.nan], 1.0), "row 0 .* is not finite"),
])  # fmt: skip
def test_impossible_contours_and_places_are_refused(call, message, high):
    with pytest.raises(InputError, match=message):
        call(high)


# --- reference scene -------------------------------------------------------------------------------------------------


def test_skin_of_the_reference_scene_runs_from_row_50_to_row_170(skin, high):
    assert skin.start == pytest.approx(high.curve.point_s[F_ROW], abs=1e-9)
    assert skin.end == pytest.approx(high.curve.point_s[G_ROW], abs=1e-9)
    assert skin.length == pytest.approx(291.551060, abs=0.5e-6)  # last digit of the check data
    assert (high.leading_edge - skin.start) / skin.length == pytest.approx(0.508, abs=0.5e-3)  # as printed


def test_equal_stations_are_those_of_the_reference_scene(skin, reference):
    s = skin.stations(30)
    np.testing.assert_allclose(s, reference[:, 1], atol=1e-6)  # last digit
    # The check data use the parameter of the cubic as arc length, which is 1.1e-5 mm off between rows at the nose.
    np.testing.assert_allclose(skin.position(s), reference[:, 2:4], atol=1.2e-5)


def test_target_nodes_are_those_of_the_reference_scene(skin, low, reference):
    target = skin.target_positions(low, skin.stations(30))
    np.testing.assert_allclose(target, reference[:, 4:6], atol=1.2e-5)  # as above
    assert target[0] == pytest.approx(skin.position(0.0), abs=1e-9)  # F stays
    assert target[-1] - skin.position(skin.length) == pytest.approx([4.197, 0.0], abs=0.5e-3)  # G slides, as printed


@pytest.mark.parametrize("shape", ["high", "low"])
def test_parameter_of_the_cubic_reproduces_the_reference_scene_to_its_digits(shape, high, low, skin, reference):
    curve, columns = (high.curve, slice(2, 4)) if shape == "high" else (low.curve, slice(4, 6))
    # Six digits: 0.5e-6, and rows of nine digits times 550 mm: 0.3e-6 each, which adds up along the skin.
    np.testing.assert_allclose(curve.spline(curve.point_u[F_ROW] + skin.stations(30)), reference[:, columns], atol=2e-6)


def test_skin_rows_of_both_shapes_are_the_same_material_points(skin, high, low):
    rows = np.arange(F_ROW, G_ROW + 1)
    s = high.curve.point_s[list(rows)] - skin.start
    expected = low.position(low.curve.point_s[list(rows)])
    # The rows are rounded to nine digits, 0.3e-6 mm each, which adds up along the skin.
    np.testing.assert_allclose(skin.target_positions(low, s), expected, atol=2e-6)


def test_skin_is_its_own_target(skin, high):
    s = skin.stations(30)
    np.testing.assert_allclose(skin.target_positions(high, s), skin.position(s), atol=1e-9)  # round-off


def test_equal_elements_shorten_the_nose_and_grading_by_curvature_mends_it(skin):
    def loss(spacing):
        nodes = skin.position(skin.stations(30, spacing))
        return 1 - np.linalg.norm(np.diff(nodes, axis=0), axis=1).sum() / skin.length

    assert loss("equal") == pytest.approx(0.0033, abs=0.5e-4)  # as printed for this scene
    assert loss("curvature") < loss("equal") / 5


def test_graded_stations_share_the_density_evenly(skin):
    stations = skin.stations(12, "curvature", grading=2.0)
    share = []
    for a, b in pairwise(stations):
        s = np.linspace(a, b, 4001)
        share.append(np.trapezoid(1 + 2.0 * np.sqrt(np.abs(skin.curvature(s)) * skin.length), s))
    assert (stations[0], stations[-1]) == (0.0, pytest.approx(skin.length, abs=1e-12))
    np.testing.assert_allclose(share, np.mean(share), rtol=1e-4)  # trapezoids on 22 000 steps of the skin
    np.testing.assert_allclose(skin.stations(12, "curvature", grading=0.0), skin.stations(12), atol=1e-9)  # round-off


def test_locate_agrees_in_all_its_ways(skin):
    stations = skin.stations(30)
    assert skin.locate(node=10, stations=stations) == stations[10]
    assert skin.locate(arc_length=stations[10]) == stations[10]
    assert skin.locate(x=float(skin.position(stations[10])[0]), side="upper") == pytest.approx(stations[10], abs=1e-9)
    assert skin.locate(x=float(skin.position(stations[25])[0]), side="lower") == pytest.approx(stations[25], abs=1e-9)
    assert skin.locate(x=137.5, side="lower") == pytest.approx(skin.length, abs=1e-9)
    assert skin.locate(arc_length=skin.length * (1 + 1e-12)) == skin.length  # round-off at G is not "off the skin"


@pytest.mark.parametrize(("way", "message"), [
    ({"arc_length": 300.0}, r"arc length 300 from F is off the skin; admissible: 0 \(F\) to 291.551 \(G\)"),
    ({"arc_length": -0.1}, "arc length -0.1 from F is off the skin"),
    ({"arc_length": float("nan")}, "arc length nan from F is off the skin"),
    ({"x": 200.0, "side": "upper"}, "x = 200 on the upper side, arc length -62.* from F is off the skin; admissible: 0"),
    ({"x": 200.0, "side": "lower"}, "x = 200 on the lower side, arc length 354.* from F is off the skin"),
    ({"x": 20.0}, "x = 20 needs side='upper' or side='lower'"),
    ({"x": 20.0, "side": "left"}, "side 'left' is unknown"),
    ({"node": 31, "stations": np.linspace(0, 291, 31)}, r"node 31 is not on the skin: nodes count from 0 \(F\) to 30 \(G\)"),
    ({"node": -1, "stations": np.linspace(0, 291, 31)}, "node -1 is not on the skin"),
    ({"node": 3}, "no stations were given"),
    ({}, "exactly one way"),
    ({"arc_length": 1.0, "node": 3}, "exactly one way"),
])  # fmt: skip
def test_points_off_the_skin_are_refused(way, message, skin):
    with pytest.raises(InputError, match=message):
        skin.locate(**way)


def test_exchanged_ends_are_refused_with_the_remedy(high):
    for side in ("upper", "lower"):
        both = high.at_x(137.5, side)
        with pytest.raises(InputError, match=rf"F .* does not come before G .* Both lie on the {side} side; put F on the upper"):
            Skin(high, both, both)
    with pytest.raises(InputError, match=r"F .* does not come before G .* Exchange F and G: F belongs to the upper side"):
        Skin(high, high.at_x(137.5, "lower"), high.at_x(137.5, "upper"))


def test_ends_off_the_contour_are_refused(high):
    with pytest.raises(InputError, match="G at arc length 5000 is off the contour, which runs from 0 to"):
        Skin(high, 400.0, 5000.0)


@pytest.mark.parametrize(("options", "message"), [
    ({"n_elements": 0}, "number of elements 0 must be a whole number"),
    ({"n_elements": 2.5}, "number of elements 2.5 must be a whole number"),
    ({"n_elements": 30, "spacing": "cosine"}, "spacing 'cosine' is unknown; available: equal, curvature"),
    ({"n_elements": 30, "spacing": "curvature", "grading": -1.0}, "grading -1.0 must be zero or positive"),
])  # fmt: skip
def test_impossible_stations_are_refused(options, message, skin):
    with pytest.raises(InputError, match=message):
        skin.stations(**options)


def test_target_in_another_frame_is_refused(skin):
    shifted = read_airfoil(MORPHING / "low_speed.dat").points + np.array([0.0, 0.001])
    with pytest.raises(InputError, match=r"passes F \(137.5, 39.8.*\) at a distance of 0.5.* do not normalise"):
        skin.target_positions(Contour.through(shifted, CHORD), skin.stations(30))


def test_target_that_ends_too_early_is_refused(skin):
    cut = read_airfoil(MORPHING / "low_speed.dat").points[:150]
    with pytest.raises(InputError, match=r"target shape ends at arc length .* before the skin's 291\.551"):
        skin.target_positions(Contour.through(cut, CHORD), skin.stations(30))
