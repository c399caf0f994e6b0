"""Normal modes against closed forms of beams and rings, rigid motions, orthogonality and the choice of their number."""

import numpy as np
import pytest
from scipy.optimize import brentq

from preprocessing.reduction.constrained_pencil import ConstrainedPencil, rigid_modes
from preprocessing.reduction.normal_modes import cluster, count_by_frequency, count_by_static_error, normal_modes, static_errors
from tests.models.frames import SECTION, cantilever, relative, ring, square, varied, wing
from toolkit.foundation.errors import InputError
from toolkit.foundation.near_ties import EQUAL_EIGENVALUES, told_apart

FREE = {"ring": ring(24, 100.0), "square": square(6), "beam": cantilever(12, angle=0.4), "skin": wing()}


def clamp(frame) -> np.ndarray:
    return np.eye(3 * len(frame.nodes))[:3]


def beam_frequencies(sign: float, length: float, count: int) -> np.ndarray:
    """Hz; cos x cosh x = sign: -1 clamped at one end, +1 free."""
    start = 0 if sign < 0 else 1
    roots = [
        brentq(lambda x: np.cos(x) - sign / np.cosh(x), (k + 0.1) * np.pi, (k + 0.9) * np.pi, xtol=1e-14)
        for k in range(start, start + count)
    ]
    return (np.array(roots) / length) ** 2 * beam_speed() / (2 * np.pi)


def beam_speed() -> float:
    """sqrt(E I / rho A)."""
    return SECTION.thickness / np.sqrt(12) * np.sqrt(SECTION.youngs_modulus / SECTION.density)


@pytest.mark.parametrize("angle", [0.0, 2.1])
def test_cantilever_has_its_closed_form_frequencies(angle):
    frame = cantilever(24, angle=angle)
    found = normal_modes(frame.pencil(clamp(frame)), 3).frequencies
    np.testing.assert_allclose(found, beam_frequencies(-1, 100.0, 3), rtol=1e-5)  # mesh error (x / 24)^4 / 1440, x = 7.9: 8e-6


def test_free_beam_has_its_closed_form_frequencies_without_rigid_motions():
    found = normal_modes(cantilever(24, angle=0.3).pencil(), 3).frequencies
    np.testing.assert_allclose(found, beam_frequencies(1, 100.0, 3), rtol=4e-5)  # mesh error as above, x = 11: 3e-5


def test_ring_converges_to_its_closed_form_frequencies_in_equal_pairs():
    """Inextensional ring: omega_n^2 = E I n^2 (n^2 - 1)^2 / (rho A R^4 (n^2 + 1)), n = 2, 3, 4; the polygon converges with order two."""
    radius, n = 100 * SECTION.thickness, np.repeat([2, 3, 4], 2)
    exact = n * (n**2 - 1) / np.sqrt(n**2 + 1) * beam_speed() / radius**2 / (2 * np.pi)
    error = []
    for n_elements in (24, 48, 96):
        modes = normal_modes(ring(n_elements, radius).pencil(), 6)
        assert [cluster(modes.spectrum, mode) for mode in (0, 2, 4)] == [(0, 2), (2, 4), (4, 6)]
        error.append(modes.frequencies / exact - 1)
    order = np.log2((error[0] - error[1]) / (error[1] - error[2]))
    np.testing.assert_allclose(order, 2, atol=0.1)  # asymptotic from 6 elements per wave on
    limit = error[2] + (error[2] - error[1]) / 3
    # the closed form neglects (n t / R)^2 / 12 = 1e-4 of stretching, and the extrapolation (pi / 24)^4 n = 1e-3 / 16
    assert np.abs(limit).max() < 3e-4


