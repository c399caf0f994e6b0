"""Spatial beam elements: rigid motions, axes, mass of the section's points, exact statics, and closed-form frequencies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from preprocessing.elements.section import circle, general, rectangle, strip, tube
from tests.models.spatial_beams import NU, VALUES, Beams, crooked, energy_of_invariants, kinetic_energy, straight
from toolkit.foundation.kinematics.beam_elements import SECOND, THIRD, BeamElements, at_place
from toolkit.reduced_model.parts import PAIRS

T, B, E, RHO = (VALUES[name] for name in ("thickness", "width", "youngs_modulus", "density"))
G, J = E / (2 * (1 + NU)), rectangle().values({"thickness": T, "width": B})["torsion"]


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def close(found, expected, tolerance=1e-13):
    """Round-off relative to the largest entry."""
    np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance * np.abs(expected).max())


def test_rigid_motions_have_no_energy_and_no_stress_and_all_others_have(rng):
    beams = crooked(rng)
    stiffness = beams.dense("stiffness")
    assert np.abs(stiffness @ beams.rigid).max() < 1e-12 * np.abs(stiffness).max()  # round-off
    stress = beams.matrices.stress.toarray()[:, :-1]
    assert np.abs(stress @ beams.rigid).max() < 1e-12 * np.abs(stress).max()
    scale = 1 / np.sqrt(np.diag(stiffness))
    energies = np.linalg.eigvalsh(scale[:, None] * stiffness * scale)
    assert np.count_nonzero(energies < 1e-10) == 6  # round-off is 1e-15, the softest deformation of three elements 1e-3


def test_a_turned_element_has_the_turned_matrices(rng):
    """K' = R K R^T on all coordinates, M'_ab = sum_cd R_ac R_bd R M_cd R^T."""
    one, turn = crooked(rng), Rotation.random(random_state=5).as_matrix()
    other = replace(one, nodes=one.nodes @ turn.T, orientation=one.orientation @ turn.T)
    n = 2 * len(one.nodes)
    whole = np.eye(3 * n + 1)
    whole[:-1, :-1] = np.kron(np.eye(n), turn)
    close(whole @ one.matrices.stiffness.toarray() @ whole.T, other.matrices.stiffness.toarray())
    masses, turned = ({(a, b): each.toarray() for (a, b), each in zip(PAIRS, m.matrices.m, strict=True)} for m in (one, other))
    every = np.array([[masses[a, b] if (a, b) in masses else masses[b, a].T for b in range(3)] for a in range(3)])
    expected = np.einsum("ac,bd,pq,cdqr,sr->abps", turn, turn, whole, every, whole, optimize=True)
    for (a, b), matrix in turned.items():
        close(matrix, expected[a, b])
    assert list(masses) == list(PAIRS)


GAUSS = [(y, z) for y in (-T / 12**0.5, T / 12**0.5) for z in (-B / 12**0.5, B / 12**0.5)]
RIM = [(0.2 * np.cos(a), 0.2 * np.sin(a)) for a in (0.1, 0.1 + 2 * np.pi / 3, 0.1 + 4 * np.pi / 3)]
SECTIONS = {
    "rectangle": (rectangle(), VALUES, GAUSS),
    "strip": (strip(), VALUES, [(0.0, z) for _, z in GAUSS[:2]]),
    # int y^2 dA = pi d^4 / 64 = A r^2 / 2 on three points at r = d / 8^0.5
    "circle": (circle(), {**VALUES, "diameter": 0.2 * 8**0.5}, RIM),
    "general": (
        general(),
        {**VALUES, "area": 0.15, "I_z": 0.15 * T**2 / 12, "I_y": 0.15 * B**2 / 12, "I_p": 0.15 * (T**2 + B**2) / 12, "J": J},
        GAUSS,
    ),
}
"""Section, its values, and points with equal masses that have its second moments."""


@pytest.mark.parametrize("name", SECTIONS)
def test_invariants_give_the_energy_of_the_velocity_field(name, rng):
    shape, values, points = SECTIONS[name]
    beams = replace(crooked(rng), shape=shape, values=values)
    for _ in range(3):
        q, v = rng.normal(size=(2, 24))
        translation, omega = rng.normal(size=(2, 3))
        expected = kinetic_energy(beams, points, q, v, translation, omega)
        found = energy_of_invariants(beams.invariants, q, v, translation, omega)
        assert abs(found - expected) < 1e-12 * expected  # exact quadrature: round-off only


def test_a_rigid_motion_through_the_nodes_is_that_of_the_frame(rng):
    """Rotary inertia of bending and torsion together: the body cannot tell whether its frame or all its nodes turn."""
    beams, zero = crooked(rng), np.zeros(24)
    translation, omega = rng.normal(size=(2, 3))
    by_frame = energy_of_invariants(beams.invariants, zero, zero, translation, omega)
    by_nodes = energy_of_invariants(beams.invariants, zero, beams.rigid @ np.append(translation, omega), np.zeros(3), np.zeros(3))
    np.testing.assert_allclose(by_nodes, by_frame, rtol=1e-13)  # round-off


def test_spinning_about_its_own_axis_a_beam_has_the_polar_inertia():
    beams, zero, axis = straight(2, [1, 2, 2], [0, 0, 1]), np.zeros(18), np.array([1, 2, 2]) / 3
    energy = energy_of_invariants(beams.invariants, zero, zero, np.zeros(3), axis)
    polar = RHO * 10 * (B * T**3 + T * B**3) / 12
    np.testing.assert_allclose(2 * energy, polar, rtol=1e-10)  # against the inertia of the length, 1e3 times larger


def test_rotation_is_the_slope_of_the_centre_line_and_the_twist(rng):
    ends, r = rng.normal(size=(1, 2, 3)), 0.37 + 1e-30j
    own, u = BeamElements.in_space(ends, rng.normal(size=(1, 3))), rng.normal(size=12)
    line, turn = (at_place(each[0], r) @ u for each in (own.shape, own.rotation))
    slope = line.imag / 1e-30 / own.lengths[0]
    e_1, e_2, e_3 = own.axes[0]
    twist = 0.63 * e_1 @ u[3:6] + 0.37 * e_1 @ u[9:]
    np.testing.assert_allclose(own.axes[0] @ turn.real, [twist, -e_3 @ slope, e_2 @ slope], rtol=1e-13)  # complex step: round-off


def bent(beams: Beams, load: np.ndarray) -> np.ndarray:
    """Displacements (n_nodes, 6) of a beam clamped at its first node under a load (6,) at its last one."""
    force = np.zeros(6 * len(beams.nodes))
    force[-6:] = load
    found = np.zeros_like(force)
    found[6:] = np.linalg.solve(beams.dense("stiffness")[6:, 6:], force[6:])
    return found.reshape(-1, 6)


DIRECTION, ACROSS = np.array([2.0, -1.0, 2.0]) / 3, np.array([0.3, 0.8, -0.5])


@pytest.mark.parametrize(("axis", "inertia", "half"), [(SECOND, B * T**3 / 12, T / 2), (THIRD, T * B**3 / 12, B / 2)])
def test_tip_load_gives_exact_deflection_and_root_stress_in_both_planes(axis, inertia, half):
    """P L^3 / 3EI at the tip, P L c / I at the root: exact, because the solution is a cubic."""
    beams = straight(3, DIRECTION, ACROSS)
    way = beams.discrete.element.axes[0, axis]
    moved = bent(beams, 2.0 * np.append(way, np.zeros(3)))
    np.testing.assert_allclose(moved[-1, :3], way * 2.0 * 10**3 / (3 * E * inertia), rtol=1e-10, atol=1e-10)  # condition 1e5
    stress = (beams.matrices.stress @ np.append(moved.ravel(), 0.0))[:8:2]
    np.testing.assert_allclose(np.abs(stress), 2.0 * 10 * half / inertia, rtol=1e-9)
    corners = np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]])  # signs of y_2 and y_3 of the fibres
    assert np.array_equal(np.sign(stress), -corners[:, axis - 1])  # the side that the load bends towards is pressed


def test_axial_force_and_torque_give_their_exact_motion():
    beams = straight(3, DIRECTION, ACROSS)
    moved = bent(beams, np.append(7.0 * DIRECTION, 0.4 * DIRECTION))[-1]
    np.testing.assert_allclose(moved[:3], 7.0 * 10 / (E * T * B) * DIRECTION, rtol=1e-9)  # bending is 1e3 softer
    np.testing.assert_allclose(moved[3:], 0.4 * 10 / (G * J) * DIRECTION, rtol=1e-10)


def frequencies(n: int, turning: slice | list[int], count: int, **keys) -> np.ndarray:
    """Lowest circular frequencies of a cantilever along x whose nodes move in some coordinates only."""
    beams = straight(n, [1, 0, 0], [0, 0, 1], **keys)
    free = (6 * np.arange(1, n + 1)[:, None] + turning).ravel()
    stiffness, mass = (beams.dense(name)[np.ix_(free, free)] for name in ("stiffness", "mass"))
    return np.sqrt(eigh(stiffness, mass, eigvals_only=True)[:count])


def rayleigh_cantilever(bending: float, line: float, rotary: float, length: float, count: int) -> np.ndarray:
    """Circular frequencies of E I w'''' + rho S w^2 w'' = rho A w^2 w, clamped at 0 and free at L: shear E I w''' + rho S w^2 w' = 0."""

    def determinant(omega: float) -> float:
        half, load = rotary * omega**2 / (2 * bending), line * omega**2 / bending
        c, s = np.sqrt(half + np.sqrt(half**2 + load)), np.sqrt(-half + np.sqrt(half**2 + load))  # cos c x and cosh s x
        x, y = c * length, s * length
        p, q = c**3 - 2 * half * c, s**3 + 2 * half * s  # of w''' + 2 half w'
        # w = cosh s x - cos c x + k (c sinh s x - s sin c x): clamped; zero moment and zero shear at the end
        moment = (s**2 * np.cosh(y) + c**2 * np.cos(x), c * s**2 * np.sinh(y) + s * c**2 * np.sin(x))
        shear = (q * np.sinh(y) - p * np.sin(x), c * q * np.cosh(y) + s * p * np.cos(x))
        return (moment[0] * shear[1] - moment[1] * shear[0]) / np.cosh(y) ** 2

    slender = np.sqrt(bending / line) / length**2
    grid = np.linspace(0.2, 80, 4000) * slender
    values = np.array([determinant(omega) for omega in grid])
    change = np.flatnonzero(np.sign(values[1:]) != np.sign(values[:-1]))[:count]
    return np.array([brentq(determinant, grid[k], grid[k + 1], xtol=1e-14, rtol=1e-14) for k in change])


