"""Invariants against closed forms of the polygon, rigid motions, complex steps and fresh builds at other designs."""

from dataclasses import asdict, fields
from pathlib import Path

import numpy as np
import pytest

from preprocessing import build
from preprocessing.builders.curve_mesh import mesh_curve
from preprocessing.elements.beams import PlanarBeam
from preprocessing.elements.section import Section, distribute
from preprocessing.reduction.assembly import assemble
from preprocessing.reduction.chosen_basis import tangent_frame, undeformed
from preprocessing.reduction.invariants import contract, contract_derivative, polynomials
from toolkit.reduced_model.dependence import scattered
from toolkit.reduced_model.design_point import DesignPoint, rates_at
from toolkit.reduced_model.model import Invariants, generalized_mass

MODELS = Path(__file__).parents[2] / "models" / "morphing_wing"
SECTION = Section(youngs_modulus=70000.0, density=2.7e-9, thickness=1.5, width=1000.0, damping_mass=3.0, damping_stiffness=2e-5)
NAMES = [f.name for f in fields(Invariants)]
VALUES = asdict(SECTION)
ANGLE = np.linspace(0.4, 3.6, 9)
NODES = np.column_stack([60 + 80 * np.cos(ANGLE), 10 + 30 * np.sin(ANGLE)])
"""Half an ellipse, not symmetric to the axes."""


@pytest.fixture(scope="module")
def parts():
    mesh = mesh_curve(NODES)
    return assemble(PlanarBeam(mesh.nodes, mesh.connectivity, distribute(VALUES, {}, (), len(NODES) - 1).patches))