@pytest.mark.parametrize("name", FREE)
def test_rigid_motions_are_the_three_of_the_plane_and_store_no_energy(name):
    frame = FREE[name]
    stiffness, mass = frame.matrices()
    rigid = rigid_modes(frame.pencil())
    x, y = frame.nodes.T
    one, zero = np.ones_like(x), np.zeros_like(x)
    expected = np.column_stack([
        np.column_stack(motion).ravel() for motion in ((one, zero, zero), (zero, one, zero), (-y, x, one))
    ])  # fmt: skip
    combination = np.linalg.lstsq(rigid, expected, rcond=None)[0]
    assert relative(rigid @ combination, expected) < 1e-8  # round-off times the condition of the stiffness, 1e7
    np.testing.assert_allclose(rigid.T @ mass @ rigid, np.eye(3), atol=1e-12)  # round-off
    assert np.abs(stiffness @ rigid).max() < 1e-13 * (np.abs(stiffness) @ np.abs(rigid)).max()


@pytest.mark.parametrize("elements", [10, 300])
def test_a_held_body_has_no_rigid_motion_however_fine_its_mesh(elements):
    frame = cantilever(elements, angle=0.7)
    assert rigid_modes(frame.pencil(clamp(frame))).shape[1] == 0
    assert rigid_modes(frame.pencil(clamp(frame)[:2])).shape[1] == 1  # a hinge


@pytest.mark.parametrize("name", FREE)
@pytest.mark.parametrize("held", [True, False])
def test_all_modes_of_the_mesh_are_orthonormal_and_solve_the_eigenvalue_problem(name, held):
    frame = FREE[name]
    pencil = frame.pencil(clamp(frame) if held else None)
    modes = normal_modes(pencil)
    assert modes.count == len(pencil.mass) - 3
    assert np.all(np.diff(modes.eigenvalues) > -EQUAL_EIGENVALUES * modes.eigenvalues[1:])
    np.testing.assert_allclose(modes.shapes.T @ pencil.mass @ modes.shapes, np.eye(modes.count), atol=1e-12)  # round-off
    energy = modes.shapes.T @ pencil.stiffness @ modes.shapes
    root = np.sqrt(modes.eigenvalues)
    # round-off, multiplied by sqrt(lambda_n / lambda_1), 1e4, for products of the highest with the lowest mode
    assert np.abs(energy / np.outer(root, root) - np.eye(modes.count)).max() < 1e-6
    assert np.abs(pencil.rows @ modes.shapes).max(initial=0) < 1e-12 * np.abs(modes.shapes).max()


@pytest.mark.parametrize("parameter", ["youngs_modulus", "width"])
def test_signs_do_not_depend_on_units(parameter):
    """Factors on stiffness and mass leave the shapes as they are but for their norm."""
    one, other = (normal_modes(f.pencil(clamp(f)), 12).columns for f in (wing(), varied(wing(), parameter, np.pi)))
    assert relative(other / np.linalg.norm(other, axis=0), one / np.linalg.norm(one, axis=0)) < 1e-7  # condition times round-off


def test_modes_of_equal_frequency_are_those_of_every_turn_of_them():
    """The ring's come in pairs, which round-off turns as it likes; so does this test, and what is stored stays the same."""
    rng, frame = np.random.default_rng(5), ring(24, 100.0)
    modes = normal_modes(frame.pencil(), 8)
    turned = modes.shapes.copy()
    for first in (0, 2, 4, 6):
        turn = np.linalg.qr(rng.normal(size=(2, 2)))[0]
        turned[:, first : first + 2] = turned[:, first : first + 2] @ turn
    again = told_apart(modes.eigenvalues, turned, np.sqrt(np.diag(modes.pencil.mass)))
    assert relative(again, modes.columns) < 1e-12  # round-off of two turns
    assert relative(modes.columns.T @ modes.pencil.mass @ modes.columns, np.eye(8)) < 1e-12
    assert relative(turned, modes.columns) > 0.1


def test_more_modes_than_the_mesh_has_are_refused():
    with pytest.raises(InputError, match=r"the mesh has 9\. Choose from 0 to 9"):
        normal_modes(cantilever(3).pencil(), 10)


