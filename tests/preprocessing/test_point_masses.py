"""Concentrated masses and rotary inertia on solids: closed forms, brute force, other programs, and models built afresh."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse
from scipy.linalg import eigh

from preprocessing import build
from preprocessing.builders.body_recipe import BodyRecipe
from preprocessing.builders.build_model import read_recipe
from preprocessing.builders.discrete_body import discrete_body
from preprocessing.foreign_files.apart import read_apart
from preprocessing.foreign_files.contents import PointMass
from preprocessing.mesh import mesh_file
from tests.models.solid_bodies import DENSITY, MODULUS, WIDTH, box, cantilever, frequencies, rectangle
from tests.models.solid_pieces import write_bar
from tests.preprocessing.test_shape_variables import SHAPE, bulge, difference
from tests.preprocessing.test_spatial_solids import BASES, LENGTHS, body_file, responses
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.file import load, save
from toolkit.reduced_model.parts import PAIRS, all_second_moments

pytestmark = pytest.mark.usefixtures("read_here")

STEP = 1e-30
FROZEN = '\nderivative = "frozen"'
JAY = (0.9, 1.1, 1.3, 0.1, -0.2, 0.15)  # of a body: the largest principal moment is below the sum of the others


@pytest.fixture
def holding(monkeypatch):
    """Mesh files hold these masses too, whatever else they hold."""

    def put(*masses: PointMass) -> None:
        sent = [each._asdict() for each in masses]
        monkeypatch.setattr(mesh_file, "read_apart", lambda *args, **named: {**read_apart(*args, **named), "masses": sent})

    return put


def tensor(inertia) -> np.ndarray:
    xx, yy, zz, xy, xz, yz = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def several(mesh) -> list[PointMass]:
    """One at a node; one beside it with inertia; one of a face, which is rigid in the file; and one that follows a mean."""
    right, top = mesh.groups["right"], mesh.groups["top"]
    corner = int(right[-1])
    return [
        PointMass(tuple(mesh.nodes[corner]), 50.0, right[-1:], source="MASS, line 1"),
        PointMass(
            tuple(mesh.nodes[top[0]] + [0.1, 0.05, 0.2]), 30.0, top[:1], tuple(0.3 * np.array(JAY)), source="CONM2, line 2"
        ),
        PointMass((2.4, 0.1, 0.3), 200.0, right, tuple(2.0 * np.array(JAY)), source="MASS, line 3"),
        PointMass((0.9, 0.1, 0.6), 70.0, top[:-1], rigid=False, source="CONM2, line 4"),
    ]


@pytest.mark.parametrize("basis", ["full", "craig-bampton", "free"])
def test_mass_centre_and_moments_are_the_sums_of_body_and_masses(basis, holding, tmp_path):
    mesh = box("hexahedron", (3, 1, 1), LENGTHS)
    masses = several(mesh)
    path = body_file(tmp_path, mesh, basis if basis == "full" else f"{BASES[basis]}{FROZEN}")
    bare = build(path).invariants
    holding(*masses)
    inv = build(path).invariants
    weights, places = np.array([each.mass for each in masses]), np.array([each.place for each in masses])
    np.testing.assert_allclose(inv.mass, DENSITY * np.prod(LENGTHS) + weights.sum(), rtol=1e-13)  # round-off, here and below
    np.testing.assert_allclose(inv.first_moment[:, 0] - bare.first_moment[:, 0], weights @ places, atol=1e-12 * inv.mass)
    spread = sum(np.trace(jay) / 2 * np.eye(3) - jay for jay in (tensor(each.inertia) for each in masses))
    moments = places.T @ (weights[:, None] * places) + spread
    found = all_second_moments(inv.second_moment)[:, :, 0, 0] - all_second_moments(bare.second_moment)[:, :, 0, 0]
    np.testing.assert_allclose(found, moments, atol=1e-12 * inv.mass)


def motion_of(mesh, mass: PointMass, field: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Displacement of a mass and its rotation, in axes of space, as its carriers move by (n_nodes, d): least squares over their arms."""
    turned = mass.carriers if len(mass.carriers) > 1 else mesh.around(int(mass.carriers[0]))
    arms = mesh.nodes[turned] - mesh.nodes[turned].mean(axis=0)
    moved = field[turned] - field[turned].mean(axis=0)
    arms, moved = (np.pad(each, ((0, 0), (0, 3 - mesh.dimension))) for each in (arms, moved))
    crosses = -np.cross(arms[:, None, :], np.eye(3)[None]).swapaxes(1, 2)  # theta -> theta x arm
    theta = np.linalg.lstsq(crosses.reshape(-1, 3), moved.ravel(), rcond=None)[0]
    arm = np.pad(np.array(mass.place) - mesh.nodes[mass.carriers].mean(axis=0), (0, 3 - mesh.dimension))
    return field[mass.carriers].mean(axis=0) + np.cross(theta, arm)[: mesh.dimension], theta


