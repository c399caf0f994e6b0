"""Derivatives of single eigenpairs against closed forms of beam and ring, scaling laws, and fresh solutions with broken symmetry."""

from dataclasses import replace

import numpy as np
import pytest

from preprocessing.reduction.constrained_pencil import ConstrainedPencil
from preprocessing.reduction.normal_modes import adapted_modes, eigenvalue_rates, eigenvector_rates, normal_modes
from tests.models.frames import cantilever, pencil_rate, relative, richardson, ring, square, varied, wing
from toolkit.foundation.errors import InputError

SYMMETRIC = {"ring": (ring(24, 100.0), 4), "square": (square(6), 6)}
BREAKING = ("element", "sector", "shape")
"""Variables that split equal eigenvalues."""


def clamp(frame) -> np.ndarray:
    return np.eye(3 * len(frame.nodes))[:3]


@pytest.mark.parametrize("name", SYMMETRIC)
def test_equal_eigenvalues_stay_equal_and_scale_with_modulus_and_density(name):
    """lambda is proportional to E / rho, and does not depend on the width."""
    frame, count = SYMMETRIC[name]
    modes = normal_modes(frame.pencil(), count)
    laws = {"youngs_modulus": 1.0, "density": -1.0, "width": 0.0}  # pencil_rate: by the fraction of the value
    for variable, power in laws.items():
        found = eigenvalue_rates(modes, pencil_rate(frame, variable)) / modes.eigenvalues
        np.testing.assert_allclose(found, power, atol=1e-9)  # round-off times the condition of the stiffness, 1e6


def test_mass_that_varies_round_the_ring_splits_its_pairs_as_in_the_closed_form():
    """For density 1 + x cos(2 n angle), u_r = cos(n angle), u_t = -sin(n angle) / n: dlambda / lambda = -+ (n^2 - 1) / 2 (n^2 + 1)."""
    n_elements, n = 96, 2
    frame = ring(n_elements, 100.0)
    modes = normal_modes(frame.pencil(), 2)
    middle = 2 * np.pi * (np.arange(n_elements) + 0.5) / n_elements
    changed = type(frame)(
        frame.nodes, frame.connectivity, factors=1 + 1e-30j * np.round(np.cos(2 * n * middle), 9), varied="density"
    ).pencil()
    d = ConstrainedPencil(changed.stiffness.imag / 1e-30, changed.mass.imag / 1e-30, changed.rows)
    found = eigenvalue_rates(modes, d) / modes.eigenvalues
    split = (n**2 - 1) / (2 * (n**2 + 1))
    np.testing.assert_allclose(found, [-split, split], rtol=5e-3)  # steps of 1/24 wave and a polygon: (pi / 24)^2 / 6 = 3e-3


@pytest.mark.parametrize("variable", BREAKING)
@pytest.mark.parametrize("name", SYMMETRIC)
def test_derivatives_of_repeated_eigenvalues_are_those_of_fresh_solutions_after_symmetry_is_broken(name, variable):
    """A branch that rises fastest is the highest of its cluster for steps ahead, and the lowest for steps back."""
    frame, count = SYMMETRIC[name]
    modes = normal_modes(frame.pencil(), count)
    found = eigenvalue_rates(modes, pencil_rate(frame, variable)) / modes.eigenvalues

    def fresh(step):
        eigenvalues = normal_modes(varied(frame, variable, step).pencil(), count).eigenvalues / modes.eigenvalues
        if step > 0:
            return eigenvalues
        borders = np.flatnonzero(np.diff(modes.eigenvalues) > 1e-6 * modes.eigenvalues[1:]) + 1
        return np.concatenate([part[::-1] for part in np.split(eigenvalues, borders)])

    # round-off of fresh eigenvalues, 1e-10, over the smallest step, 1e-3
    np.testing.assert_allclose(found, richardson(fresh, 4e-3), atol=1e-6 * np.abs(found).max())


@pytest.mark.parametrize("name", SYMMETRIC)
def test_adapted_modes_are_the_limits_of_fresh_modes(name):
    """Fresh single modes at steps h and -h are turned against each other by O(h): their mean projector is O(h^2) off the adapted one."""
    frame, count = SYMMETRIC[name]
    adapted = adapted_modes(normal_modes(frame.pencil(), count), pencil_rate(frame, "shape"))
    error = []
    for step in (2e-3, 1e-3):
        fresh = normal_modes(varied(frame, "shape", step).pencil(), count)
        alignment = np.abs(np.einsum("ij,ij->j", fresh.shapes, adapted.pencil.mass @ adapted.shapes))
        error.append(np.abs(1 - alignment).max())
    assert error[1] < 0.6 * error[0]  # at least first order
    assert error[1] < 5e-3  # some times the step