@pytest.fixture(scope="module")
def complete():
    """Z with all nodal coordinates free: rigid motions are in the span of Psi."""
    return np.column_stack([undeformed(NODES), np.eye(NODES.size // 2 * 3)])


@pytest.fixture(scope="module")
def invariants(parts, complete):
    return contract(parts.at(VALUES), complete)


@pytest.fixture(scope="module")
def model():
    return build(MODELS / "skin.toml")


def translation(axis: int) -> np.ndarray:
    """Nodal coordinates of a unit rigid translation."""
    return np.tile(np.eye(3)[axis], len(NODES))


def rigid_rotation() -> np.ndarray:
    """Nodal coordinates of a unit rigid rotation about the origin."""
    return np.column_stack([-NODES[:, 1], NODES[:, 0], np.ones(len(NODES))]).ravel()


def segments():
    """Mass and both ends of the straight segments of the polygon."""
    one, two = NODES[:-1], NODES[1:]
    per_length = SECTION.density * SECTION.width * SECTION.thickness
    return per_length * np.linalg.norm(two - one, axis=1), one, two


def close(ours, expected, tolerance=1e-12):
    """Agreement relative to the largest entry; the default is round-off of sums over a few hundred products."""
    np.testing.assert_allclose(ours, expected, rtol=0, atol=tolerance * np.abs(expected).max())


def test_mass_first_moment_and_inertia_are_those_of_the_polygon(invariants):
    mass, one, two = segments()
    close(invariants.mass, mass.sum())
    close(invariants.first_moment[:, 0], mass @ (one + two) / 2)
    close(invariants.inertia[0, 0], mass @ ((one**2).sum(1) + (two**2).sum(1) + (one * two).sum(1)) / 3)


def test_rigid_translation_has_the_mass_of_the_body(invariants):
    for axis in (0, 1):
        t = translation(axis)
        close(invariants.first_moment[axis, 1:] @ t, invariants.mass)
        close(t @ invariants.inertia[1:, 1:] @ t, invariants.mass)


def test_rigid_rotation_has_the_inertia_of_the_body(invariants):
    rotation, inertia = rigid_rotation(), invariants.inertia[0, 0]
    close(rotation @ invariants.inertia[1:, 1:] @ rotation, inertia)
    close(invariants.gyroscopic[0, 1:] @ rotation, inertia)  # m_rf = z^T H[:, f] of the undeformed body
    close(invariants.first_moment[:, 1:] @ rotation, [[0, -1], [1, 0]] @ invariants.first_moment[:, 0])


def test_inertia_is_symmetric_and_gyroscopic_is_antisymmetric(invariants):
    close(invariants.inertia, invariants.inertia.T)
    close(invariants.gyroscopic, -invariants.gyroscopic.T)


def test_rigid_motions_store_no_energy_and_no_stress(invariants):
    for motion in (translation(0), translation(1), rigid_rotation()):
        # round-off relative to the largest product in the sums
        assert np.abs(invariants.stiffness @ motion).max() < 1e-13 * np.abs(invariants.stiffness).max() * np.abs(motion).max()
        assert np.abs(invariants.stress_operator @ motion).max() < 1e-13 * np.abs(invariants.stress_operator).max() * 100


def test_damping_is_the_rayleigh_sum(invariants):
    close(invariants.damping, 3.0 * invariants.inertia[1:, 1:] + 2e-5 * invariants.stiffness)


def test_gyroscopic_invariant_from_the_mass_matrix_alone_would_be_wrong(invariants):
    """Turning the nodal vectors by 90 degrees instead of integrating M_ab mixes up axial and transverse functions."""
    turn = np.kron(np.eye(len(NODES)), [[0, -1, 0], [1, 0, 0], [0, 0, 0]])
    mass = invariants.inertia[1:, 1:]
    shortcut = (turn.T @ mass - mass @ turn) / 2
    true = invariants.gyroscopic[1:, 1:]
    assert np.linalg.norm(shortcut - true) > 0.2 * np.linalg.norm(true)  # 0.29 on the skin of the reference scene


@pytest.mark.parametrize("clamp", [0, -1])
def test_clamping_one_node_leaves_no_rigid_motion(parts, clamp):
    basis = tangent_frame(NODES, clamp, "F")
    invariants = contract(parts.at(VALUES), basis.z)
    assert np.linalg.eigvalsh(generalized_mass(invariants)).min() > 0
    assert np.linalg.eigvalsh(invariants.stiffness).min() > 0
    assert not np.any(basis.z.reshape(len(NODES), 3, -1)[clamp, :2, 1:])


def test_product_rule_matches_complex_step_through_matrices_and_basis(parts, complete, rng):
    d_z = rng.normal(size=complete.shape)
    exact = contract(parts.at(VALUES | {"thickness": SECTION.thickness + 1e-30j}), complete + 1e-30j * d_z)
    d_matrices = parts.derivative(VALUES, "thickness")
    ours = contract_derivative(parts.at(VALUES), d_matrices, complete, d_z)
    for name in NAMES:
        close(getattr(ours, name), getattr(exact, name).imag / 1e-30)


@pytest.fixture
def rng():
    return np.random.default_rng(1)


def test_polynomials_are_exact_at_any_design(parts, complete):
    other = dict(zip(VALUES, [1.1e5, 1e-9, 3.7, 12.0, 0.4, 1e-4], strict=True))
    found, fresh = polynomials(parts, list(VALUES), complete), contract(parts.at(other), complete)
    for name in NAMES:
        value = getattr(fresh, name)
        close(found[name](np.array(list(other.values())), value.size).reshape(value.shape), value)


@pytest.mark.parametrize("parameter", VALUES)
def test_rates_of_the_polynomials_are_the_product_rule(parts, complete, parameter):
    found, k = polynomials(parts, list(VALUES), complete), list(VALUES).index(parameter)
    rule = contract_derivative(parts.at(VALUES), parts.derivative(VALUES, parameter), complete)
    for name in NAMES:
        expected = getattr(rule, name)
        value = scattered(*found[name].rates(np.array(list(VALUES.values()))).by(k), expected.size).reshape(expected.shape)
        np.testing.assert_allclose(value, expected, rtol=0, atol=1e-12 * np.abs(expected).max())  # round-off, as in `close`


@pytest.mark.parametrize("parameter", ["youngs_modulus", "density", "thickness", "width", "damping_mass", "damping_stiffness"])
def test_rates_of_the_model_are_the_complex_step_of_its_values(model, parameter):
    nominal, step = DesignPoint(model), 1e-30 * max(model.nominal[parameter], 1e-3)
    stepped = DesignPoint(model, {parameter: model.nominal[parameter] + 1j * step}).invariants()
    for name in NAMES:
        value = np.imag(getattr(stepped, name)) / step
        np.testing.assert_allclose(
            scattered(*rates_at(nominal, name, {parameter: 0}).by(0), value.size).reshape(value.shape),
            value,
            rtol=0,
            atol=1e-12 * np.abs(value).max(),
        )


def test_nominal_model_is_its_polynomials_at_the_nominal_design(model):
    evaluated = DesignPoint(model, {"thickness": 1.5 * (1 + 1e-30j)}).invariants()
    for name in NAMES:
        value = getattr(model.invariants, name)
        np.testing.assert_allclose(getattr(evaluated, name), value, rtol=0, atol=1e-13 * np.abs(value).max())


def test_skin_has_the_reference_length_and_places_in_nodes_and_target(model):
    """Check data of the reference scene: stations on both shapes, printed with six decimals."""
    reference = np.genfromtxt(Path(__file__).parents[1] / "data" / "skin_nodes.csv", delimiter=",", skip_header=1)
    np.testing.assert_allclose(model.shape.arc_length, reference[:, 1], atol=1e-6)  # the printed decimals
    # between the rows of the file the curve depends on the parameter of the spline: 1e-5 mm at the nose
    np.testing.assert_allclose(model.mesh.nodes, reference[:, 2:4], atol=3e-5)
    np.testing.assert_allclose(model.shape.target, reference[:, 4:6], atol=3e-5)


def test_shape_and_recovery_give_the_nodes_at_rest(model):
    rest = np.eye(1 + model.n_f)[0]
    assert np.array_equal(model.shape.position @ rest, model.mesh.nodes)
    assert np.array_equal((model.mesh.recovery @ rest).reshape(-1, 3)[:, :2], model.mesh.nodes)
    assert model.mesh.recovery.shape == (93, 91)
    assert model.invariants.stress_operator.shape == (120, 90)


def test_stress_rows_name_element_end_and_fibre(model):
    """Stretching the first element alone, by moving node 1 along it, must show in the rows of elements 0 and 1 only."""
    stress = np.abs(model.invariants.stress_operator[:, 0])
    assert set(model.stress.element[stress > 1e-9 * stress.max()]) == {0, 1}
    assert model.stress.end[:4].tolist() == [0, 0, 1, 1]
    assert model.stress.fibre[:4].tolist() == [1, -1, 1, -1]