def energy_in_space(model, r_dot, omega, A, q, v) -> float:
    """Kinetic energy of a body from its invariants."""
    inv, zeta, p = model.invariants, np.append(1.0, q), np.append(0.0, v)
    N, Q, W = inv.first_moment, all_second_moments(inv.second_moment), np.cross(omega, np.eye(3)).T
    moments, mixed = np.einsum("i,abij,j->ab", zeta, Q, zeta), np.einsum("i,abij,j->ab", p, Q, zeta)
    found = inv.mass * r_dot @ r_dot / 2 + np.einsum("ca,cb,ab->", W, W, moments) / 2
    found += np.einsum("i,aaij,j->", p, Q, p) / 2 + np.einsum("ab,ab->", W, mixed)
    return float(found + r_dot @ A @ (W @ N @ zeta + N @ p))


def test_kinetic_energy_in_space_is_that_of_the_moving_masses(holding, tmp_path):
    """m |v|^2 / 2 of each, and that of its second moments: arms a + theta x a that turn with the frame."""
    mesh, rng = box("hexahedron", (3, 2, 2), LENGTHS), np.random.default_rng(3)
    masses = several(mesh)
    path = body_file(tmp_path, mesh, "full")
    state = rng.normal(size=3), rng.normal(size=3), np.linalg.qr(rng.normal(size=(3, 3)))[0]
    bare = build(path)
    q, v = 0.1 * rng.normal(size=bare.n_f), rng.normal(size=bare.n_f)
    holding(*masses)
    found = energy_in_space(build(path), *state, q, v) - energy_in_space(bare, *state, q, v)
    r_dot, omega, A = state
    free = np.setdiff1d(np.arange(len(mesh.nodes)), mesh.groups["left"])
    fields = np.zeros((2, len(mesh.nodes), 3))
    fields[:, free] = np.array([q, v]).reshape(2, -1, 3)
    energy = 0.0
    for each in masses:
        (u, theta), (u_dot, theta_dot) = (motion_of(mesh, each, field) for field in fields)
        velocity = r_dot + A @ (np.cross(omega, np.array(each.place) + u) + u_dot)
        energy += each.mass * velocity @ velocity / 2
        jay = tensor(each.inertia)
        moments, axes = np.linalg.eigh(np.trace(jay) / 2 * np.eye(3) - jay)
        for moment, axis in zip(moments, axes.T, strict=True):
            turning = np.cross(omega, axis + np.cross(theta, axis)) + np.cross(theta_dot, axis)
            energy += moment * turning @ turning / 2
    np.testing.assert_allclose(found, energy, rtol=1e-10)  # round-off of the difference


@pytest.mark.parametrize("basis", ["full", "craig-bampton"])
def test_rotary_inertia_is_that_of_six_masses_on_rigid_arms(basis, holding, tmp_path):
    mesh = box("hexahedron", (3, 1, 1), LENGTHS)
    right, middle = mesh.groups["right"], np.array([2.2, 0.1, 0.05])
    path, arm, weights = body_file(tmp_path, mesh, basis), 0.7, np.array([20.0, 30.0, 45.0])
    ends = [middle + side * arm * axis for axis in np.eye(3) for side in (1, -1)]
    holding(*(PointMass(tuple(end), weight / 2, right) for end, weight in zip(ends, np.repeat(weights, 2), strict=True)))
    six = build(path).invariants
    about = arm**2 * (weights.sum() - weights)
    holding(PointMass(tuple(middle), weights.sum(), right, (*about, 0.0, 0.0, 0.0)))
    one = build(path).invariants
    for item in ("mass", "first_moment", "second_moment", "damping"):
        expected = getattr(six, item)
        np.testing.assert_allclose(getattr(one, item), expected, atol=1e-12 * np.abs(expected).max())  # round-off


