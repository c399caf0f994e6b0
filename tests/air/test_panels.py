"""Panels of vortices against sections whose flow is known exactly, XFOIL's values, and complex steps."""

from __future__ import annotations

import numpy as np
import pytest

import ffrf
from toolkit.foundation.errors import InputError

STEP = 1e-30


def karman_trefftz(count: int, centre: complex, tail: float, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Contour of a section that a circle through (1, 0) becomes, and the exact pressure coefficients at its points."""
    power = 2 - np.radians(tail) / np.pi
    radius, beta = abs(1 - centre), -np.angle(1 - centre)
    turn = np.exp(1j * (np.linspace(0, 2 * np.pi, count + 1) - beta))
    w = centre + radius * turn
    w[0] = w[-1] = 1
    above, below = (w + 1) ** power, (w - 1) ** power
    z = power * (above + below) / (above - below)
    speed = np.exp(-1j * angle) - np.exp(1j * angle) / turn**2 + 2j * np.sin(angle + beta) / turn
    stretched = 4 * power**2 * (w * w - 1) ** (power - 1) / (above - below) ** 2
    with np.errstate(all="ignore"):
        pressure = 1 - abs(speed / stretched) ** 2
    return np.stack([z.real, z.imag], axis=1), pressure


def naca(count: int, thickness: float, last: float = 0.1015) -> np.ndarray:
    """Symmetric section of four digits; a last coefficient of 0.1036 closes its tail."""
    x = (1 + np.cos(np.linspace(0, np.pi, count // 2 + 1))) / 2
    y = 5 * thickness * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - last * x**4)
    y[0] = y[0] if last < 0.1036 else 0
    return np.concatenate([np.stack([x, y], axis=1), np.stack([x, -y], axis=1)[-2::-1]])


EXACT = [
    (-0.1 + 0.08j, 0, 0, 0.49847929, -0.114332),
    (-0.1 + 0.08j, 0, 5, 1.09395574, -0.117721),
    (-0.1 + 0.08j, 10, 0, 0.51210895, -0.117414),
    (-0.1 + 0.08j, 10, 5, 1.12386722, -0.127470),
    (-0.08 + 0j, 0, 5, 0.58817981, -0.001548),
]
"""Centre of the circle, angle of the tail and of attack in degrees, and the exact coefficients of lift and moment."""


@pytest.mark.fast
@pytest.mark.parametrize(("centre", "tail", "degrees", "lift", "moment"), EXACT)
def test_lift_and_moment_of_exact_sections_are_met_with_order_two(centre, tail, degrees, lift, moment):
    errors = []
    for count, most in ((50, None), (100, None), (200, 2e-4), (400, 5e-5)):
        contour, _ = karman_trefftz(count, centre, tail, np.radians(degrees))
        flow = ffrf.air.panels(contour, angle_of_attack=np.radians(degrees))
        assert most is None or abs(flow.cl - lift) < most
        assert most is None or abs(flow.cm - moment) < most
        assert most is None or abs(flow.cl_by_pressure / flow.cl - 1) < 1e-3
        errors.append(abs(flow.cl - lift))
    assert np.log2(errors[0] / errors[2]) / 2 > 1.9


@pytest.mark.parametrize("tail", [5, 10, 20])
def test_pressure_is_the_exact_one_and_its_error_falls_with_the_square_of_the_panels(tail):
    errors = []
    for count in (100, 200, 400):
        contour, exact = karman_trefftz(count, -0.1 + 0.08j, tail, np.radians(5))
        off = ffrf.air.panels(contour, angle_of_attack=np.radians(5)).pressure_coefficient[1:-1] - exact[1:-1]
        errors.append(np.sqrt(np.mean(off**2)))
    assert errors[1] < 2e-3
    assert np.log2(errors[0] / errors[2]) / 2 > 1.8


def test_pressure_beside_a_tail_without_angle_is_met_apart_from_its_last_fiftieth():
    contour, exact = karman_trefftz(200, -0.1 + 0.08j, 0, np.radians(5))
    off = ffrf.air.panels(contour, angle_of_attack=np.radians(5)).pressure_coefficient - exact
    before = contour[:, 0] < contour[:, 0].max() - 0.02 * np.ptp(contour[:, 0])
    lengths = np.gradient(np.append(0, np.cumsum(np.hypot(*np.diff(contour, axis=0).T))))
    assert np.sqrt(np.average(off[before] ** 2, weights=lengths[before])) < 2e-3


@pytest.mark.parametrize(("degrees", "lift"), [(4, 0.4831), (8, 0.9638)])
def test_a_blunt_section_has_the_lift_of_xfoil_by_pressure(degrees, lift):
    """XFOIL sums the pressure of 160 panels and prints four digits; a tail of 0.25 % leaves 1e-3 between both ways of lift."""
    flow = ffrf.air.panels(naca(200, 0.12), angle_of_attack=np.radians(degrees))
    assert abs(flow.cl_by_pressure - lift) < 5e-4
    assert abs(flow.cl / flow.cl_by_pressure - 1) < 1e-3


@pytest.mark.parametrize(("fraction", "slope"), [(0.1, 2.487), (0.2, 3.455), (0.25, 3.826), (0.3, 4.152)])
def test_a_flap_of_a_thin_section_lifts_as_thin_sections_do(fraction, slope):
    contour = ffrf.air.with_flap(naca(200, 0.01, 0.1036) + 0j, chord_fraction=fraction, angle=1j * STEP)
    assert np.imag(ffrf.air.panels(contour, angle_of_attack=0.0).cl) / STEP == pytest.approx(slope, rel=0.02)


def test_a_flap_that_is_turned_lies_about_its_hinge_and_the_front_stays():
    section = naca(200, 0.12)
    turned = ffrf.air.with_flap(section, chord_fraction=0.25, angle=0.3)
    front, rear = section[:, 0] < 0.73, section[:, 0] > 0.77
    assert np.array_equal(turned[front], section[front])
    away, before = turned[rear] - [0.75, 0], section[rear] - [0.75, 0]
    assert np.allclose((away**2).sum(axis=1), (before**2).sum(axis=1), rtol=1e-12)
    assert np.allclose(away @ [np.cos(0.3), -np.sin(0.3)], before[:, 0], rtol=1e-12)


@pytest.mark.fast
@pytest.mark.parametrize("last", [0.1015, 0.1036], ids=["blunt", "sharp"])
def test_gradients_are_complex_steps(last):
    section = naca(60, 0.12, last)
    section[:, 1] += 0.03 * (1 - section[:, 0] ** 2)
    moved = np.random.default_rng(1).normal(size=section.shape)
    moved[-1] = moved[-1] if last < 0.1036 else moved[0]
    gradients = ffrf.air.panels(section, angle_of_attack=0.1).gradients()
    judge = ffrf.air.panels(section + 1j * STEP * moved, angle_of_attack=0.1 + 0.7j * STEP)
    for name, (by_contour, by_angle) in gradients.items():
        exact = np.imag(getattr(judge, name)) / STEP
        assert (by_contour * moved).sum() + 0.7 * by_angle == pytest.approx(exact, rel=1e-10)


def test_a_section_that_is_turned_moved_and_stretched_has_the_lift_of_the_flow_turned_against_it():
    section = naca(100, 0.12)
    flow = ffrf.air.panels(section, angle_of_attack=0.1)
    other = ffrf.air.panels(3.7 * section + [40, -7], angle_of_attack=0.1)
    assert (other.cl, other.cm) == pytest.approx((flow.cl, flow.cm), rel=1e-10)
    turn = np.array([[np.cos(0.1), np.sin(0.1)], [-np.sin(0.1), np.cos(0.1)]])
    against = ffrf.air.panels(section @ turn.T, angle_of_attack=0.0)
    assert against.cl * against.chord == pytest.approx(flow.cl * flow.chord, rel=1e-10)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda nodes: nodes[:5], "at least 10"),
        (lambda nodes: nodes.T, "shape"),
        (lambda nodes: nodes[::-1], "lower side"),
        (lambda nodes: np.where(nodes == nodes[7], np.nan, nodes), "no numbers"),
        (lambda nodes: np.insert(nodes, 8, nodes[8], axis=0), "the same"),
        (lambda nodes: nodes * [1, 1] + np.where(np.arange(len(nodes)) == 20, -0.3, 0)[:, None] * [0, 1], "crosses itself"),
    ],
)
def test_what_is_no_contour_is_refused(change, said):
    with pytest.raises(InputError, match=said):
        ffrf.air.panels(change(naca(60, 0.12)), angle_of_attack=0.1)


@pytest.mark.parametrize(("fraction", "angle"), [(0.0, 0.1), (1.0, 0.1), (0.25, 2.0)])
def test_what_is_no_flap_is_refused(fraction, angle):
    with pytest.raises(InputError, match="flap"):
        ffrf.air.with_flap(naca(60, 0.12), chord_fraction=fraction, angle=angle)


@pytest.mark.parametrize("angle", [5.0, np.nan])
def test_an_angle_in_degrees_is_refused(angle):
    with pytest.raises(InputError, match="in rad"):
        ffrf.air.panels(naca(60, 0.12), angle_of_attack=angle)
