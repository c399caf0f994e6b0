"""Every finite element against things from outside: rigid motions, points of mass, constant strain, complex steps."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from preprocessing.builders.discrete_body import DiscreteBody
from preprocessing.builders.reduced_body import reduced_body
from preprocessing.elements.section import Patch
from preprocessing.mesh.solid_mesh import SolidMesh
from preprocessing.reduction.basis import BasisChoice
from preprocessing.reduction.discretisation import DesignSpace, Discretisation
from preprocessing.reduction.invariants import contract, contract_derivative, polynomials
from preprocessing.reduction.reduced import reduce
from tests.models.elements import ELEMENTS, STEP, VALUES, Case, stepped_values
from tests.models.new_elements import ShearBeam
from toolkit.reduced_model.dependence import scattered
from toolkit.reduced_model.parts import all_second_moments

every_element = pytest.mark.parametrize("case", ELEMENTS, ids=lambda case: case.name)


def complete(case: Case, displacements: np.ndarray) -> np.ndarray:
    """With the hidden coordinates of the element."""
    return case.nominal.coordinates.displacement(displacements.reshape(len(displacements), -1))


def motions_at(places: np.ndarray) -> np.ndarray:
    """Displacements (n, d, m) at places (n, d) under the unit rigid motions: translations, then rotations about the axes."""
    n, d = places.shape
    axes = np.eye(3)
    arms = np.column_stack([places, np.zeros((n, 3 - d))])
    turned = np.stack([np.cross(axis, arms) for axis in (axes if d == 3 else axes[2:])], axis=2)
    return np.concatenate([np.tile(np.eye(d), (n, 1, 1)), turned[:, :d]], axis=2)


def rigid(case: Case, values: Any) -> np.ndarray:
    """The same of all nodal coordinates; rotations of nodes are those of the body."""
    moved, per_node = motions_at(case.nodes(values)), case.nominal.coordinates.per_node
    d = moved.shape[1]
    turned = np.eye(moved.shape[2])[d:][: per_node - d]
    return np.concatenate([moved, np.tile(turned, (len(moved), 1, 1))], axis=1).reshape(-1, moved.shape[2])


def rigid_mass(case: Case, values: Any) -> np.ndarray:
    """Mass matrix of the rigid motions from the points of mass."""
    mass, places = case.points(values)
    moved = motions_at(places)
    return np.einsum("p,pai,paj->ij", np.broadcast_to(mass, len(places)), moved, moved)


def close(found, expected, tolerance=1e-12, scale=None):
    """Relative to the largest entry; the default is round-off of some hundred products."""
    np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance * (np.abs(expected).max() if scale is None else scale))


@every_element
def test_rigid_motions_strain_nothing_and_all_other_motions_do(case):
    matrices, motions = case.matrices, complete(case, rigid(case, case.values))
    stiffness, stress = matrices.stiffness.toarray(), matrices.stress.toarray()
    close(stiffness @ motions, 0, 1e-12, np.abs(stiffness).max())
    close(stress @ motions, 0, 1e-12, np.abs(stress).max())
    n = case.nominal.coordinates.nodal
    scale = 1 / np.sqrt(np.diag(stiffness)[:n])
    energies = np.linalg.eigvalsh(scale[:, None] * stiffness[:n, :n] * scale)
    assert np.count_nonzero(energies < 1e-10) == motions.shape[1]  # round-off is 1e-15, the softest deformation here 1e-4


@every_element
def test_rigid_motions_have_the_mass_and_the_inertia_of_the_body(case):
    motions = complete(case, rigid(case, case.values))
    close(motions.T @ (case.matrices.mass @ motions), rigid_mass(case, case.values))


@every_element
def test_the_undeformed_body_has_the_moments_of_its_points(case):
    nodes, (mass, places) = case.nodes(case.values), case.points(case.values)
    masses, coordinates = np.broadcast_to(mass, len(places)), case.nominal.coordinates
    xi = np.column_stack([nodes, np.zeros((len(nodes), coordinates.per_node - nodes.shape[1]))]).ravel()
    found = contract(case.matrices, np.column_stack([xi, np.eye(len(xi))]))
    second = np.einsum("p,pa,pb->ab", masses, places, places)
    close(found.mass, masses.sum())
    close(found.first_moment[:, 0], masses @ places)
    if nodes.shape[1] == 2:
        close(found.inertia[0, 0], np.trace(second))
        return
    close(found.second_moment[:, 0, 0], [second[pair] for pair in coordinates.space.pairs])


@every_element
def test_turning_with_the_frame_a_rigid_motion_through_the_nodes_has_the_angular_momentum_of_the_points(case):
    """sum m x cross v, from the first row of every M_ab - M_ba: rows and columns of M_ab must not be mistaken."""
    nodes, (mass, places) = case.nodes(case.values), case.points(case.values)
    coordinates, d = case.nominal.coordinates, places.shape[1]
    xi = np.column_stack([nodes, np.zeros((len(nodes), coordinates.per_node - d))]).ravel()
    found, motions = contract(case.matrices, np.column_stack([xi, np.eye(len(xi))])), rigid(case, case.values)
    x, v = (np.moveaxis(each, 1, 0) for each in (places, motions_at(places)))
    moment = {(a, b): np.einsum("p,p,pm->m", np.broadcast_to(mass, len(places)), x[a], v[b]) for a in range(d) for b in range(d)}
    if d == 2:
        close(found.gyroscopic[0, 1:] @ motions, moment[0, 1] - moment[1, 0])
        return
    every = all_second_moments(found.second_moment)[:, :, 0, 1:] @ motions
    for a, b in ((0, 1), (1, 2), (2, 0)):
        close(every[a, b] - every[b, a], moment[a, b] - moment[b, a])


@every_element
def test_constant_strain_has_its_energy_and_its_stress_and_leaves_no_force(case):
    matrices, state = case.matrices, case.state(case.values)
    u = complete(case, state.u)[:, 0]
    forces = matrices.stiffness @ u
    close(u @ forces / 2, state.energy)
    close(matrices.stress @ u, state.stress, 1e-11)  # strains of 1e-2 from displacements of 1
    close(forces[case.balanced], 0, 1e-12, np.abs(forces).max())


PAIRS = [(case, name) for case in ELEMENTS for name in case.values]


@pytest.mark.parametrize(("case", "parameter"), PAIRS, ids=lambda each: each if isinstance(each, str) else each.name)
def test_derivatives_by_every_parameter_are_the_complex_steps_of_the_closed_forms(case, parameter):
    """Of strain energy, stress, rigid mass and damping; where the parameter moves nodes, displacements move with them."""
    values, stepped, size = case.values, stepped_values(case.values, parameter), abs(case.values[parameter])
    ours, rate = case.matrices, case.rate(parameter)
    state, exact = case.state(values), case.state(stepped)
    u, du = (complete(case, each)[:, 0] for each in (state.u, np.imag(exact.u) / STEP))
    r, dr = (complete(case, each) for each in (rigid(case, values), np.imag(rigid(case, stepped)) / STEP))

    def judged(found, closed_form):
        expected = np.imag(closed_form) / STEP
        scale = max(np.abs(expected).max(), np.abs(np.real(closed_form)).max() / size)
        close(found, expected, 1e-10, scale)

    def quadratic(name, x, dx):
        half = dx.T @ (getattr(ours, name) @ x)
        return x.T @ (getattr(rate, name) @ x) + half + half.T

    damping_of = {name: (stepped[f"damping_{name}"]) for name in ("mass", "stiffness")}
    judged(quadratic("stiffness", u, du) / 2, exact.energy)
    judged(rate.stress @ u + ours.stress @ du, exact.stress)
    judged(quadratic("mass", r, dr), rigid_mass(case, stepped))
    judged(quadratic("damping", r, dr), damping_of["mass"] * rigid_mass(case, stepped))
    of_mass = u @ (ours.mass @ u) + 1j * STEP * quadratic("mass", u, du)
    judged(quadratic("damping", u, du), damping_of["mass"] * of_mass + damping_of["stiffness"] * 2 * exact.energy)


@every_element
@pytest.mark.parametrize("parameter", ["density", "youngs_modulus", "damping_stiffness"])
def test_the_product_rule_of_the_invariants_is_the_complex_step_through_matrices_and_basis(case, parameter):
    z, d_z = np.random.default_rng(9).normal(size=(2, case.nominal.coordinates.nodal, 4))
    exact = contract(case.parts.at(stepped_values(case.values, parameter)), z + 1j * STEP * d_z)
    ours = contract_derivative(case.matrices, case.rate(parameter), z, d_z)
    for name in (each.name for each in fields(ours)):
        expected = np.imag(getattr(exact, name)) / STEP
        close(getattr(ours, name), expected, 1e-11, max(np.abs(expected).max(), np.abs(np.real(getattr(exact, name))).max()))


@every_element
def test_invariants_are_the_polynomials_that_are_stored_at_any_design(case):
    parts, names = case.parts, list(case.values)
    z = np.random.default_rng(7).normal(size=(parts.coordinates.nodal, 5))
    inside = {name for part in parts.parts for name in dict(part.factors)}
    other = {name: value * (1.3 if name in inside else 1.0) for name, value in case.values.items()}
    found, fresh = polynomials(parts, names, z), contract(parts.at(other), z)
    for name in (each.name for each in fields(fresh)):
        expected = getattr(fresh, name)
        close(found[name](np.array(list(other.values())), expected.size).reshape(expected.shape), expected, 1e-11)


def test_a_new_line_element_becomes_a_reduced_model_with_the_deflection_of_timoshenko():
    """Of n equal elements with the shear of their middle, P L^3 / 3 E I (1 - 1 / 4 n^2) + P L / k G A at the tip."""
    n, length, shear = 4, 2.0, 5 / 12 / 1.3
    chain = np.column_stack([np.arange(n), np.arange(1, n + 1)])
    names = {name: name for name in VALUES if name not in ("poisson_ratio", "reach")}
    x = np.linspace(0, length, n + 1)
    beams = ShearBeam(np.column_stack([x, 0 * x]), chain, [Patch(np.arange(n), names)], shear)
    found = Discretisation(beams, {"tip": length, "inside": 0.9}, x)
    values = {name: VALUES[name] for name in names}
    space = DesignSpace(values, dict.fromkeys(names, "none"), frozenset(names), lambda _: found)
    model = reduce(space, BasisChoice("static"), 0, "the root")
    across = model.interfaces["tip"].position[0, 1, 1:]
    e, t, b = (values[name] for name in ("youngs_modulus", "thickness", "width"))
    bending, area = e * b * t**3 / 12, t * b
    expected = length**3 / (3 * bending) * (1 - 1 / (4 * n**2)) + length / (shear * e * area)
    np.testing.assert_allclose(across @ np.linalg.solve(model.invariants.stiffness, across), expected, rtol=1e-10)


def test_a_new_element_without_rotations_becomes_a_reduced_model_with_the_stiffness_of_its_bars():
    """Two bars that meet at the only free node: sum E A / L e e^T."""
    truss = next(case for case in ELEMENTS if case.name == "bar")
    nodes, parameters = truss.nodes(truss.values), {k: v for k, v in truss.values.items() if k != "reach"}
    body = DiscreteBody(SolidMesh(nodes), truss.parts, parameters, {}, {}, np.array([0, 1]), {}, None, {})
    model = reduced_body(body, BasisChoice("full"), "the hinges", "m-kg-s")
    arms = nodes[2] - nodes[:2]
    expected = (
        sum(np.outer(arm, arm) / np.linalg.norm(arm) ** 3 for arm in arms) * parameters["youngs_modulus"] * parameters["area"]
    )
    close(model.invariants.stiffness, expected)
    k = list(parameters).index("area")
    slope = scattered(*model.affine["stiffness"].rates(np.array(list(parameters.values()))).by(k), 4).reshape(2, 2)
    close(slope, expected / parameters["area"])