def test_a_plane_body_has_the_energy_of_its_masses(holding, tmp_path):
    """Their sum of m |v|^2 / 2 and J (omega + theta')^2 / 2; the moments of inertia about x and y do not count."""
    mesh, rng = rectangle("quad8", (4, 2), 1.0, 0.3), np.random.default_rng(5)
    right = mesh.groups["right"]
    inertia = (9.0, 8.0, 0.4, 1.0, 0.0, 0.0)
    masses = [PointMass((1.1, 0.2, 0.0), 5.0, right, inertia), PointMass((1.0, 0.15, 0.0), 3.0, right[-1:])]
    path = body_file(tmp_path, mesh, "full")
    bare = build(path)
    q, v = 0.1 * rng.normal(size=bare.n_f), rng.normal(size=bare.n_f)
    holding(*masses)
    full = build(path)
    omega, zeta, p = 0.8, np.append(1.0, q), np.append(0.0, v)

    def energy(inv):  # of a frame that turns about its origin
        G, H = inv.inertia, inv.gyroscopic
        return omega**2 * zeta @ G @ zeta / 2 + omega * zeta @ H @ p + p @ G @ p / 2

    free = np.setdiff1d(np.arange(len(mesh.nodes)), mesh.groups["left"])
    fields = np.zeros((2, len(mesh.nodes), 2))
    fields[:, free] = np.array([q, v]).reshape(2, -1, 2)
    expected, jay = 0.0, (inertia[2], 0.0)
    for each, moment in zip([mass._replace(place=mass.place[:2]) for mass in masses], jay, strict=True):
        (u, theta), (u_dot, theta_dot) = (motion_of(mesh, each, field) for field in fields)
        x, y = np.array(each.place) + u
        velocity = omega * np.array([-y, x]) + u_dot
        expected += each.mass * velocity @ velocity / 2
        turned, turning = 1 + theta[2] ** 2, omega**2  # arms e + theta x e are longer by second order
        expected += moment * (turned * turning + 2 * omega * theta_dot[2] + theta_dot[2] ** 2) / 2
    np.testing.assert_allclose(energy(full.invariants) - energy(bare.invariants), expected, rtol=1e-10)  # round-off
    np.testing.assert_allclose(full.invariants.mass, DENSITY * WIDTH * 0.3 + 8.0, rtol=1e-13)


def beam_with_tip(length, bending, per_length, mass, arm, inertia, count=30) -> np.ndarray:
    """Lowest frequencies in Hz of a clamped Euler-Bernoulli beam with a mass beyond its tip, by cubic elements."""
    h = length / count
    K = bending / h**3 * np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2], [-12, -6 * h, 12, -6 * h]])
    K = np.vstack([K, bending / h**3 * np.array([6 * h, 2 * h**2, -6 * h, 4 * h**2])])
    M = per_length * h / 420 * np.array([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h**2, 13 * h, -3 * h**2]])
    M = np.vstack([M, per_length * h / 420 * np.array([[54, 13 * h, 156, -22 * h], [-13 * h, -3 * h**2, -22 * h, 4 * h**2]])])
    stiffness, inertias = np.zeros((2, 2 * count + 2, 2 * count + 2))
    for k in range(count):
        own = slice(2 * k, 2 * k + 4)
        stiffness[own, own] += K
        inertias[own, own] += M
    inertias[-2:, -2:] += [[mass, mass * arm], [mass * arm, inertia + mass * arm**2]]
    return np.sqrt(eigh(stiffness[2:, 2:], inertias[2:, 2:], eigvals_only=True)[:3]) / (2 * np.pi)