BENDING = {
    "about the third axis": ([1, 5], E * B * T**3 / 12, RHO * B * T**3 / 12),
    "about the second axis": ([2, 4], E * T * B**3 / 12, RHO * T * B**3 / 12),
}


@pytest.mark.parametrize("plane", BENDING)
@pytest.mark.parametrize("rotary", [True, False])
def test_bending_frequencies_converge_to_the_closed_form_with_order_four(plane, rotary):
    """Without rotary inertia, of a section whose mass has no spread, they are those of Euler and Bernoulli."""
    turning, bending, spread = BENDING[plane]
    keys = {} if rotary else {"shape": replace(rectangle(), spread_2=(), spread_3=())}
    exact = rayleigh_cantilever(bending, RHO * B * T, spread * rotary, 10.0, 3)
    sizes = np.array([4, 8, 16])
    error = np.array([frequencies(n, turning, 3, **keys) / exact - 1 for n in sizes])
    assert np.all(error > 0)  # Rayleigh-Ritz: from above
    # theory: 4 (cubic functions, second derivatives); the third mode on 4 elements is not yet quite asymptotic
    np.testing.assert_allclose(-np.polyfit(np.log(sizes), np.log(error), 1)[0], 4, atol=0.25)


def test_the_closed_form_without_rotary_inertia_is_euler_and_bernoullis():
    roots = [brentq(lambda x: np.cos(x) + 1 / np.cosh(x), (k + 0.1) * np.pi, (k + 0.9) * np.pi, xtol=1e-14) for k in range(3)]
    np.testing.assert_allclose(rayleigh_cantilever(3.0, 2.0, 0.0, 10.0, 3), (np.array(roots) / 10) ** 2 * 1.5**0.5, rtol=1e-11)


