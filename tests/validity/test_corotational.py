"""Corotational beam elements against rigid motions, complex steps and the closed forms of large bending."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

from preprocessing.builders.curve_mesh import CurveMesh
from tests.models.frames import cantilever, matrices, ring
from tests.models.rectangular_beams import corotational, points_of
from toolkit.foundation.errors import InputError
from toolkit.validity.bodies.chain import mean_rows
from toolkit.validity.bodies.corotational_beams import Corotational, solve_corotational

LENGTH, MODULUS, THICKNESS, WIDTH = 100.0, 70000.0, 0.1, 10.0
EI = MODULUS * WIDTH * THICKNESS**3 / 12


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(5)


def beam(frame, thickness: float = THICKNESS) -> Corotational:
    return corotational(frame.nodes, frame.connectivity, MODULUS, thickness, WIDTH)


def clamp(n: int) -> np.ndarray:
    return np.eye(3, n)


def tip_load(n: int, k: int, value: float) -> np.ndarray:
    loads = np.zeros(n)
    loads[n - 3 + k] = value
    return loads


def random_state(frame, rng, amplitude: float) -> np.ndarray:
    return amplitude * rng.normal(size=3 * len(frame.nodes)) * np.tile([5.0, 5.0, 1.0], len(frame.nodes))


@pytest.mark.parametrize("angle", [0.3, -2.0, np.pi, 7.0, 100.0])
def test_rigid_motions_of_any_size_leave_no_force_and_no_stress(angle):
    frame = ring(12, 50.0)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    moved = np.column_stack([frame.nodes @ turn.T + [300.0, -20.0] - frame.nodes, np.full(12, angle)])
    body = beam(frame)
    # round-off of coordinates of 350 and angles of 100, times E A / L and E
    scale = body.law[0, 0, 0]
    np.testing.assert_allclose(body.force(moved.ravel()), 0, atol=1e-12 * scale)
    np.testing.assert_allclose(body.stress(moved.ravel(), points_of(12)), 0, atol=1e-13 * MODULUS)


def test_forces_turn_with_a_rigid_rotation_of_the_deformed_body(rng):
    frame, angle = cantilever(4, LENGTH, 0.4), 2.2
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    body, u = beam(frame), random_state(cantilever(4), rng, 0.3).reshape(-1, 3)
    moved = np.column_stack([(frame.nodes + u[:, :2]) @ turn.T - frame.nodes, u[:, 2] + angle])
    before, after = (body.force(state.ravel()).reshape(-1, 3) for state in (u, moved))
    expected = np.column_stack([before[:, :2] @ turn.T, before[:, 2]])
    np.testing.assert_allclose(after, expected, atol=1e-12 * np.abs(before).max())  # round-off


@pytest.mark.parametrize("amplitude", [1e-3, 0.2, 1.0])
def test_tangent_is_the_complex_step_of_the_force_and_symmetric(rng, amplitude):
    body, u = beam(ring(7, 50.0)), random_state(ring(7, 50.0), rng, amplitude)
    tangent = body.tangent(u).toarray()
    steps = np.array([body.force(u + 1e-30j * row).imag / 1e-30 for row in np.eye(len(u))]).T
    np.testing.assert_allclose(tangent, steps, atol=1e-12 * np.abs(tangent).max())  # round-off
    np.testing.assert_allclose(tangent, tangent.T, atol=1e-12 * np.abs(tangent).max())


def test_tangent_and_stress_at_rest_are_those_of_the_linear_elements(rng):
    frame = ring(9, 50.0)
    body, rest = beam(frame, 1.5), np.zeros(27)
    u = random_state(frame, rng, 1e-3)
    linear = matrices(
        CurveMesh(frame.nodes, frame.connectivity),
        type(frame.section)(youngs_modulus=MODULUS, density=1.0, thickness=1.5, width=WIDTH),
    )
    expected = linear.stiffness.toarray()
    np.testing.assert_allclose(body.tangent(rest).toarray(), expected, atol=1e-12 * np.abs(expected).max())  # round-off
    np.testing.assert_allclose(
        body.linear_stress(u, points_of(9)), linear.stress @ u, atol=1e-12 * np.abs(linear.stress @ u).max()
    )


def test_small_states_differ_from_linear_ones_by_second_order(rng):
    body, u = beam(ring(9, 50.0)), random_state(ring(9, 50.0), rng, 1.0)
    linear, sizes = body.tangent(np.zeros(27)) @ u, np.array([1e-4, 5e-5, 2.5e-5])
    rest = [np.abs(body.force(h * u) - h * linear).max() for h in sizes]
    order = np.polyfit(np.log(sizes), np.log(rest), 1)[0]
    assert order == pytest.approx(2, abs=0.01)  # terms of third order are 1e-4 of those of second


@pytest.mark.parametrize("angle", [0.5, np.pi, 2 * np.pi])
def test_end_moment_rolls_a_cantilever_into_an_arc_of_a_circle(angle):
    """M = E I angle / L. Every chord of n is 2 sin(angle / 2 n) / (angle / n) of its length on the circle, the elements keep theirs."""
    n = 20
    body = beam(cantilever(n, LENGTH))
    u = solve_corotational(body, tip_load(3 * n + 3, 2, EI * angle / LENGTH), clamp(3 * n + 3))
    tip = np.array([LENGTH, 0, 0]) + u[-3:]
    radius = LENGTH / n / (2 * np.sin(angle / n / 2))
    expected = [radius * np.sin(angle), radius * (1 - np.cos(angle)), angle]
    np.testing.assert_allclose(tip, expected, atol=1e-7 * LENGTH)  # Newton's tolerance times the condition of the slender beam


def elastica(load: float) -> tuple[float, float]:
    """Deflection and shortening, over L, of a cantilever under load = P L^2 / E I: Bisshopp and Drucker (1945), inextensible."""

    def modulus(tip: float) -> tuple[float, float]:
        m = (1 + np.sin(tip)) / 2
        return m, np.arcsin(1 / np.sqrt(2 * m))

    def excess(tip: float) -> float:
        m, start = modulus(tip)
        return ellipk(m) - ellipkinc(start, m) - np.sqrt(load)

    tip = brentq(excess, 1e-9, np.pi / 2 - 1e-9, xtol=1e-14)
    m, start = modulus(tip)
    return 1 - 2 / np.sqrt(load) * (ellipe(m) - ellipeinc(start, m)), 1 - np.sqrt(2 * np.sin(tip) / load)


def test_the_elastica_has_its_published_numbers():
    """Mattiasson (1981): load 1 and 10."""
    np.testing.assert_allclose(
        [elastica(1.0), elastica(10.0)], [[0.30172, 0.05643], [0.81061, 0.55500]], atol=5e-6
    )  # digits printed


@pytest.mark.parametrize("load", [1.0, 10.0])
def test_tip_load_bends_a_cantilever_into_the_elastica_with_second_order(load):
    sizes, errors = np.array([10, 20, 40]), []
    for n in sizes:
        u = solve_corotational(beam(cantilever(n, LENGTH)), tip_load(3 * n + 3, 1, load * EI / LENGTH**2), clamp(3 * n + 3))
        errors.append(np.linalg.norm(np.array([u[-2], -u[-3]]) / LENGTH - elastica(load)))
    assert errors[-1] < 1e-3  # an element turns by 1.4 / 40 at load 10
    assert -np.polyfit(np.log(sizes), np.log(errors), 1)[0] == pytest.approx(2, abs=0.2)  # straight chords of a curved line


def test_a_pushed_column_is_refused_at_its_buckling_load():
    """Euler's load of a clamped column, pi^2 E I / (4 L^2); the straight column beyond it is an equilibrium, but no stable one."""
    n, euler = 10, np.pi**2 * EI / (4 * LENGTH**2)
    for part in (0.5, 0.98):
        u = solve_corotational(beam(cantilever(n, LENGTH)), tip_load(33, 0, -part * euler), clamp(33))
        assert u[-2] == 0
    with pytest.raises(InputError, match=r"no equilibrium beyond 50\.. % of its forces: it buckles") as refused:
        solve_corotational(beam(cantilever(n, LENGTH)), tip_load(33, 0, -2 * euler), clamp(33))
    assert "smaller loads" in str(refused.value)


def test_a_free_body_is_held_by_its_mean_motion_and_bends_as_its_halves_do():
    """A beam on mean axes between two opposite end moments M = E I angle / L: an arc of a circle, symmetric about its middle."""
    n, angle = 20, 1.0
    frame = cantilever(n, LENGTH)
    held = mean_rows(frame.nodes, frame.connectivity)
    loads = tip_load(3 * n + 3, 2, EI * angle / LENGTH)
    loads[2] = -loads[-1]
    u = solve_corotational(beam(frame), loads, held).reshape(-1, 3)
    assert u[-1, 2] - u[0, 2] == pytest.approx(angle, rel=1e-6)  # Newton's tolerance
    np.testing.assert_allclose(held @ u.ravel(), 0, atol=1e-9 * LENGTH**2)
    np.testing.assert_allclose(u[:, 1], u[::-1, 1], atol=1e-6 * LENGTH)