def test_a_heavy_tip_slows_a_cantilever_as_it_does_a_beam(holding, tmp_path):
    """Both bendings of a slender bar, with a tip mass of three bars on an arm, and its rotary inertia."""
    length, b, c, arm = 1.0, 0.02, 0.03, 0.1
    mesh = box("hexahedron20", (16, 1, 1), (length, b, c))
    weight = DENSITY * b * c * length
    inertia = (0.03 * weight, 0.02 * weight, 0.04 * weight, 0.0, 0.0, 0.0)
    holding(PointMass((length + arm, 0.0, 0.0), 3 * weight, mesh.groups["right"], inertia))
    basis = f'kind = "craig-bampton"\ncount = 8{FROZEN}'
    found = frequencies(cantilever(tmp_path, mesh, basis, poisson_ratio=0.0, tie="rigid"))
    sections = ((MODULUS * c * b**3 / 12, inertia[2]), (MODULUS * b * c**3 / 12, inertia[1]))
    beams = [beam_with_tip(length, bending, weight / length, 3 * weight, arm, jay) for bending, jay in sections]
    expected = np.sort(np.concatenate(beams))[:4]
    for each in expected:  # torsion lies among them; shear and rotary inertia take up to 0.3 % of the second modes
        assert np.abs(found - each).min() < 3e-3 * each
    np.testing.assert_allclose(found[:2], expected[:2], rtol=5e-4)


SPUN = "spin_stiffening = true"
SLOPES = [
    ("density", "craig-bampton", "averaged"),
    ("density", "free", "rigid"),
    ("bulge", "craig-bampton", "rigid"),
    ("bulge", "free", "averaged"),
]


def solid_with_masses(folder, holding, basis, tie="averaged"):
    """A small bar with all kinds of masses."""
    mesh = box("hexahedron", (3, 1, 1), LENGTHS, bent=0.01)
    np.save(folder / "bulge.npy", bulge(mesh.nodes))
    holding(*several(mesh))
    top = f"\n[pressure_surfaces.top]\nnodes = {mesh.groups['top'].tolist()}\n"
    return body_file(folder, mesh, f"{BASES.get(basis, basis)}\n{SPUN}", tie=tie, more=top + SHAPE)


@pytest.mark.parametrize(("parameter", "basis", "tie"), SLOPES)
def test_responses_have_the_slopes_of_models_built_afresh(parameter, basis, tie, holding, tmp_path):
    """Of mass, compliance, frequencies, pressure, stress, stiffening by spins, and moments of the deformed body."""
    path = solid_with_masses(tmp_path, holding, basis, tie)
    save(build(path), tmp_path / "body.h5")
    model = load(tmp_path / "body.h5")
    own, h = model.nominal[parameter], 2e-3 * (DENSITY if parameter == "density" else 1.0)
    slopes = [np.imag(each) / STEP for each in responses(DesignPoint(model, {parameter: own + STEP * 1j}))]
    path.write_text(path.read_text().replace(SPUN, SPUN + FROZEN))  # which are the same shapes at their own design
    fresh = {s: responses(DesignPoint(build(path, values={parameter: own + s}), {})) for k in (h, h / 2) for s in (k, -k)}
    for k, slope in enumerate(slopes):
        expected = difference(lambda s, k=k: fresh[s][k], h)
        # fourth order in 2e-3, and the round-off of eigenvectors and factors over it
        tolerance = 1e-7 * np.abs(expected).max() + 1e-9 / h * np.abs(fresh[h][k]).max()
        np.testing.assert_allclose(slope, expected, atol=tolerance, err_msg=str(k))


@pytest.mark.parametrize("basis", ["full", "static"])
def test_another_density_is_exact_where_the_shapes_do_not_follow_it(basis, holding, tmp_path):
    path, density = solid_with_masses(tmp_path, holding, basis), {"density": 2700.0}
    moved, fresh = (responses(each) for each in (DesignPoint(build(path), density), DesignPoint(build(path, values=density), {})))
    for one, other in zip(moved, fresh, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9 * np.abs(other).max())  # round-off times the condition of the stiffness


def test_shapes_that_follow_the_density_are_told_at_the_nominal_one_alone(holding, tmp_path):
    """Modes turn where the masses become lighter beside the rest; frozen ones do not."""
    path = solid_with_masses(tmp_path, holding, "craig-bampton")
    with pytest.raises(InputError, match=r"'density' .* is fixed at 7800"):
        DesignPoint(build(path), {"density": 2700.0}).value("stiffness")
    path.write_text(path.read_text().replace(SPUN, SPUN + FROZEN))
    model = build(path)
    moved = DesignPoint(model, {"density": 2700.0}).invariants()
    np.testing.assert_allclose(moved.mass - 350.0, (model.invariants.mass - 350.0) * 2700.0 / DENSITY, rtol=1e-12)  # round-off


