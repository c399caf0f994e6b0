"""Solid elements and their reduction: closed forms, brute-force quadrature, convergence, and bases against the full body."""

from __future__ import annotations

import numpy as np
import pytest
import skfem
from scipy import sparse

from preprocessing import build
from preprocessing.builders.body_recipe import BodyRecipe
from preprocessing.builders.discrete_body import discrete_body, lame_factors
from preprocessing.builders.reduced_body import nodal_stress
from preprocessing.elements.elasticity import solid_matrices
from preprocessing.elements.solid_elements import element_blocks
from preprocessing.elements.stress import Elastic, stress_rows
from preprocessing.mesh.faces import outline_of
from preprocessing.mesh.solid_mesh import SolidMesh, rigid_motions
from preprocessing.reduction import sparse_modes
from preprocessing.reduction.ties import freedom, tie
from tests.models.solid_bodies import (
    DENSITY,
    KINDS,
    MODULUS,
    WIDTH,
    cantilever,
    compliance,
    frequencies,
    rectangle,
    write_body,
)
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.file import load, save
from toolkit.render.plane.configuration import lines_of

pytestmark = pytest.mark.usefixtures("read_here")

BASES = {
    "full": 'kind = "full"',
    "craig-bampton": 'kind = "craig-bampton"\ncount = 5',
    "static": 'kind = "static"',
    "eigenmodes": 'kind = "eigenmodes"\ncount = 9',
}


@pytest.mark.parametrize("kind", KINDS)
def test_mass_centre_and_inertia_are_those_of_a_rectangle(kind, tmp_path):
    inv = cantilever(tmp_path, rectangle(kind, (4, 2), 2.0, 0.5)).invariants
    mass = DENSITY * WIDTH * 2.0 * 0.5
    np.testing.assert_allclose(inv.mass, mass, rtol=1e-13)  # round-off, here and below
    np.testing.assert_allclose(inv.first_moment[:, 0], [mass * 1.0, 0.0], atol=1e-13 * mass)
    np.testing.assert_allclose(inv.inertia[0, 0], mass * (2.0**2 / 3 + 0.5**2 / 12), rtol=1e-13)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("state", ["plane-stress", "plane-strain"])
