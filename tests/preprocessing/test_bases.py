"""Reduction bases of the wing's skin: static exactness, reference conditions, and derivatives against fresh reductions."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.linalg import eigh

from preprocessing.builders.curve_mesh import CurveMesh
from preprocessing.reduction.basis import BasisChoice, DesignRates, ReductionBasis
from preprocessing.reduction.chosen_basis import MEAN_AXES, reduced_basis, tangent_frame, undeformed
from preprocessing.reduction.invariants import contract
from tests.models.frames import Frame, cantilever, matrices, relative, richardson, ring, varied, wing
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.check import SMALLEST_MASS_EIGENVALUE
from toolkit.reduced_model.model import generalized_mass

INSIDE = replace(wing(), points={"C": 9.62, "E": 25.0, "G": 30.0})
"""The skin with one interface point inside an element."""

CHOICES = {
    "full": BasisChoice("full"),
    "clamped": BasisChoice("eigenmodes", count=8),
    "free": BasisChoice("eigenmodes", boundary="free", count=8),
    "craig-bampton": BasisChoice("craig-bampton", count=5),
    "static": BasisChoice("static"),
}
VARIABLES = ("thickness", "youngs_modulus", "density", "width", "element", "shape", "place")
STEP = 1e-30


def reduce(frame: Frame, choice: BasisChoice) -> ReductionBasis:
    stiffness, mass = frame.matrices()
    return reduced_basis(choice, mass, stiffness, frame.nodes, 0, "F", frame.interface_rows())


def design_rates(frame: Frame, variable: str) -> DesignRates:
    """All derivatives by one variable, by complex steps of the assembly and of the interpolation."""
    changed = varied(frame, variable, STEP * 1j)
    stiffness, mass = changed.matrices()
    rows = {name: np.imag(row) / STEP for name, row in changed.interface_rows().items()}
    return DesignRates(stiffness.imag / STEP, mass.imag / STEP, undeformed(changed.nodes).imag / STEP, rows)


@dataclass(frozen=True)
class Reduced:
    """Reduced matrices and the rows of the interface points on the elastic coordinates, or their derivatives."""

    stiffness: np.ndarray
    mass: np.ndarray
    rows: np.ndarray

    @classmethod
    def fresh(cls, frame: Frame, choice: BasisChoice) -> "Reduced":
        (stiffness, mass), psi = frame.matrices(), reduce(frame, choice).z[:, 1:]
        return cls(psi.T @ stiffness @ psi, psi.T @ mass @ psi, np.vstack(list(frame.interface_rows().values())) @ psi)

    @classmethod
    def rate(cls, frame: Frame, choice: BasisChoice, variable: str, turn: np.ndarray | None = None) -> "Reduced":
        """By the product rule; `turn` adds a motion of the basis inside its own span."""
        (stiffness, mass), basis, d = frame.matrices(), reduce(frame, choice), design_rates(frame, variable)
        psi = basis.z[:, 1:]
        d_psi = basis.rate(d.stiffness, d.mass, d.xi, d.interface_rows)[:, 1:]
        d_psi = d_psi if turn is None else d_psi + psi @ turn
        rows, d_rows = (np.vstack(list(found.values())) for found in (frame.interface_rows(), d.interface_rows))

        def product_rule(matrix, d_matrix):
            half = d_psi.T @ matrix @ psi
            return half + half.T + psi.T @ d_matrix @ psi

        return cls(product_rule(stiffness, d.stiffness), product_rule(mass, d.mass), d_rows @ psi + rows @ d_psi)

    def receptance(self, shift: float) -> np.ndarray:
        """R (K + shift M)^-1 R^T: what loads at the interface points do there; the same for every basis of the span."""
        return self.rows @ np.linalg.solve(self.stiffness + shift * self.mass, self.rows.T)


def softest(reduced: Reduced) -> tuple[np.ndarray, np.ndarray]:
    """The five largest 1 / lambda with vectors of unit strain energy: M v = K v / lambda, which keeps the digits of small lambda."""
    found, vectors = eigh(reduced.mass, reduced.stiffness)
    return found[-5:], vectors[:, -5:]


def receptance_rate(value: Reduced, rate: Reduced, shift: float) -> np.ndarray:
    solved = np.linalg.solve(value.stiffness + shift * value.mass, value.rows.T)
    half = rate.rows @ solved
    return half + half.T - solved.T @ (rate.stiffness + shift * rate.mass) @ solved


def scaled(matrix: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Displacements and rotations made comparable by the diagonal of the reference."""
    size = np.sqrt(np.abs(np.diag(reference)))
    return matrix / np.outer(size, size)