@pytest.mark.parametrize(("parameter", "basis"), [("density", "craig-bampton"), ("width", "free"), ("width", "full")])
def test_plane_bodies_have_the_slopes_of_models_built_afresh(parameter, basis, holding, tmp_path):
    """Of mass, the sum of all 1 / omega^2, compliance, and what spins stiffen."""
    mesh = rectangle("quad8", (4, 1), 1.0, 0.3)
    right = mesh.groups["right"]
    holding(
        PointMass((1.1, 0.2, 0.0), 60.0, right, (0.0, 0.0, 4.0, 0.0, 0.0, 0.0)), PointMass((1.0, 0.15, 0.0), 30.0, right[-1:])
    )
    path = body_file(tmp_path, mesh, f"{BASES[basis]}\n{SPUN}")

    def told(design: DesignPoint) -> list:
        K, G, point = (design.value("stiffness"), design.value("inertia"), design.interface("tip"))
        rows = np.vstack([point.position[0][:, 1:], point.rotation[0][1:]])
        spin = np.trace(np.linalg.solve(K, design.value("spin.stiffening")[0]))
        eigen = np.trace(np.linalg.solve(K, G[1:, 1:]))
        return [design.value("mass"), eigen, rows @ np.linalg.solve(K, rows.T), spin, G[0, 0]]

    model = build(path)
    own = model.nominal[parameter]
    slopes = [np.imag(each) / STEP for each in told(DesignPoint(model, {parameter: own + STEP * 1j}))]
    path.write_text(path.read_text().replace(SPUN, SPUN + FROZEN * (basis != "full")))
    fresh = {s: told(DesignPoint(build(path, values={parameter: own * (1 + s)}), {})) for k in (2e-3, 1e-3) for s in (k, -k)}
    for k, slope in enumerate(slopes):
        expected = difference(lambda s, k=k: fresh[s][k], 2e-3)
        # fourth order in 2e-3, and the round-off of eigenvectors and factors over it
        tolerance = 1e-7 * np.abs(expected).max() + 1e-10 / 2e-3 * np.abs(fresh[2e-3][k]).max()
        np.testing.assert_allclose(own * slope, expected, atol=tolerance, err_msg=str(k))


CALCULIX = {  # 2.20, C3D20 with *MASS of 60 kg: at a corner node of the free end, and at the reference node of a *RIGID BODY of that end
    "node": [20.60161, 33.96722, 228.2850, 338.6907, 525.5806],
    "rigid body": [18.24530, 30.15475, 198.6714, 314.6801, 592.8703],
}


@pytest.mark.parametrize("carrier", CALCULIX)
def test_frequencies_are_those_of_calculix(carrier, holding, tmp_path):
    mesh = box("hexahedron20", (4, 1, 1), (1.0, 0.1, 0.06))
    right = mesh.groups["right"]
    if carrier == "node":
        corner = right[np.isclose(mesh.nodes[right], [1.0, 0.05, 0.03]).all(axis=1)]
        holding(PointMass((1.0, 0.05, 0.03), 60.0, corner))
    else:
        holding(PointMass((1.1, 0.03, 0.02), 60.0, right))
    model = cantilever(tmp_path, mesh, BASES["eigenmodes"] + FROZEN, tie="averaged" if carrier == "node" else "rigid")
    np.testing.assert_allclose(frequencies(model)[:5], CALCULIX[carrier], rtol=1e-6)  # the digits that it writes


def test_damping_of_the_mass_holds_for_concentrated_masses_too(holding, tmp_path):
    path = solid_with_masses(tmp_path, holding, "full")
    path.write_text(path.read_text().replace("[damping]\nstiffness = 1e-5", "[damping]\nmass = 0.7"))
    inv = build(path).invariants
    inertia = inv.second_moment[:3].sum(axis=0)[1:, 1:]
    np.testing.assert_allclose(inv.damping, 0.7 * inertia, atol=1e-12 * inertia.max())  # round-off


