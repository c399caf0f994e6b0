"""Beam elements against the textbook matrices, exact statics and the closed-form cantilever frequencies."""

from dataclasses import asdict, replace

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

from preprocessing.builders.curve_mesh import mesh_curve
from preprocessing.elements.beams import PlanarBeam
from preprocessing.elements.section import Section, distribute
from preprocessing.reduction.assembly import Matrices, Parts, assemble
from toolkit.foundation.kinematics.beam_elements import BeamElements

SECTION = Section(youngs_modulus=70000.0, density=2.7e-9, thickness=1.5, width=40.0)
ENDS = np.array([[[3.0, -1.0], [7.0, 2.0]]])  # length 5, direction (0.8, 0.6)


def parts(nodes: np.ndarray) -> Parts:
    mesh = mesh_curve(nodes)
    return assemble(PlanarBeam(mesh.nodes, mesh.connectivity, distribute(asdict(SECTION), {}, (), len(nodes) - 1).patches))


def straight(n_elements: int, length: float = 100.0, angle: float = 0.0) -> np.ndarray:
    return np.linspace(0, length, n_elements + 1)[:, None] * [np.cos(angle), np.sin(angle)]


def to_global(local: np.ndarray) -> np.ndarray:
    """Turn a textbook matrix of (u, v, rotation) at both ends into the axes of ENDS."""
    turn = np.eye(6)
    for i in (0, 3):
        turn[i : i + 2, i : i + 2] = [[0.8, 0.6], [-0.6, 0.8]]
    return turn.T @ local @ turn


def textbook_stiffness(section: Section) -> np.ndarray:
    """Bar and slender beam, Przemieniecki (1968), chapter 5, without shear."""
    length, t, b = 5.0, section.thickness, section.width
    a, c = section.youngs_modulus * b * t / length, section.youngs_modulus * b * t**3 / 12 / length**3
    s, m, n = 6 * length, 4 * length**2, 2 * length**2
    return to_global(
        np.array([
            [a, 0, 0, -a, 0, 0],
            [0, 12 * c, s * c, 0, -12 * c, s * c],
            [0, s * c, m * c, 0, -s * c, n * c],
            [-a, 0, 0, a, 0, 0],
            [0, -12 * c, -s * c, 0, 12 * c, -s * c],
            [0, s * c, n * c, 0, -s * c, m * c],
        ])
    )  # fmt: skip


def textbook_mass(section: Section) -> np.ndarray:
    """Consistent mass of bar and slender beam, Przemieniecki (1968), chapter 11, without rotary inertia."""
    length = 5.0
    s, m = length, length**2
    return to_global(
        section.density * section.width * section.thickness * length / 420
        * np.array([
            [140, 0, 0, 70, 0, 0],
            [0, 156, 22 * s, 0, 54, -13 * s],
            [0, 22 * s, 4 * m, 0, 13 * s, -3 * m],
            [70, 0, 0, 140, 0, 0],
            [0, 54, 13 * s, 0, 156, -22 * s],
            [0, -13 * s, -3 * m, 0, -22 * s, 4 * m],
        ])
    )  # fmt: skip


def textbook_stress(section: Section) -> np.ndarray:
    """E (eps +- kappa t/2), both fibres at end 0, then at end 1, with kappa from the textbook Hermite functions."""
    length = 5.0
    eps = np.array([-1, 0, 0, 1, 0, 0]) / length
    kappa = np.array([[0, -6, -4 * length, 0, 6, -2 * length], [0, 6, 2 * length, 0, -6, 4 * length]]) / length**2
    rows = np.array(
        [section.youngs_modulus * (eps + fibre * section.thickness / 2 * kappa[end]) for end in (0, 1) for fibre in (1, -1)]
    )
    turn = np.eye(6)
    for i in (0, 3):
        turn[i : i + 2, i : i + 2] = [[0.8, 0.6], [-0.6, 0.8]]
    return rows @ turn


TEXTBOOK = {"stiffness": textbook_stiffness, "mass": textbook_mass, "stress": textbook_stress}


def element(kind: str, matrices) -> np.ndarray:
    return getattr(matrices, kind).toarray()


@pytest.mark.parametrize("kind", TEXTBOOK)
def test_element_matrix_equals_the_textbook(kind):
    ours = element(kind, parts(ENDS[0]).at(asdict(SECTION)))
    book = TEXTBOOK[kind](SECTION)
    np.testing.assert_allclose(ours, book, rtol=0, atol=1e-13 * np.abs(book).max())  # round-off


@pytest.mark.parametrize("parameter", ["youngs_modulus", "density", "thickness", "width"])
@pytest.mark.parametrize("kind", TEXTBOOK)
def test_element_derivative_equals_the_complex_step_of_the_textbook(kind, parameter):
    ours = element(kind, parts(ENDS[0]).derivative(asdict(SECTION), parameter))
    value = getattr(SECTION, parameter)
    book = TEXTBOOK[kind](replace(SECTION, **{parameter: value * (1 + 1e-30j)})).imag / (value * 1e-30)
    np.testing.assert_allclose(ours, book, rtol=0, atol=1e-13 * np.abs(book).max())  # round-off; exact zeros stay zero


