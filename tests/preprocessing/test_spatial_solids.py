"""Spatial solids and their reduction: closed forms, brute-force quadrature, and bases against the full body."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import skfem
from scipy.spatial.transform import Rotation

from preprocessing import build
from preprocessing.builders.body_recipe import BodyRecipe
from preprocessing.builders.discrete_body import discrete_body, lame_factors
from preprocessing.builders.named_mesh import spread_of
from preprocessing.elements.elasticity import solid_matrices
from preprocessing.elements.solid_elements import element_blocks, wedge_points
from preprocessing.elements.stress import COMPONENTS, stress_rows
from preprocessing.mesh.faces import faces_of
from preprocessing.mesh.solid_mesh import SolidMesh, rigid_motions
from preprocessing.reduction import sparse_modes
from preprocessing.reduction.solid_systems import dissected
from preprocessing.reduction.ties import freedom, tie
from tests.models.solid_bodies import (
    DENSITY,
    MODULUS,
    SPATIAL_KINDS,
    box,
    cantilever,
    compliance,
    frequencies,
    moves,
    write_body,
)
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.file import load, save
from toolkit.reduced_model.parts import all_second_moments

pytestmark = pytest.mark.usefixtures("read_here")

BASES = {
    "full": 'kind = "full"',
    "craig-bampton": 'kind = "craig-bampton"\ncount = 4',
    "static": 'kind = "static"',
    "eigenmodes": 'kind = "eigenmodes"\ncount = 8',
    "free": 'kind = "eigenmodes"\ncount = 8\nboundary = "free"',
}
LENGTHS = (2.0, 0.5, 0.4)
TOP = "\n[pressure_surfaces.top]\nbox = [0.0, -0.25, 0.2, 2.0, 0.25, 0.2]\n"


def body_file(folder, mesh, basis="full", **kwargs):
    """body.toml of `write_body`; a free body has no clamp."""
    path = write_body(folder, mesh, BASES.get(basis, basis), **kwargs)
    if 'boundary = "free"' in path.read_text():
        text = path.read_text()
        path.write_text(text[: text.index("[clamp]")] + text[text.index("[interface_points.hub]") :])
    return path


@pytest.mark.parametrize("kind", SPATIAL_KINDS)
def test_mass_centre_and_inertia_are_those_of_a_box(kind, tmp_path):
    inv = cantilever(tmp_path, box(kind, (2, 1, 2), LENGTHS)).invariants
    a, b, c = LENGTHS
    mass = DENSITY * a * b * c
    moments = all_second_moments(inv.second_moment)[:, :, 0, 0]
    np.testing.assert_allclose(inv.mass, mass, rtol=1e-13)  # round-off, here and below
    np.testing.assert_allclose(inv.first_moment[:, 0], [mass * a / 2, 0, 0], atol=1e-13 * mass)
    np.testing.assert_allclose(moments, mass * np.diag([a**2 / 3, b**2 / 12, c**2 / 12]), atol=1e-13 * mass)


@pytest.mark.parametrize("kind", SPATIAL_KINDS)
def test_bent_elements_resist_no_rigid_motion_and_reproduce_constant_stress(kind):
    """The patch test, with the stress at the nodes of the surface."""
    mesh = box(kind, (2, 2, 1), LENGTHS, bent=0.02)
    blocks, surface = element_blocks(mesh), faces_of(mesh.nodes, mesh.blocks)
    matrices, (by_lambda, by_mu) = solid_matrices(blocks, len(mesh.nodes), 3), lame_factors(0.3, "space")
    stiffness = by_lambda * matrices.first + by_mu * matrices.shear
    assert np.abs(stiffness @ rigid_motions(mesh.nodes)).max() < 1e-13 * abs(stiffness).max()  # round-off, here and below
    values = np.linalg.eigvalsh(stiffness.toarray())
    assert np.count_nonzero(values < 1e-10 * values[-1]) == 6
    gradient = np.array([[0.3, -0.5, 0.1], [0.9, 0.2, -0.3], [0.4, 0.6, -0.7]])
    strain = (gradient + gradient.T) / 2
    sigma = by_lambda * np.trace(strain) * np.eye(3) + 2 * by_mu * strain
    first, shear = stress_rows(None, blocks, surface)
    found = ((by_lambda * first + by_mu * shear) @ (mesh.nodes @ gradient.T).ravel()).reshape(-1, 6)
    np.testing.assert_allclose(found, np.tile([sigma[pair] for pair in COMPONENTS], (len(surface.points), 1)), atol=1e-12)
    # without forces inside, those of the constant stress are its tractions: K u = int N sigma n dA
    forces = (stiffness @ (mesh.nodes @ gradient.T).ravel()).reshape(-1, 3)
    # on curved elements the stiffness is integrated to about 1e-7 only, as its integrand is no polynomial
    tolerance = 1e-12 if kind in ("tetra", "tetra10") else 1e-5
    np.testing.assert_allclose(forces, surface.normals() @ sigma, atol=tolerance)


@pytest.mark.parametrize("kind", SPATIAL_KINDS)
def test_surface_is_closed_and_encloses_the_volume_also_of_mirrored_elements(kind):
    mesh = box(kind, (2, 2, 1), LENGTHS, bent=0.02)
    for sign in (1, -1):
        nodes = mesh.nodes * [1, 1, sign]
        surface = faces_of(nodes, mesh.blocks)
        volume = sum(block.functions().dx.sum() for block in element_blocks(SolidMesh(nodes, mesh.blocks)))
        normals = surface.normals()
        np.testing.assert_allclose(normals.sum(axis=0), 0, atol=1e-14)  # round-off, here and below
        np.testing.assert_allclose((normals * nodes).sum() / 3, volume, rtol=1e-13)
        corners = nodes[surface.points][surface.triangles]
        drawn = np.linalg.det(corners).sum() / 6
        np.testing.assert_allclose(drawn, volume, rtol=2e-2)  # the triangles are flat
        assert drawn > 0


@pytest.mark.parametrize("kind", SPATIAL_KINDS)
def test_points_of_integration_integrate_products_on_curved_elements_exactly(kind):
    """The mass matrix against that by points of a higher order."""
    mesh = box(kind, (1, 1, 1), LENGTHS, bent=0.05)
    (block,) = element_blocks(mesh)
    mine = solid_matrices([block], len(mesh.nodes), 3).scalar_mass.toarray()
    functions = better_functions(block)
    number = block.numbering(functions, len(mesh.nodes))
    better = number.T @ skfem.BilinearForm(lambda u, v, _: u * v).assemble(functions) @ number
    np.testing.assert_allclose(mine, better.toarray(), atol=1e-13 * np.abs(mine).max())  # round-off, and digits of the points


def better_functions(block):
    """Shape functions at points of a higher order; those of wedges are products of a triangle's and a line's."""
    if "wedge" in block.kind:
        return skfem.CellBasis(block.geometry, block.shapes, quadrature=wedge_points(13, 14))
    return skfem.CellBasis(block.geometry, block.shapes, intorder=9 if "tetra" in block.kind else 14)


def test_points_of_wedges_integrate_monomials_of_the_unit_wedge_exactly():
    x, w = wedge_points(5, 5)
    expected = [1 / 2, 1 / 6, 1 / 4, 1 / 48]  # 1, x, z, x y z on the unit wedge
    np.testing.assert_allclose([w.sum(), w @ x[0], w @ x[2], w @ (x[0] * x[1] * x[2])], expected, rtol=1e-13)  # round-off


@pytest.mark.parametrize("kind", SPATIAL_KINDS)
@pytest.mark.parametrize("kind_of_tie", ["averaged", "rigid"])
def test_kinetic_energy_is_that_of_the_velocity_field_by_brute_force(kind, kind_of_tie, tmp_path):
    """T = 1/2 int rho |v|^2 dV of a random state, v = r' + A (omega x u + u'), integrated beyond the needed order."""
    mesh, rng = box(kind, (2, 1, 1), LENGTHS, bent=0.02), np.random.default_rng(3)
    path = write_body(tmp_path, mesh, tie=kind_of_tie)
    body, model = discrete_body(path, BodyRecipe.read(path).file), build(path)
    free, inv = freedom(body.mesh, body.clamped, body.ties), model.invariants
    z = np.column_stack([body.mesh.nodes.ravel(), free.map.toarray()])
    r_dot, omega, A = rng.normal(size=3), rng.normal(size=3), Rotation.random(rng=rng).as_matrix()
    zeta, v_f = np.append(1.0, 0.1 * rng.normal(size=model.n_f)), rng.normal(size=model.n_f)
    place, rate = (z @ zeta).reshape(-1, 3), (z[:, 1:] @ v_f).reshape(-1, 3)
    nodal = r_dot + (np.cross(omega, place) + rate) @ A.T
    energy = DENSITY / 2 * sum(_integral_of_squares(block, nodal) for block in element_blocks(body.mesh))
    # with p = [0, v_f], and W the matrix of omega x: u' + omega x u = p + W zeta in the axes a, b of Q
    N, Q, p = inv.first_moment, all_second_moments(inv.second_moment), np.append(0.0, v_f)
    W = np.cross(omega, np.eye(3)).T
    moments = np.einsum("i,abij,j->ab", zeta, Q, zeta)
    mixed = np.einsum("i,abij,j->ab", p, Q, zeta)
    mine = inv.mass * r_dot @ r_dot / 2 + np.einsum("ca,cb,ab->", W, W, moments) / 2
    mine += np.einsum("i,aaij,j->", p, Q, p) / 2 + np.einsum("ab,ab->", W, mixed)
    mine += r_dot @ A @ (W @ N @ zeta + N @ p)
    np.testing.assert_allclose(mine, energy, rtol=1e-12)  # round-off


def _integral_of_squares(block, nodal):
    functions = better_functions(block)
    number = block.numbering(functions, len(nodal))
    fields = [np.asarray(functions.interpolate(number @ component)) for component in nodal.T]
    return float(sum((field**2 * functions.dx).sum() for field in fields))


@pytest.mark.parametrize("nodes", ["group", "one"])
def test_tied_point_follows_rigid_motions_wherever_it_is(nodes):
    mesh = box("tetra10", (3, 1, 1), LENGTHS, bent=0.02)
    members = mesh.groups["right"] if nodes == "group" else np.array([20])
    spread = spread_of(mesh, faces_of(mesh.nodes, mesh.blocks), members)
    found = tie(mesh, members, spread, [1.3, -0.4, 0.2] if nodes == "group" else None, rigid=False)
    x, y, z = found.point
    turned = [[0, z, -y], [-z, 0, x], [y, -x, 0]]  # of the point, by unit rotations about x, y and z through the origin
    expected = np.block([[np.eye(3), np.array(turned)], [np.zeros((3, 3)), np.eye(3)]])
    np.testing.assert_allclose(found.rows @ rigid_motions(mesh.nodes), expected, atol=1e-12)  # round-off over arms of a tenth


@pytest.mark.parametrize("kind", ["tetra10", "hexahedron20", "wedge", "wedge15"])
def test_mean_over_a_face_weighs_by_area_on_uneven_meshes(kind):
    """Centre and second moments of a face are those of its area, wherever the nodes crowd."""
    mesh = box(kind, (1, 3, 2), (1.0, 1.0, 1.0))
    crowded = mesh.nodes.copy()
    crowded[:, 1] = np.interp(crowded[:, 1], np.linspace(-0.5, 0.5, 4), np.array([-0.5, -0.46, -0.34, 0.5]))
    members = mesh.groups["right"]
    spread = spread_of(mesh, faces_of(crowded, mesh.blocks), members).toarray()
    np.testing.assert_allclose(spread.sum(axis=1) @ crowded[members], [1.0, 0.0, 0.0], atol=1e-14)  # round-off
    second = crowded[members].T @ spread @ crowded[members]
    np.testing.assert_allclose(second[1:, 1:], np.eye(2) / 12, atol=1e-14)


@pytest.mark.parametrize("kind", ["tetra10", "hexahedron20", "wedge"])
def test_mean_over_whole_elements_weighs_by_volume(kind):
    """Centre and second moments are those of the box that the elements fill; with a step along a motion they have its rate."""
    mesh = box(kind, (3, 2, 1), (3.0, 1.0, 1.0), bent=0.0)
    members = np.flatnonzero(mesh.nodes[:, 0] >= 2 - 1e-9)
    faces = faces_of(mesh.nodes, mesh.blocks)
    spread = spread_of(mesh, faces, members).toarray()
    places = mesh.nodes[members] - [2.5, 0.0, 0.0]
    np.testing.assert_allclose(spread.sum(axis=1) @ places, 0, atol=1e-14)  # round-off
    np.testing.assert_allclose(places.T @ spread @ places, np.eye(3) / 12, atol=1e-14)
    motion = mesh.nodes[:, [0]] ** 2 * [0.0, 0.1, 0.0] * mesh.nodes[:, [1]]  # wider towards the end
    step = spread_of(replace(mesh, nodes=mesh.nodes + 1e-30j * motion), faces, members).toarray().imag / 1e-30
    ahead, back = (spread_of(replace(mesh, nodes=mesh.nodes + h * motion), faces, members).toarray() for h in (1e-5, -1e-5))
    np.testing.assert_allclose(step, (ahead - back) / 2e-5, atol=1e-9)  # differences: round-off over the step


@pytest.mark.parametrize("kind_of_tie", ["averaged", "rigid"])
def test_static_shapes_are_statically_exact_at_the_interface(kind_of_tie, tmp_path):
    mesh = box("hexahedron20", (3, 1, 1), LENGTHS)
    full, static = (compliance(cantilever(tmp_path, mesh, BASES[basis], tie=kind_of_tie)) for basis in ("full", "craig-bampton"))
    assert full.shape == (6, 6)
    np.testing.assert_allclose(static, full, rtol=1e-8, atol=1e-10 * np.abs(full).max())  # round-off times the condition 1e5


def test_static_cantilever_is_the_beam_in_pull_bending_and_torsion(tmp_path):
    """Timoshenko's beam of square section without lateral contraction; torsion constant 0.140577 a^4, shear factor 5/6."""
    length, a = 1.0, 0.1
    model = cantilever(tmp_path, box("hexahedron20", (8, 2, 2), (length, a, a)), BASES["static"], 0.0)
    area, inertia, shear = a**2, a**4 / 12, MODULUS / 2
    bending = length**3 / (3 * MODULUS * inertia) + length / (5 / 6 * shear * area)
    twist = length / (shear * 0.140577 * a**4)
    expected = [length / (MODULUS * area), bending, bending, twist, *2 * [length / (MODULUS * inertia)]]
    # pull and bending are exact polynomials of the elements' order; the clamp holds the warping of torsion and shear near it, a / L
    np.testing.assert_allclose(np.diag(compliance(model)) / expected, 1.0, atol=4e-2)
    np.testing.assert_allclose((np.diag(compliance(model)) / expected)[[0, 1, 2, 4, 5]], 1.0, atol=1e-3)