def test_lengths_are_those_of_the_scaled_mesh(holding, tmp_path):
    """Of place and radius of gyration; the mass is taken as it is, which a remark tells."""
    mesh = box("hexahedron", (2, 1, 1), LENGTHS)
    path, one, said = body_file(tmp_path, mesh, "static"), PointMass((2.2, 0.1, 0.0), 5.0, mesh.groups["right"], JAY), []
    holding(one)
    plain = build(path).invariants
    path.write_text(path.read_text().replace('file = "body.vtu"', 'file = "body.vtu"\nscale = 0.1'))
    scaled = read_recipe(path).build(said.append).invariants
    assert any("5 in all, count in the unit of body.toml" in each for each in said)
    holding()
    bare = [build(path).invariants]
    path.write_text(path.read_text().replace("scale = 0.1", "scale = 1.0"))
    bare.append(build(path).invariants)
    ours, theirs = (
        scaled.second_moment[:, 0, 0] - bare[0].second_moment[:, 0, 0],
        plain.second_moment[:, 0, 0] - bare[1].second_moment[:, 0, 0],
    )
    np.testing.assert_allclose(ours, 0.01 * theirs, atol=1e-10 * np.abs(theirs).max())  # round-off of the differences


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mass": -1.0}, r"a mass \(MASS, line 1\) that is negative"),
        ({"place": (0.0, np.nan, 0.0)}, "no finite number"),
        ({"carriers": np.zeros(0, int)}, "on a node that no element"),
        ({"inertia": (3.0, 1.0, 1.0, 0.0, 0.0, 0.0)}, "rotary inertia of MASS, line 1 is that of no body"),
        ({"inertia": (1.0, 1.0, 1.0, 0.0, 2.0, 0.0)}, "rotary inertia of MASS, line 1 is that of no body"),
        ({"carriers": np.array([8, 9])}, "mass of MASS, line 1 cannot turn with its nodes: .* on one line"),
    ],
)
def test_what_is_no_mass_of_a_body_is_refused_by_its_source(change, message, holding, tmp_path):
    mesh = box("hexahedron", (2, 1, 1), LENGTHS)
    holding(PointMass((2.0, 0.25, 0.2), 5.0, mesh.groups["right"], source="MASS, line 1")._replace(**change))
    with pytest.raises(InputError, match=message):
        build(body_file(tmp_path, mesh, "static"))


def test_two_nodes_carry_a_mass_in_their_middle(holding, tmp_path):
    """They tell no rotation in space, and none is needed."""
    mesh = box("hexahedron", (2, 1, 1), LENGTHS)
    pair = mesh.groups["right"][:2]
    path = body_file(tmp_path, mesh, "static")
    bare = build(path).invariants
    holding(PointMass(tuple(mesh.nodes[pair].mean(axis=0)), 5.0, pair))
    inv = build(path).invariants
    np.testing.assert_allclose(inv.first_moment[:, 0] - bare.first_moment[:, 0], 5.0 * mesh.nodes[pair].mean(axis=0), atol=1e-10)


def test_what_other_programs_may_do_otherwise_is_told(holding, tmp_path):
    mesh, said = box("hexahedron", (2, 1, 1), LENGTHS), []
    right = mesh.groups["right"]
    masses = [
        PointMass((2.1, 0.0, 0.0), 5.0, right, source="MASS, line 1"),
        PointMass((2.1, 0.0, 0.0), 5.0, right[:1], source="CONM2, line 2"),
    ]
    path = body_file(tmp_path, mesh, "static")
    holding(*masses)
    read_recipe(path).build(said.append)
    assert "MASS, line 1 is on a rigid body in the mesh file; its nodes stay elastic here" in said[0]
    assert "CONM2, line 2 has an offset or a rotary inertia at a node" in said[1]
    said.clear()
    path.write_text(path.read_text().replace('tie = "averaged"', 'tie = "rigid"'))
    holding(masses[0], PointMass((2.0, 0.0, 0.0), 5.0, right, rigid=False, source="MASS, line 3"))
    read_recipe(path).build(said.append)
    assert [text.partition("MASS, line 3 ")[2] for text in said] == ["moves with the mean of 4 nodes, which all count alike."]


@pytest.fixture
def bar(tmp_path):
    """A bar in two pieces, and its mesh."""
    return write_bar(tmp_path, 2, kind="hexahedron", lengths=(1.0, 0.2, 0.2)), box("hexahedron", (4, 1, 1), (1.0, 0.2, 0.2))