@pytest.mark.parametrize("variable", VARIABLES)
@pytest.mark.parametrize("kind", CHOICES)
def test_eigenvalues_and_receptance_of_the_reduced_body_change_as_those_of_fresh_reductions(kind, variable):
    choice, shift = CHOICES[kind], 1e6  # 1/s^2: between the lowest eigenvalues
    value, rate = Reduced.fresh(INSIDE, choice), Reduced.rate(INSIDE, choice, variable)
    flexibilities, vectors = softest(value)
    reference = Reduced.fresh(INSIDE, CHOICES["full"]).receptance(shift)

    def responses(reduced):
        return np.concatenate([softest(reduced)[0] / flexibilities, scaled(reduced.receptance(shift), reference).ravel()])

    ours = np.einsum("ij,ij->j", vectors, rate.mass @ vectors / flexibilities - rate.stiffness @ vectors)
    ours = np.concatenate([ours, scaled(receptance_rate(value, rate, shift), reference).ravel()])
    fresh = richardson(lambda step: responses(Reduced.fresh(varied(INSIDE, variable, step), choice)), 0.128, 4)
    # round-off of fresh solutions, 1e-9, over the smallest step, 1.6e-2
    assert np.abs(ours - fresh).max() < 1e-7 * max(1.0, np.abs(ours).max())


@pytest.mark.parametrize("kind", ["clamped", "free", "craig-bampton", "static"])
def test_responses_do_not_feel_a_motion_of_the_basis_inside_its_span(kind, rng):
    choice, shift = CHOICES[kind], 1e6
    value, plain = Reduced.fresh(INSIDE, choice), Reduced.rate(INSIDE, choice, "shape")
    size = np.sqrt(np.diag(value.mass))
    turn = rng.normal(size=value.mass.shape) * size / size[:, None]
    turned = Reduced.rate(INSIDE, choice, "shape", turn)
    reference = value.receptance(shift)
    one, other = (scaled(receptance_rate(value, rate, shift), reference) for rate in (plain, turned))
    assert relative(other, one) < 1e-9  # round-off times the condition of the reduced matrices


@pytest.mark.parametrize("kind", ["craig-bampton", "static"])
@pytest.mark.parametrize("frame", [wing(), INSIDE], ids=["nodes", "inside"])
def test_bases_with_constraint_modes_are_statically_exact_at_the_interface_points(frame, kind):
    found = Reduced.fresh(frame, CHOICES[kind]).receptance(0.0)
    rows = np.vstack(list(frame.interface_rows().values()))[:, 3:]
    whole = rows @ np.linalg.solve(frame.matrices()[0][3:, 3:], rows.T)
    # relative 1e-10 in displacements; the reference itself loses the condition of the stiffness, 1e7
    assert np.abs(scaled(found - whole, whole)).max() < 1e-9


def test_interface_coordinates_are_the_motions_of_the_interface_points():
    psi = reduce(INSIDE, CHOICES["craig-bampton"]).z[:, 1:]
    rows = np.vstack(list(INSIDE.interface_rows().values()))
    np.testing.assert_allclose(rows @ psi, np.eye(9, 14), atol=1e-8)  # mass-normalised modes have entries of 1e2