def test_lowest_frequencies_are_those_of_beam_and_rod(tmp_path):
    """A slender beam of two heights; shear and rotary inertia take less than 0.2 % of the lowest bending frequencies."""
    length, height, width = 1.0, 0.03, 0.02
    basis = 'kind = "eigenmodes"\ncount = 16'
    found = frequencies(cantilever(tmp_path, box("hexahedron20", (20, 1, 1), (length, width, height)), basis, 0.0))
    wave = np.sqrt(MODULUS / DENSITY)
    bending = 1.875104**2 * np.array([width, height]) / np.sqrt(12) * wave / (2 * np.pi * length**2)
    np.testing.assert_allclose(found[:2], bending, rtol=2e-3)
    rod = wave / (4 * length)
    assert np.abs(found - rod).min() < 1e-6 * rod  # elements of second order: (element / wave length)^4


def test_frequencies_of_a_free_body_are_those_of_a_free_beam_and_its_frame_has_no_momentum(tmp_path):
    path = body_file(tmp_path, box("hexahedron20", (16, 1, 1), (1.0, 0.02, 0.03)), "free", poisson_ratio=0.0)
    model = build(path)
    inv, wave = model.invariants, np.sqrt(MODULUS / DENSITY)
    bending = 4.730041**2 * np.array([0.02, 0.03]) / np.sqrt(12) * wave / (2 * np.pi)
    np.testing.assert_allclose(frequencies(model)[:2], bending, rtol=4e-3)  # shear and rotary inertia
    size = np.sqrt(inv.mass * np.diag(inv.second_moment[:3].sum(axis=0))[1:].max())
    np.testing.assert_allclose(inv.first_moment[:, 1:], 0, atol=1e-9 * size)  # round-off, here and below
    Q = all_second_moments(inv.second_moment)
    for a, b in ((1, 2), (2, 0), (0, 1)):
        np.testing.assert_allclose(Q[a, b, 0, 1:] - Q[b, a, 0, 1:], 0, atol=1e-9 * size)