def test_modes_of_a_beam_follow_their_scaling_by_thickness():
    """Bending modes of a cantilever keep their shape, with phi ~ (rho b t L)^-1/2 and lambda ~ t^2."""
    frame = cantilever(10, angle=0.3)
    modes, d = normal_modes(frame.pencil(clamp(frame)), 3), pencil_rate(frame, "thickness")
    d = ConstrainedPencil(d.stiffness, d.mass, np.zeros((3, 33)))
    np.testing.assert_allclose(eigenvalue_rates(modes, d) / modes.eigenvalues, 2, rtol=1e-8)  # condition 1e6 times round-off
    assert relative(eigenvector_rates(modes, d), -modes.shapes / 2) < 1e-8


@pytest.mark.parametrize("variable", ["thickness", "element", "shape"])
def test_single_modes_of_the_skin_change_as_fresh_modes_do(variable):
    frame, rows = wing(), clamp(wing())
    modes, d = normal_modes(frame.pencil(rows), 6), pencil_rate(frame, variable)
    d = ConstrainedPencil(d.stiffness, d.mass, np.zeros_like(rows))

    def fresh(step):
        found = normal_modes(varied(frame, variable, step).pencil(rows), 6)
        sign = np.sign(np.einsum("ij,ij->j", found.shapes, modes.pencil.mass @ modes.shapes))
        return np.vstack([found.eigenvalues / modes.eigenvalues, found.shapes * sign / np.abs(modes.shapes).max()])

    ours = np.vstack([eigenvalue_rates(modes, d) / modes.eigenvalues, eigenvector_rates(modes, d) / np.abs(modes.shapes).max()])
    # round-off of fresh solutions, 1e-10 to 1e-9, over the smallest step, 8e-3
    assert np.abs(ours - richardson(fresh, 0.064, 4)).max() < 1e-7 * max(1.0, np.abs(ours).max())


@pytest.mark.parametrize("variable", ["place", "shape"])
def test_modes_under_constraints_that_move_change_as_fresh_modes_do(variable):
    """The skin is held at F and at a point inside an element, whose rows change with its place and with the shape."""
    frame = replace(wing(), points={"P": 7.37})

    def rows(changed):
        return np.vstack([clamp(frame), changed.interface_rows()["P"]])

    def fresh(step):
        changed = varied(frame, variable, step)
        found = normal_modes(changed.pencil(rows(changed)), 4)
        sign = np.sign(np.einsum("ij,ij->j", found.shapes, modes.pencil.mass @ modes.shapes))
        return np.vstack([found.eigenvalues / modes.eigenvalues, found.shapes * sign / np.abs(modes.shapes).max()])

    modes, d = normal_modes(frame.pencil(rows(frame)), 4), pencil_rate(frame, variable)
    d = ConstrainedPencil(d.stiffness, d.mass, rows(varied(frame, variable, 1e-30j)).imag / 1e-30)
    ours = np.vstack([eigenvalue_rates(modes, d) / modes.eigenvalues, eigenvector_rates(modes, d) / np.abs(modes.shapes).max()])
    # round-off of fresh solutions, 1e-10 to 1e-9, over the smallest step, 8e-3
    assert np.abs(ours - richardson(fresh, 0.064, 4)).max() < 1e-7 * max(1.0, np.abs(ours).max())


def test_vectors_of_a_repeated_eigenvalue_are_refused_by_name():
    frame = ring(24, 100.0)
    with pytest.raises(InputError, match=r"the modes 1, 2 have one eigenvalue \(.* Hz\).*eigenvalue_rates, adapted_modes"):
        eigenvector_rates(normal_modes(frame.pencil(), 4), pencil_rate(frame, "element"))


def test_eigenvalues_of_a_cut_pair_are_refused():
    frame = ring(24, 100.0)
    with pytest.raises(InputError, match=r"mode 1 .* is kept and mode 2 .* is left out"):
        eigenvalue_rates(normal_modes(frame.pencil(), 1), pencil_rate(frame, "element"))
