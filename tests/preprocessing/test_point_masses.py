"""Concentrated masses and rotary inertia on solids: closed forms, brute force, other programs, and models built afresh."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh

from preprocessing import build
from preprocessing.foreign_files.apart import read_apart
from preprocessing.foreign_files.contents import PointMass
from preprocessing.mesh import mesh_file
from preprocessing.mesh.solid_mesh import rigid_motions
from preprocessing.recipes.build_model import read_recipe
from tests.models.solid_bodies import DENSITY, MODULUS, WIDTH, box, cantilever, frequencies, rectangle, write_body
from tests.models.solid_pieces import write_bar
from tests.preprocessing.test_shape_variables import SHAPE, bulge, difference
from tests.preprocessing.test_spatial_solids import BASES, LENGTHS, body_file, responses
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.file import load, save
from toolkit.reduced_model.spatial_model import PAIRS, all_second_moments

pytestmark = pytest.mark.usefixtures("read_here")

STEP = 1e-30
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
        PointMass((0.9, 0.1, 0.6), 70.0, top[::2], rigid=False, source="CONM2, line 4"),
    ]


@pytest.mark.parametrize("basis", [*BASES])
def test_mass_centre_and_moments_are_the_sums_of_body_and_masses(basis, holding, tmp_path):
    mesh = box("hexahedron20", (3, 1, 1), LENGTHS)
    masses = several(mesh)
    path = body_file(tmp_path, mesh, basis)
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
    mesh = box("hexahedron20", (3, 1, 1), LENGTHS)
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
    basis = 'kind = "craig-bampton"\ncount = 8'
    found = frequencies(cantilever(tmp_path, mesh, basis, poisson_ratio=0.0, tie="rigid"))
    sections = ((MODULUS * c * b**3 / 12, inertia[2]), (MODULUS * b * c**3 / 12, inertia[1]))
    beams = [beam_with_tip(length, bending, weight / length, 3 * weight, arm, jay) for bending, jay in sections]
    expected = np.sort(np.concatenate(beams))[:4]
    for each in expected:  # torsion lies among them; shear and rotary inertia take up to 0.3 % of the second modes
        assert np.abs(found - each).min() < 3e-3 * each
    np.testing.assert_allclose(found[:2], expected[:2], rtol=5e-4)