@pytest.mark.parametrize("basis", ["craig-bampton", "eigenmodes", "free"])
def test_lanczos_and_dense_modes_give_the_same_body(basis, tmp_path, monkeypatch):
    path = body_file(tmp_path, box("hexahedron20", (4, 1, 1), (1.0, 0.2, 0.3)), basis)
    models = []
    for small in (10_000, 0):
        monkeypatch.setattr(sparse_modes, "DENSE_BELOW", small)
        models.append(build(path))
    for item in ("second_moment", "stiffness", "stress_operator"):
        dense, sparse = (getattr(model.invariants, item) for model in models)
        np.testing.assert_allclose(sparse, dense, atol=1e-7 * np.abs(dense).max())  # vectors turn by round-off over gaps


def test_dissection_is_an_order_of_all_coordinates_with_fewer_entries():
    from scipy.sparse.linalg import splu

    mesh = box("tetra", (9, 9, 9), (1.0, 1.0, 1.0))
    matrix = solid_matrices(element_blocks(mesh), len(mesh.nodes), 3).scalar_mass
    order = dissected(matrix, mesh.nodes)
    np.testing.assert_array_equal(np.sort(order), np.arange(len(mesh.nodes)))
    symmetric = {"permc_spec": "NATURAL", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    entries = [splu(each.tocsc(), **symmetric).nnz for each in (matrix, matrix[order][:, order])]
    assert entries[1] < 0.7 * entries[0]


@pytest.mark.parametrize("basis", [*BASES])
def test_model_at_other_parameters_is_that_of_a_fresh_preprocessing(basis, tmp_path):
    """Exactly by modulus and density; the compliance and the pressure's work are the same whatever the shapes' own length is."""
    path = body_file(tmp_path, box("hexahedron20", (3, 1, 1), LENGTHS), basis, more=TOP)
    save(build(path), tmp_path / "body.h5")
    values = {"youngs_modulus": 70e9, "density": 2700.0}
    model = load(tmp_path / "body.h5")
    assert set(model.affine) == {"mass", "first_moment", "second_moment", "stiffness", "damping", "stress_operator"}
    fresh, moved = build(path, values=values), DesignPoint(model, values)
    for one, other in zip(responses(DesignPoint(fresh, {})), responses(moved), strict=True):
        # round-off times the condition of the stiffness
        np.testing.assert_allclose(other, one, rtol=1e-9, atol=1e-9 * np.abs(one).max())


def responses(design):
    """What does not depend on the choice of the shapes in their span: a load of 1e8 Pa on the top side, and its effects."""
    K, tip = design.value("stiffness"), design.interface("tip")
    rows = moves(tip)
    found = [design.value("mass"), rows @ np.linalg.solve(K, rows.T)]
    inertia = design.value("second_moment")[:3].sum(axis=0)[1:, 1:]
    found.append(np.trace(np.linalg.solve(K, inertia)))  # sum of 1 / omega^2
    force, moment = (design.value(f"surface_loads.top.{name}") for name in ("force", "moment"))
    work = np.einsum("aaj->j", moment)[1:]
    q = np.linalg.solve(K, work)
    found += [force, moment[:, :, 0], work @ q]
    found.append(design.value("stress_operator")[5] @ q)
    if design.model.spin is not None:
        found.append(np.array([np.trace(np.linalg.solve(K, each)) for each in design.value("spin.stiffening")]))
    N, Q, zeta = design.value("first_moment"), design.value("second_moment"), np.append(1.0, 1e8 * q)
    return [*found, N @ zeta, np.einsum("i,pij,j->p", zeta, Q, zeta), tip.position[0] @ zeta, moment @ zeta]


def test_von_mises_stress_of_a_pulled_and_bent_bar_is_that_of_the_closed_form(tmp_path):
    """Far from both ends, |N / A + M_y z / I_y - M_z y / I_z| at all points of the surface."""
    length, b, c = 1.0, 0.12, 0.08
    model = cantilever(tmp_path, box("hexahedron20", (14, 2, 2), (length, b, c)), BASES["static"])
    load = np.array([3e4, 0, 0, 0, 70.0, 110.0])
    q = np.linalg.solve(model.invariants.stiffness, moves(model.interfaces["tip"]).T @ load)
    xx, yy, zz, yz, xz, xy = (model.invariants.stress_operator @ q).T
    mises = np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * (yz**2 + xz**2 + xy**2))
    x, y, z = model.surface.position[:, :, 0].T
    expected = load[0] / (b * c) + load[4] * z / (b * c**3 / 12) - load[5] * y / (c * b**3 / 12)
    middle = np.abs(x - 0.55) < 0.11
    assert np.count_nonzero(middle) > 40
    # the exact solution is of second order, as the elements are; the clamped end decays by about exp(-3 x 0.44 / 0.12)
    np.testing.assert_allclose(xx[middle], expected[middle], atol=1e-3 * expected.max())
    np.testing.assert_allclose(mises[middle], np.abs(expected[middle]), atol=1e-3 * expected.max())


def test_pressure_bends_a_cantilever_as_a_line_load_does(tmp_path):
    """w = p b L^4 / (8 E I) + p b L^2 / (2 5/6 G A) at the tip, without lateral contraction."""
    length, b, c = 1.0, 0.1, 0.06
    more = f"\n[pressure_surfaces.top]\nbox = [0, {-b}, {c / 2}, {length}, {b}, {c / 2}]\n"
    model = cantilever(tmp_path, box("hexahedron20", (10, 1, 1), (length, b, c)), BASES["craig-bampton"], 0.0, more=more)
    load = model.surface_loads["top"]
    q = np.linalg.solve(model.invariants.stiffness, np.einsum("aaj->j", load.moment)[1:])  # virtual work of the undeformed body
    inertia, shear = b * c**3 / 12, MODULUS / 2
    expected = b * length**4 / (8 * MODULUS * inertia) + b * length**2 / (2 * 5 / 6 * shear * b * c)
    # the beam has no compression across; four modes bring the curvature that the tip's constraint modes lack
    np.testing.assert_allclose(-(moves(model.interfaces["tip"]) @ q)[2], expected, rtol=5e-3)