def test_torsion_frequencies_converge_to_the_closed_form_with_order_two():
    """omega_k = (2k - 1) pi / 2L sqrt(G J / rho I_p)."""
    exact = (2 * np.arange(1, 4) - 1) * np.pi / 20 * np.sqrt(G * J / (RHO * (B * T**3 + T * B**3) / 12))
    sizes = np.array([8, 16, 32])
    error = np.array([frequencies(n, [3], 3) / exact - 1 for n in sizes])
    assert np.all(error > 0)
    np.testing.assert_allclose(-np.polyfit(np.log(sizes), np.log(error), 1)[0], 2, atol=0.05)  # linear functions


@pytest.mark.parametrize("parameter", ["youngs_modulus", "density", "thickness", "width", "damping_mass", "damping_stiffness"])
def test_derivatives_of_the_matrices_are_their_complex_step(parameter, rng):
    beams = crooked(rng)
    step = 1e-30j
    stepped = replace(beams, values={**VALUES, parameter: VALUES[parameter] + step}).matrices
    ours = beams.discrete.parts.derivative(VALUES, parameter)
    for name in ("mass", "stiffness", "damping", "stress"):
        expected = getattr(stepped, name).toarray().imag / 1e-30
        close(getattr(ours, name).toarray(), expected) if np.any(expected) else None
        assert np.any(expected) or not np.any(getattr(ours, name).toarray())