def test_mixed_component_mass_equals_its_closed_form():
    """For an element along x: int N_i H_j dx with the linear N and the Hermite H."""
    length = 4.0
    mixed = BeamElements.in_plane(np.array([[[0.0, 0.0], [length, 0.0]]])).component_mass[0, 0, 1]
    expected = np.zeros((6, 6))
    expected[np.ix_([0, 3], [1, 2, 4, 5])] = length * np.array([
        [7 / 20, length / 20, 3 / 20, -length / 30],
        [3 / 20, length / 30, 7 / 20, -length / 20],
    ])  # fmt: skip
    np.testing.assert_allclose(mixed, expected, rtol=0, atol=1e-14)  # round-off of numbers of order 1


@pytest.mark.parametrize("ratio", [0.0, 0.3, 1.0])
def test_shape_functions_reproduce_positions_and_rigid_rotation(ratio):
    """S xi = x and S rho = (-x_2, x_1) at every place, with xi and rho of the two nodes."""
    (one, two), powers = ENDS[0], ratio ** np.arange(4)
    shape = np.tensordot(powers, BeamElements.in_plane(ENDS).shape[0], axes=1)
    turn = np.tensordot(powers, BeamElements.in_plane(ENDS).rotation[0], axes=1)
    x = one + ratio * (two - one)
    xi, rigid = np.array([*one, 0, *two, 0]), np.array([-one[1], one[0], 1, -two[1], two[0], 1])
    np.testing.assert_allclose(shape @ xi, x, atol=1e-14)  # round-off of numbers of order 1
    np.testing.assert_allclose(shape @ rigid, [-x[1], x[0]], atol=1e-14)
    np.testing.assert_allclose([turn @ xi, turn @ rigid], [0, 1], atol=1e-14)


def test_rotation_is_the_slope_of_the_transverse_displacement():
    ratio, powers = 0.37 + 1e-30j, np.arange(4)
    normal = np.array([-0.6, 0.8])
    slope = (normal @ np.tensordot(ratio**powers, BeamElements.in_plane(ENDS).shape[0], axes=1)).imag / 1e-30 / 5.0
    rotation = np.tensordot(ratio.real**powers, BeamElements.in_plane(ENDS).rotation[0], axes=1)
    np.testing.assert_allclose(rotation, slope, atol=1e-14)  # complex step: round-off only


def clamped(nodes: np.ndarray) -> Matrices:
    return parts(nodes).at(asdict(SECTION))


@pytest.mark.parametrize("angle", [0.0, 2.1])
def test_tip_load_gives_exact_deflection_and_tension_in_the_outer_fibre_on_the_right(angle):
    """P L^3 / 3EI at the tip, 6 P L / b t^2 at the root: exact, because the solution is a cubic."""
    length, force, n = 100.0, 3.0, 5
    matrices = clamped(straight(n, length, angle))
    load = np.zeros(3 * n + 3)
    load[-3:-1] = force * np.array([-np.sin(angle), np.cos(angle)])  # to the left of the direction of travel
    u = np.zeros_like(load)
    u[3:] = np.linalg.solve(matrices.stiffness.toarray()[3:, 3:], load[3:])
    t, b = SECTION.thickness, SECTION.width
    deflection = force * length**3 / (3 * SECTION.youngs_modulus * b * t**3 / 12)
    stress = matrices.stress @ u
    root = 6 * force * length / (b * t**2)
    np.testing.assert_allclose(np.linalg.norm(u[-3:-1]), deflection, rtol=1e-10)  # condition number 1e5 times round-off
    np.testing.assert_allclose(stress[:2], [root, -root], rtol=1e-10)
    np.testing.assert_allclose(stress[-2:], 0, atol=1e-10 * root)


def test_axial_load_gives_force_over_area_in_both_fibres():
    matrices = clamped(straight(3, angle=0.4))
    load = np.zeros(12)
    load[-3:-1] = 7.0 * np.array([np.cos(0.4), np.sin(0.4)])
    u = np.zeros(12)
    u[3:] = np.linalg.solve(matrices.stiffness.toarray()[3:, 3:], load[3:])
    area = SECTION.thickness * SECTION.width
    np.testing.assert_allclose(matrices.stress @ u, 7.0 / area, rtol=1e-9)  # bending is 1e3 softer than stretching


def lowest_bending_frequencies(n_elements: int, count: int) -> np.ndarray:
    nodes = straight(n_elements)
    matrices = clamped(nodes)
    across = np.setdiff1d(np.arange(3, 3 * len(nodes)), np.arange(0, 3 * len(nodes), 3))  # v and rotation only
    stiffness, mass = (m.toarray()[np.ix_(across, across)] for m in (matrices.stiffness, matrices.mass))
    return np.sqrt(eigh(stiffness, mass, eigvals_only=True)[:count])


def test_cantilever_frequencies_converge_with_order_four():
    """omega_k = (lambda_k / L)^2 sqrt(E I / rho A), cos lambda cosh lambda = -1."""
    roots = [brentq(lambda x: np.cos(x) + 1 / np.cosh(x), (k + 0.1) * np.pi, (k + 0.9) * np.pi, xtol=1e-14) for k in range(3)]
    radius = SECTION.thickness / np.sqrt(12)
    exact = (np.array(roots) / 100.0) ** 2 * radius * np.sqrt(SECTION.youngs_modulus / SECTION.density)
    sizes = np.array([4, 8, 16])
    error = np.array([lowest_bending_frequencies(n, 3) / exact - 1 for n in sizes])
    assert np.all(error > 0)  # Rayleigh-Ritz: from above
    orders = -np.polyfit(np.log(sizes), np.log(error), 1)[0]
    # theory: 4 (cubic functions, second derivatives); the third mode on 4 elements is not yet quite asymptotic
    np.testing.assert_allclose(orders, 4, atol=0.25)