def test_bent_elements_resist_no_rigid_motion_and_reproduce_constant_stress(kind, state):
    """The patch test, with the stress in the elements and along the boundary."""
    mesh = rectangle(kind, (4, 3), 2.0, 1.0, bent=0.03)
    blocks, outline = element_blocks(mesh), outline_of(mesh.nodes, mesh.blocks)
    matrices, (by_lambda, by_mu) = solid_matrices(blocks, len(mesh.nodes), 2), lame_factors(0.3, state)
    stiffness = by_lambda * matrices.first + by_mu * matrices.shear
    assert np.abs(stiffness @ rigid_motions(mesh.nodes)).max() < 1e-13 * abs(stiffness).max()  # round-off, here and below
    values = np.linalg.eigvalsh(stiffness.toarray())
    assert np.count_nonzero(values < 1e-10 * values[-1]) == 3
    gradient = np.array([[0.3, -0.5], [0.9, 0.2]])
    strain = (gradient + gradient.T) / 2
    sigma = by_lambda * np.trace(strain) * np.eye(2) + 2 * by_mu * strain
    u = (mesh.nodes @ gradient.T).ravel()
    for quantity, (a, b) in {"xx": (0, 0), "yy": (1, 1), "xy": (0, 1)}.items():
        first, shear = stress_rows(quantity, blocks, outline)
        np.testing.assert_allclose((by_lambda * first + by_mu * shear) @ u, sigma[a, b], rtol=1e-12)
    ratio = 0.3 if state == "plane-strain" else 0.0
    nodal = nodal_stress(Elastic(blocks, mesh.nodes, (by_lambda, by_mu), ratio), u[:, None])[:, :, 0]
    across = ratio * np.trace(sigma)
    np.testing.assert_allclose(nodal, np.tile([sigma[0, 0], sigma[1, 1], across, sigma[0, 1]], (len(mesh.nodes), 1)), atol=1e-12)
    first, shear = stress_rows("tangential", blocks, outline)
    along = np.einsum("ei,ij,ej->e", outline.tangents, sigma, outline.tangents)
    np.testing.assert_allclose((by_lambda * first + by_mu * shear) @ u, along, atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_triangles_for_pictures_cover_the_body_once(kind, tmp_path):
    interior = cantilever(tmp_path, rectangle(kind, (4, 2), 2.0, 0.5)).interior
    (x_1, y_1), (x_2, y_2), (x_3, y_3) = (interior.position[corner, :, 0].T for corner in interior.triangles.T)
    areas = ((x_2 - x_1) * (y_3 - y_1) - (x_3 - x_1) * (y_2 - y_1)) / 2
    assert areas.min() > 0
    assert areas.sum() == pytest.approx(2.0 * 0.5, rel=1e-12)  # round-off
    assert len(np.unique(interior.triangles)) == len(interior.position)


def test_outline_follows_the_outer_line_and_then_the_hole():
    whole = rectangle("quad", (3, 3), 3.0, 3.0)
    mesh = SolidMesh(whole.nodes, {"quad": np.delete(whole.blocks["quad"], 4, axis=0)})  # without the cell in the middle
    edges = outline_of(mesh.nodes, mesh.blocks).edges
    assert len(edges) == 16
    for part in (edges[:12], edges[12:]):
        np.testing.assert_array_equal(part[:, 1], np.roll(part[:, 0], -1))
    centre = mesh.nodes[edges[12:, 0]].mean(axis=0)
    np.testing.assert_allclose(centre, [1.5, 0.0], atol=1e-12)


def test_stress_points_are_the_middles_of_the_edges_of_the_outline_that_is_drawn(tmp_path):
    model = cantilever(tmp_path, rectangle("triangle6", (4, 2), 2.0, 1.0))
    assert len(model.outline.edges) == len(model.stress.element) == 12
    place = model.outline.position[:, :, 0]
    np.testing.assert_allclose(place[model.outline.edges[:, 1]], place[model.outline.edges[:, [0, 2]]].mean(axis=1), atol=1e-15)
    (line,) = lines_of(model.outline)
    assert line.shape == (2 * 12 + 1, 2, 1 + model.n_f)
    np.testing.assert_array_equal(line[0], line[-1])
    assert np.hypot(*np.diff(line[:, :, 0], axis=0).T).sum() == pytest.approx(6.0)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("kind_of_tie", ["averaged", "rigid"])
def test_kinetic_energy_is_that_of_the_velocity_field_by_brute_force(kind, kind_of_tie, tmp_path):
    """T = 1/2 int rho |v|^2 dV of a random state, with the field interpolated and integrated far beyond the needed order."""
    mesh, rng = rectangle(kind, (3, 2), 2.0, 1.0, bent=0.03), np.random.default_rng(3)
    path = write_body(tmp_path, mesh, tie=kind_of_tie)
    body = discrete_body(path, BodyRecipe.read(path).file)
    free = freedom(body.mesh, body.clamped, body.ties)
    inv = build(path).invariants
    z = np.column_stack([body.mesh.nodes.ravel(), free.map.toarray()])
    r_dot, omega, theta = rng.normal(size=2), rng.normal(), rng.normal()
    zeta, v_f = np.append(1.0, 0.1 * rng.normal(size=inv.stiffness.shape[0])), rng.normal(size=inv.stiffness.shape[0])
    c, s = np.cos(theta), np.sin(theta)
    A, turn = np.array([[c, -s], [s, c]]), np.array([[0.0, -1.0], [1.0, 0.0]])
    place, rate = (z @ zeta).reshape(-1, 2), (z[:, 1:] @ v_f).reshape(-1, 2)
    nodal = r_dot + (omega * place @ turn.T + rate) @ A.T
    energy = DENSITY * WIDTH / 2 * sum(_integral_of_squares(block, nodal) for block in element_blocks(body.mesh))
    N, G, H = inv.first_moment, inv.inertia, inv.gyroscopic
    mine = inv.mass * r_dot @ r_dot / 2 + omega**2 * zeta @ G @ zeta / 2 + v_f @ G[1:, 1:] @ v_f / 2
    mine += r_dot @ A @ (omega * turn @ N @ zeta + N[:, 1:] @ v_f) + omega * zeta @ H[:, 1:] @ v_f
    np.testing.assert_allclose(mine, energy, rtol=1e-12)  # round-off


def _integral_of_squares(block, nodal: np.ndarray) -> float:
    functions = skfem.CellBasis(block.geometry, block.shapes, intorder=12)
    number = block.numbering(functions, len(nodal))
    fields = [np.asarray(functions.interpolate(number @ component)) for component in nodal.T]
    return float(sum((field**2 * functions.dx).sum() for field in fields))


def timoshenko(length: float, height: float, poisson_ratio: float) -> float:
    """Deflection of a cantilever per force at its end, L^3 / 3 E I + L / (5/6 G A)."""
    area, inertia = WIDTH * height, WIDTH * height**3 / 12
    shear = MODULUS / (2 * (1 + poisson_ratio))
    return length**3 / (3 * MODULUS * inertia) + 6 * length / (5 * shear * area)


@pytest.mark.parametrize(
    ("kind", "error"),  # of 16 x 2 cells; constant strain in triangles cannot bend, 3 % per (element / height)^2
    [("triangle", 0.7), ("triangle6", 2e-3), ("quad", 0.2), ("quad8", 2e-3), ("quad9", 2e-3)],
)
def test_static_cantilever_converges_from_below_to_the_beam(kind, error, tmp_path):
    exact = timoshenko(1.0, 0.1, 0.0)
    found = [
        compliance(cantilever(tmp_path, rectangle(kind, cells, 1.0, 0.1), BASES["static"], 0.0))[1, 1] / exact
        for cells in ((4, 1), (8, 1), (16, 2))
    ]
    assert found == sorted(found)  # more freedom is softer, as refined meshes contain the coarser ones
    assert abs(1 - found[-1]) < error
    assert found[-1] < 1 + 1e-3  # the beam's own error: Timoshenko's shear, and the warping that the clamp prevents


def test_lowest_frequencies_are_those_of_beam_and_rod(tmp_path):
    """A slender beam, so that shear and rotary inertia take less than 0.1 % of the lowest bending frequency."""
    length, height = 1.0, 0.02
    found = frequencies(cantilever(tmp_path, rectangle("quad8", (40, 1), length, height), 'kind = "eigenmodes"\ncount = 20', 0.0))
    radius, wave = height / np.sqrt(12), np.sqrt(MODULUS / DENSITY)
    bending = np.array([1.875104, 4.694091]) ** 2 * radius * wave / (2 * np.pi * length**2)
    # shear and rotary inertia, about (wave number x radius)^2 / 2 x (1 + 6 E / 5 G), are left out of the beam
    assert np.all(np.abs(found[:2] / bending - 1) < [1e-3, 4e-3])
    rod = wave / (4 * length)
    # elements of second order: relative errors of (element / wave length)^4
    assert np.abs(found - rod).min() < 1e-6 * rod


def test_rigid_tie_is_stiffer_than_averaged_one_by_the_warping_that_it_prevents(tmp_path):
    mesh = rectangle("quad8", (16, 3), 1.0, 0.1)
    averaged, rigid = (compliance(cantilever(tmp_path, mesh, BASES["static"], tie=each)) for each in ("averaged", "rigid"))
    assert np.linalg.eigvalsh(averaged - rigid).min() > -1e-12 * averaged.max()  # round-off
    # Saint-Venant: what the end section is forced to reaches about its height, 1 / 10 of the length, where the moment is small
    np.testing.assert_allclose(np.diag(rigid), np.diag(averaged), rtol=2e-2)
    np.testing.assert_allclose(rigid[1, 1], averaged[1, 1], rtol=1e-3)


@pytest.mark.parametrize("nodes", ["group", "one"])
def test_tied_point_follows_rigid_motions_wherever_it_is(nodes):
    mesh = rectangle("quad8", (6, 2), 1.0, 0.2, bent=0.01)
    members = mesh.groups["right"] if nodes == "group" else np.array([20])
    spread = sparse.diags_array(np.arange(1.0, 1 + len(members)) / np.arange(1.0, 1 + len(members)).sum())
    at = [1.3, -0.4] if nodes == "group" else None
    found = tie(mesh, members, spread, at, rigid=False)
    x, y = found.point
    # columns: unit translations, and the unit rotation about the origin; round-off over arms of a tenth
    np.testing.assert_allclose(found.rows @ rigid_motions(mesh.nodes), [[1, 0, -y], [0, 1, x], [0, 0, 1]], atol=1e-12)


@pytest.mark.parametrize("kind_of_tie", ["averaged", "rigid"])
def test_static_shapes_are_statically_exact_at_the_interface(kind_of_tie, tmp_path):
    mesh = rectangle("triangle6", (8, 2), 1.0, 0.1)
    full, static = (compliance(cantilever(tmp_path, mesh, BASES[basis], tie=kind_of_tie)) for basis in ("full", "craig-bampton"))
    np.testing.assert_allclose(static, full, rtol=1e-8, atol=1e-10 * np.abs(full).max())  # round-off times the condition 1e7


@pytest.mark.parametrize("basis", ["craig-bampton", "eigenmodes"])
@pytest.mark.parametrize("boundary", ["clamped", "free"])
def test_lanczos_and_dense_modes_give_the_same_body(basis, boundary, tmp_path, monkeypatch):
    """Stiffness, mass and derivatives by Poisson's ratio; the shapes are the same but for round-off."""
    if (basis, boundary) == ("craig-bampton", "free"):
        pytest.skip("a Craig-Bampton basis is clamped")
    path = write_body(tmp_path, rectangle("quad8", (10, 2), 1.0, 0.2), BASES[basis] + f'\nboundary = "{boundary}"')
    if boundary == "free":
        text = path.read_text()
        path.write_text(text[: text.index("[clamp]")] + text[text.index("[interface_points.hub]") :])
    models = []
    for small in (10_000, 0):
        monkeypatch.setattr(sparse_modes, "DENSE_BELOW", small)
        models.append(build(path))
    for item in ("inertia", "gyroscopic", "stiffness", "stress_operator"):
        dense, sparse = (getattr(model.invariants, item) for model in models)
        np.testing.assert_allclose(sparse, dense, atol=1e-8 * np.abs(dense).max())  # vectors turn by round-off over gaps
    for item in models[0].derivatives:
        size, largest = models[0].item(item).size, np.abs(models[0].item(item)).max()
        dense, sparse = (
            np.bincount(model.derivatives[item].entry, model.derivatives[item].value, minlength=size) for model in models
        )
        np.testing.assert_allclose(sparse, dense, atol=1e-6 * np.abs(dense).max() + 1e-12 * largest)  # some are round-off alone


@pytest.mark.parametrize("basis", BASES)
def test_model_at_other_parameters_is_that_of_a_fresh_preprocessing(basis, tmp_path):
    """Exactly by modulus, density and width; the compliance is the same whatever the shapes' own length is."""
    path = write_body(tmp_path, rectangle("quad8", (6, 2), 1.0, 0.2), BASES[basis])
    save(build(path), tmp_path / "body.h5")
    values = {"youngs_modulus": 70e9, "density": 2700.0, "width": 0.02}
    model = load(tmp_path / "body.h5")
    fresh, moved = build(path, values=values), DesignPoint(model, values).invariants()
    np.testing.assert_allclose(moved.mass, fresh.invariants.mass, rtol=1e-13)
    here = compliance_of(model, moved)
    # round-off times the condition of the stiffness
    np.testing.assert_allclose(here, compliance(fresh), rtol=1e-9, atol=1e-9 * np.abs(here).max())


def compliance_of(model, inv) -> np.ndarray:
    position, rotation = model.interfaces["tip"].here
    rows = np.vstack([position[:, 1:], rotation[1:]])
    return rows @ np.linalg.solve(inv.stiffness, rows.T)


@pytest.mark.parametrize("basis", [*BASES, "frozen"])
def test_derivatives_by_poisson_ratio_are_those_of_fresh_models(basis, tmp_path):
    """Of the compliance at the tip: by the exact derivatives of stiffness and rows, against central differences."""
    table = BASES["eigenmodes"] + '\nderivative = "frozen"' if basis == "frozen" else BASES[basis]
    path = write_body(tmp_path, rectangle("quad8", (6, 2), 1.0, 0.4), table)
    model = build(path)
    slope = compliance_complex(model, {"poisson_ratio": 0.3 + 1e-30j}).imag / 1e-30

    def difference(h: float) -> np.ndarray:
        up, down = (compliance(build(path, values={"poisson_ratio": 0.3 + s * h})) for s in (1, -1))
        return (up - down) / (2 * h)

    expected = (4 * difference(5e-5) - difference(1e-4)) / 3
    wrong = np.abs(slope - expected).max() / np.abs(expected).max()
    # fourth order in a step of 1e-4, and round-off; frozen shapes miss the derivative of what they leave out
    assert wrong > 1e-3 if basis == "frozen" else wrong < 1e-6


def compliance_complex(model, values) -> np.ndarray:
    design = DesignPoint(model, values)
    rows = np.vstack([design.interface("tip").position[0][:, 1:], design.interface("tip").rotation[0][1:]])
    return rows @ np.linalg.solve(design.value("stiffness"), rows.T)


def test_tangential_stress_of_a_pulled_and_bent_bar_is_that_of_the_closed_form(tmp_path):
    """Far from both ends, N / A and M y / I along the upper and lower side."""
    mesh = rectangle("quad8", (20, 2), 1.0, 0.1)
    model = cantilever(tmp_path, mesh, BASES["static"])
    force, moment = 3e4, 50.0
    position, rotation = model.interfaces["tip"].here
    q = np.linalg.solve(model.invariants.stiffness, force * position[0, 1:] + moment * rotation[1:])
    stress = model.invariants.stress_operator @ q
    outline = outline_of(mesh.nodes, mesh.blocks)
    middle = mesh.nodes[outline.edges[:, :2]].mean(axis=1)
    side = np.flatnonzero((np.abs(np.abs(middle[:, 1]) - 0.05) < 1e-9) & (np.abs(middle[:, 0] - 0.5) < 0.3))
    expected = force / (WIDTH * 0.1) - moment * middle[side, 1] / (WIDTH * 0.1**3 / 12)
    # the exact solution is of second order, as the elements are; the ends decay by exp(-4 x 0.2 / 0.1)
    np.testing.assert_allclose(stress[side], expected, rtol=1e-3)
    assert len(side) > 10