def test_dependent_rows_are_refused():
    frame = cantilever(3)
    with pytest.raises(InputError, match="independent constraint rows"):
        normal_modes(frame.pencil(np.vstack([clamp(frame), clamp(frame)[:1]])))


@pytest.fixture(scope="module")
def every():
    """All modes of the clamped skin."""
    return normal_modes(wing().pencil(clamp(wing())))


@pytest.fixture(scope="module")
def rows():
    """Rows of the three interface points of the skin."""
    return np.vstack(list(wing().interface_rows().values()))


def test_count_by_frequency_takes_all_modes_up_to_it(every):
    found = every.frequencies
    assert count_by_frequency(every, (found[6] + found[7]) / 2) == 7
    assert count_by_frequency(every, found[0] / 2, least=0) == 0


@pytest.mark.parametrize(("highest", "match"), [(1.0, "the lowest has 32"), (1e9, "the mesh ends at")])
def test_frequencies_without_modes_are_refused_with_what_is_reachable(every, highest, match):
    with pytest.raises(InputError, match=match):
        count_by_frequency(every, highest)


@pytest.mark.processors
def test_a_count_by_frequency_or_static_error_takes_a_pair_of_the_ring_whole():
    frame = ring(24, 100.0, points={"P": 2.3, "Q": 11.0})
    modes = normal_modes(frame.pencil())
    low, high = modes.frequencies[:2]  # equal but for round-off, on some processors to the last digit
    for wanted in (low * (1 - 1e-12), (low + high) / 2, high * (1 + 1e-12)):
        assert count_by_frequency(modes, wanted) == 2
    errors = static_errors(modes, np.vstack(list(frame.interface_rows().values())))
    for k in (1, 3, 5):
        assert count_by_static_error(modes, np.vstack(list(frame.interface_rows().values())), errors[k]) == k + 1


def test_static_errors_are_those_of_the_compliance(every, rows):
    """Reference: C of the whole mesh and of the reduced one, by solving; rows divided by the root of their own compliance."""
    stiffness = every.pencil.stiffness[3:, 3:]
    whole = rows[:, 3:] @ np.linalg.solve(stiffness, rows[:, 3:].T)
    scale = 1 / np.sqrt(np.diag(whole))
    errors = static_errors(every, rows)
    for k in (3, 10, 40):
        psi = every.shapes[3:, :k]
        reduced = rows[:, 3:] @ psi @ np.linalg.solve(psi.T @ stiffness @ psi, psi.T @ rows[:, 3:].T)
        expected = np.linalg.norm(scale[:, None] * (whole - reduced) * scale, 2) / np.linalg.norm(
            scale[:, None] * whole * scale, 2
        )
        np.testing.assert_allclose(errors[k], expected, rtol=0, atol=1e-7)  # round-off times the condition of the stiffness
    assert np.all(np.diff(errors) <= 0)


@pytest.mark.parametrize("wanted", [0.3, 0.05, 0.01])
def test_count_by_static_error_is_the_smallest_that_reaches_it(every, rows, wanted):
    errors, count = static_errors(every, rows), count_by_static_error(every, rows, wanted)
    assert errors[count] <= wanted < errors[count - 1]


@pytest.mark.parametrize("wanted", [0.0, 1.0, -0.1, float("nan")])
def test_a_static_error_that_cannot_be_meant_is_refused(every, rows, wanted):
    with pytest.raises(InputError, match=r"without modes it is 1, with all it is 0"):
        count_by_static_error(every, rows, wanted)


def test_a_static_error_without_a_point_that_moves_is_refused(every):
    with pytest.raises(InputError, match="name one away from the clamped node"):
        count_by_static_error(every, clamp(wing()), 0.1)


@pytest.mark.parametrize("entry", [-1.0, -1e-300])
def test_a_stiffness_that_sets_energy_free_is_refused(entry):
    pencil = ConstrainedPencil(np.diag([entry, 1.0, 2.0]), np.eye(3), np.zeros((0, 3)))
    with pytest.raises(InputError, match="1 negative entries on its diagonal"):
        normal_modes(pencil)