def saint_venant(ratio):
    """J / (b t^3) of a rectangle with t / b = ratio; the series' terms fall with the fifth power."""
    n = np.arange(1, 400, 2)
    return 1 / 3 - 64 * ratio / np.pi**5 * np.sum(np.tanh(n * np.pi / (2 * ratio)) / n**5)


@pytest.mark.parametrize(
    ("ratio", "tolerance"), [(0.01, 1e-7), (0.1, 1e-5), (0.5, 0.0023), (0.7, 0.0023), (1.0, 1e-6), (1.2, 0.004)]
)
def test_torsion_constant_of_rectangles_is_that_of_the_series(ratio, tolerance):
    """As near as the docstring says; a square bar too, for which thin strips' 1/3 - 0.21 t / b is 12 % off."""
    found = rectangle().values({"thickness": ratio, "width": 1.0})["torsion"]
    np.testing.assert_allclose(found, saint_venant(ratio) * ratio**3, rtol=tolerance)


def test_a_square_bar_twists_alike_by_both_sides():
    """J(t, b) = J(b, t), so that both derivatives are half of that by both sides together, 4 J / b."""
    stepped = [
        rectangle().values({"thickness": 1.0 + t, "width": 1.0 + b})["torsion"].imag / 1e-30
        for t, b in ((1e-30j, 0), (0, 1e-30j))
    ]
    np.testing.assert_allclose(stepped, 2 * saint_venant(1.0), rtol=1e-6)  # digits of the factors


def test_sections_have_their_closed_forms():
    full, hollow = circle().values({"diameter": 2.0}), tube().values({"diameter": 2.0, "wall": 0.5})
    np.testing.assert_allclose([full["area"], full["bending_2"], full["torsion"]], [np.pi, np.pi / 4, np.pi / 2], rtol=1e-14)
    core = circle().values({"diameter": 1.0})
    for name, value in full.items():
        np.testing.assert_allclose(hollow[name], value - core[name], rtol=1e-13)