def invariants(frame: Frame, z: np.ndarray):
    return contract(matrices(CurveMesh(frame.nodes, frame.connectivity), frame.section), z)


@pytest.mark.parametrize("frame", [wing(), INSIDE, replace(wing(), points={"C": 9.02, "D": 9.5})], ids=["nodes", "in", "both in"])
@pytest.mark.parametrize("count", [0, 10, 40])
def test_mass_matrices_of_craig_bampton_bases_are_well_scaled(frame, count):
    z = reduce(frame, BasisChoice("craig-bampton", count=count)).z
    assert np.linalg.eigvalsh(generalized_mass(invariants(frame, z))).min() > 10 * SMALLEST_MASS_EIGENVALUE


def test_free_eigenmodes_keep_momentum_and_moment_of_momentum_in_the_frame():
    """Mean axes: no elastic coordinate moves the centre of mass or has a moment of momentum about the undeformed shape."""
    basis = reduce(wing(), CHOICES["free"])
    found = invariants(wing(), basis.z)
    assert basis.reference_condition == MEAN_AXES
    length = np.sqrt(found.inertia[0, 0] / found.mass)
    size = np.sqrt(np.diag(found.inertia)[1:] * found.mass)
    assert np.abs(found.first_moment[:, 1:] / size).max() < 1e-9  # round-off times the condition of the stiffness, 1e7
    assert np.abs(found.gyroscopic[0, 1:] / size / length).max() < 1e-9


def test_a_point_on_the_clamped_node_adds_no_coordinates():
    basis = reduce(replace(wing(), points={"F": 0.0, "C": 10.0}), BasisChoice("static"))
    assert basis.z.shape == (93, 4)
    assert basis.description == "differentiated: static, 3 constraint modes of the interface points C"


def test_a_point_that_leaves_the_clamped_node_is_refused():
    basis = reduce(replace(wing(), points={"F": 0.0, "C": 10.0}), BasisChoice("static"))
    zero = np.zeros((93, 93))
    with pytest.raises(InputError, match="'F' sits on the clamped node"):
        basis.rate(zero, zero, np.zeros(93), {"F": np.ones((3, 93))})


@pytest.mark.parametrize("kind", ["clamped", "free", "craig-bampton", "static"])
def test_a_frozen_basis_changes_with_the_shape_only(kind):
    choice = replace(CHOICES[kind], derivative="frozen")
    basis, d = reduce(INSIDE, choice), design_rates(INSIDE, "shape")
    rate = basis.rate(d.stiffness, d.mass, d.xi, d.interface_rows)
    assert np.array_equal(rate[:, 0], d.xi)
    assert not np.any(rate[:, 1:])
    assert basis.description.startswith(f"frozen: {choice.kind}")
    assert np.array_equal(basis.z, reduce(INSIDE, CHOICES[kind]).z)


def test_the_full_basis_is_the_tangent_frame_and_changes_with_the_shape_only():
    basis, d = reduce(INSIDE, CHOICES["full"]), design_rates(INSIDE, "shape")
    expected = tangent_frame(INSIDE.nodes, 0, "F")
    assert np.array_equal(basis.z, expected.z)
    assert (
        basis.description == expected.description == "differentiated: identity on the free coordinates, the same at every design"
    )
    rate = basis.rate(d.stiffness, d.mass, d.xi)
    assert np.array_equal(rate[:, 0], d.xi)
    assert not np.any(rate[:, 1:])


@pytest.mark.parametrize("kind", CHOICES)
def test_all_variables_at_once_are_each_of_them_alone(kind):
    basis, changes = reduce(INSIDE, CHOICES[kind]), [design_rates(INSIDE, variable) for variable in VARIABLES]
    together = basis.rates(changes)
    assert together.shape == (*basis.z.shape, len(VARIABLES))
    for x, d in enumerate(changes):
        alone = basis.rate(d.stiffness, d.mass, d.xi, d.interface_rows)
        np.testing.assert_allclose(together[:, :, x], alone, rtol=0, atol=1e-10 * max(np.abs(alone).max(), 1.0))  # same factors
    assert basis.rates([]).shape == (*basis.z.shape, 0)