def test_every_piece_has_its_own_masses_once(bar, holding):
    """Those on the face between two pieces too: the sum is that of the body on one frame."""
    path, mesh = bar
    middle, near = (np.flatnonzero(np.isclose(mesh.nodes[:, 0], x)) for x in (0.5, 0.75))
    masses = [
        PointMass((0.5, 0.0, 0.3), 3.0, middle, (0.1, 0.1, 0.1, 0.0, 0.0, 0.0)),
        PointMass((0.75, 0.1, 0.1), 2.0, near[-1:]),
        PointMass((1.2, 0.0, 0.0), 4.0, mesh.groups["right"]),
    ]
    bare = build(path).invariants
    holding(*masses)
    inv = build(path).invariants
    np.testing.assert_allclose(inv.mass - bare.mass, 9.0, rtol=1e-11)
    weights, places = np.array([3.0, 2.0, 4.0]), np.array([each.place for each in masses])
    np.testing.assert_allclose(inv.first_moment[:, 0] - bare.first_moment[:, 0], weights @ places, atol=1e-11)
    found = (inv.second_moment - bare.second_moment)[:, 0, 0]
    expected = places.T @ (weights[:, None] * places) + 0.05 * np.eye(3)
    np.testing.assert_allclose(found, [expected[pair] for pair in PAIRS], atol=1e-11)


def test_a_mass_across_pieces_is_refused(bar, holding):
    path, mesh = bar
    across = np.flatnonzero((mesh.nodes[:, 0] > 0.2) & (mesh.nodes[:, 0] < 0.8))
    holding(PointMass((0.5, 0.0, 0.0), 3.0, across, source="CONM2, line 7"))
    with pytest.raises(InputError, match="mass of CONM2, line 7 is carried by nodes of several pieces"):
        build(path)


def test_finished_matrices_hold_the_masses_of_the_mesh_already(holding, tmp_path):
    """They are in the mass matrix once, and do not follow the density."""
    mesh = box("hexahedron", (2, 1, 1), LENGTHS)
    corner = mesh.groups["right"][-1:]
    mass = PointMass(tuple(mesh.nodes[corner[0]]), 50.0, corner)
    path, said = body_file(tmp_path, mesh, "full", tie="rigid"), []
    holding(mass)
    expected, body = build(path), discrete_body(path, BodyRecipe.read(path).file)
    matrices = body.parts.at(body.values)
    for name in ("mass", "stiffness"):
        sparse.save_npz(tmp_path / f"{name}.npz", matrices.coordinates.of_nodes(getattr(matrices, name)))
    path.write_text(path.read_text() + '\n[matrices]\nmass = "mass.npz"\nstiffness = "stiffness.npz"\n')
    found = read_recipe(path).build(said.append)
    assert said == ["body.toml: the mass matrix is taken to hold the concentrated masses of the mesh file already."]
    for density in (DENSITY, 2700.0):
        ours, theirs = (DesignPoint(model, {"density": density}).invariants() for model in (found, expected))
        np.testing.assert_allclose(ours.mass, density * np.prod(LENGTHS) + 50.0, rtol=1e-12)  # round-off, here and below
        np.testing.assert_allclose(ours.second_moment, theirs.second_moment, atol=1e-12 * np.abs(theirs.second_moment).max())
    for other, message in (
        (mass._replace(mass=5000.0), "does not hold the concentrated masses"),
        (mass._replace(place=(2.5, 0.0, 0.0)), "with an offset, a rotary inertia or several nodes"),
    ):
        holding(other)
        with pytest.raises(InputError, match=message):
            build(path)


def test_many_nodes_of_a_rigid_body_are_told_by_some_and_many_of_a_mean_are_refused(holding, tmp_path):
    mesh = box("hexahedron", (1, 24, 24), (1.0, 1.0, 1.0))
    path, right = body_file(tmp_path, mesh), mesh.groups["right"]
    holding(PointMass((1.5, 0.0, 0.0), 5.0, right))
    (found,) = mesh_file.read_mesh(path.parent / "body.vtu").masses
    assert len(found.carriers) == 200
    np.testing.assert_allclose(np.ptp(mesh.nodes[found.carriers], axis=0), [0.0, 1.0, 1.0])
    holding(PointMass((1.5, 0.0, 0.0), 5.0, right, rigid=False, source="CONM2, line 3"))
    with pytest.raises(InputError, match=r"CONM2, line 3\) that follows the mean of 625 nodes; 500 are the most"):
        mesh_file.read_mesh(path.parent / "body.vtu")