def test_modes_are_chosen_by_count_by_frequency_and_by_static_error():
    frequencies = reduce(wing(), BasisChoice("eigenmodes", count=6)).frequencies
    by_frequency = reduce(wing(), BasisChoice("eigenmodes", frequency=frequencies[-1] * 1.001))
    assert by_frequency.description == f"differentiated: eigenmodes, 6 clamped eigenmodes up to {frequencies[-1]:.6g} Hz"
    assert len(reduce(wing(), BasisChoice("craig-bampton", frequency=1.0)).frequencies) == 0
    choice = BasisChoice("eigenmodes", static_error=0.05)
    whole = Reduced.fresh(wing(), BasisChoice("full")).receptance(0.0)
    error = scaled(whole - Reduced.fresh(wing(), choice).receptance(0.0), whole)
    assert np.linalg.norm(error, 2) <= 0.05 * np.linalg.norm(scaled(whole, whole), 2)


def test_a_differentiated_basis_that_cuts_a_pair_is_refused_and_a_frozen_one_is_not():
    frame = ring(24, 100.0, points={"P": 3.0})
    with pytest.raises(InputError, match=r"mode 3 .* is kept and mode 4 .* is left out.*Keep 2 or 4 modes.*frozen"):
        reduce(frame, BasisChoice("eigenmodes", boundary="free", count=3))
    assert reduce(frame, BasisChoice("eigenmodes", boundary="free", count=3, derivative="frozen")).z.shape == (72, 4)


@pytest.mark.parametrize(
    ("points", "match"),
    [
        ({}, "needs an interface point away from the clamped node; got none"),
        ({"F": 0.0}, "needs an interface point away from the clamped node; got F"),
        ({"P": 3.0, "Q": 3.0}, "'Q' cannot move independently of 'P'"),
        ({"P": 2.2, "Q": 2.2 + 1e-3}, "'Q' cannot move independently of 'P'"),
        ({"P": 2.2, "Q": 2.4, "R": 2.7}, "'R' cannot move independently of 'P', 'Q'"),
    ],
)
def test_interface_points_that_make_no_basis_are_refused(points, match):
    with pytest.raises(InputError, match=match):
        reduce(cantilever(5, angle=0.3, points=points), BasisChoice("static"))


def test_points_so_close_that_round_off_mixes_them_up_are_refused():
    with pytest.raises(InputError, match=r"interface points P, Q cannot be told apart .*Move points apart"):
        reduce(replace(wing(), points={"P": 10.3, "Q": 10.4}), BasisChoice("craig-bampton", count=5))


@pytest.mark.parametrize(
    ("keys", "match"),
    [
        ({"kind": "modal"}, "kind 'modal' is unknown; available: full, eigenmodes, craig-bampton, static"),
        ({"kind": "eigenmodes"}, "exactly one of count, frequency, static_error; got none"),
        ({"kind": "eigenmodes", "count": 3, "frequency": 5.0}, "got count, frequency"),
        ({"kind": "eigenmodes", "count": 0}, "needs at least 1"),
        ({"kind": "craig-bampton", "static_error": 0.1}, "statically exact at its interface points"),
        ({"kind": "craig-bampton", "count": 3, "boundary": "free"}, "a craig-bampton basis is clamped"),
        ({"kind": "static", "count": 3}, "a static basis has no eigenmodes"),
        ({"kind": "full", "count": 3}, "the full basis keeps every coordinate"),
        ({"kind": "full", "derivative": "exact"}, "available: differentiated, frozen"),
    ],
)
def test_choices_that_cannot_be_meant_are_refused(keys, match):
    with pytest.raises(InputError, match=match):
        BasisChoice(**keys)


@pytest.fixture
def rng():
    return np.random.default_rng(3)
