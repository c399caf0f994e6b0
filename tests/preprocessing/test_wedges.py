"""The quadratic wedge: its shape functions, and its frequencies beside CalculiX and beams."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse
from scipy.linalg import eigh

from preprocessing.builders.discrete_body import lame_factors
from preprocessing.elements import solid_elements
from preprocessing.elements.elasticity import solid_matrices
from preprocessing.elements.solid_elements import element_blocks, wedge_points
from preprocessing.elements.wedge15 import ElementWedge15
from preprocessing.mesh.faces import WEDGE_EDGES
from tests.models.solid_bodies import box, cantilever, compliance

MODULUS, DENSITY = 70e3, 2.7e-9
CALCULIX = [676.592, 848.1165, 4165.035, 5312.150, 7734.893, 11562.87]
"""Hz of a curved cantilever of 8 C3D15, clamped at one end, by CalculiX 2.20 (MPa, t, mm)."""


def frequencies(kind: str, cells: tuple[int, int, int], bent: float) -> np.ndarray:
    """The six lowest in Hz of a bar of 100 x 10 x 8 mm that is clamped at one end."""
    mesh = box(kind, cells, (100.0, 10.0, 8.0), bent)
    matrices, (by_lambda, by_mu) = solid_matrices(element_blocks(mesh), len(mesh.nodes), 3), lame_factors(0.3, "space")
    stiffness = MODULUS * (by_lambda * matrices.first + by_mu * matrices.shear)
    mass = DENSITY * sparse.kron(matrices.scalar_mass, np.eye(3))
    free = np.delete(np.arange(mesh.n).reshape(-1, 3), mesh.groups["left"], axis=0).ravel()
    pencil = (matrix.toarray()[np.ix_(free, free)] for matrix in (stiffness, mass))
    return np.sqrt(eigh(*pencil, eigvals_only=True, subset_by_index=[0, 5])) / (2 * np.pi)


def test_shape_functions_are_one_at_their_node_and_have_the_gradients_of_complex_steps():
    shapes, points = ElementWedge15(), np.random.default_rng(1).uniform(0.1, 0.4, (3, 5))
    at_nodes = np.stack([shapes.lbasis(shapes.doflocs.T, i)[0] for i in range(15)])
    np.testing.assert_allclose(at_nodes, np.eye(15), atol=1e-15)  # round-off, here and below
    for i in range(15):
        stepped = [shapes.lbasis(points + 1e-30j * axis[:, None], i)[0].imag / 1e-30 for axis in np.eye(3)]
        np.testing.assert_allclose(shapes.lbasis(points, i)[1], stepped, atol=1e-14)


def test_nodes_in_the_middle_of_edges_are_numbered_as_in_mesh_files():
    """As C3D15 of Abaqus and type 26 of VTK: bottom, top, then upright edges."""
    places = ElementWedge15.doflocs
    np.testing.assert_array_equal(places[6:], [(places[a] + places[b]) / 2 for a, b in WEDGE_EDGES])


def test_frequencies_at_the_nine_points_of_c3d15_are_those_of_calculix(monkeypatch):
    """CalculiX integrates C3D15 at 9 points, which is not exact; at these points the element is the same."""
    exact = frequencies("wedge15", (4, 1, 1), 0.3)
    monkeypatch.setattr(solid_elements, "points_of", lambda _: wedge_points(2, 5))
    np.testing.assert_allclose(frequencies("wedge15", (4, 1, 1), 0.3), CALCULIX, rtol=1e-6)  # its digits, 7
    np.testing.assert_allclose(exact, CALCULIX, rtol=6e-2)  # what the points of reduced order make too soft
    assert np.all(exact > CALCULIX)


def test_frequencies_come_near_those_of_finer_hexahedra_from_above():
    """Those of 24 x 4 x 4 C3D20 by CalculiX 2.20: 658.522, 820.389, 4009.92, 4920.57 Hz."""
    fine = np.array([658.522, 820.389, 4009.919, 4920.570])
    errors = [frequencies("wedge15", cells, 0.0)[:4] / fine - 1 for cells in ((3, 1, 1), (6, 1, 1))]
    assert np.all(errors[1] > 0)
    assert np.all(errors[0] / errors[1] > 1.8)  # the clamped end is singular, so that the order is lower than 4
    assert np.all(errors[1] < 0.04)


@pytest.mark.usefixtures("read_here")
def test_static_cantilever_is_the_beam_in_pull_and_bending(tmp_path):
    """Timoshenko's beam of square section without lateral contraction, shear factor 5/6."""
    length, a, modulus = 1.0, 0.1, 210e9
    model = cantilever(tmp_path, box("wedge15", (6, 1, 1), (length, a, a)), 'kind = "static"', 0.0)
    inertia = a**4 / 12
    bending = length**3 / (3 * modulus * inertia) + length / (5 / 6 * modulus / 2 * a**2)
    expected = [length / (modulus * a**2), bending, bending, *2 * [length / (modulus * inertia)]]
    found = np.diag(compliance(model))[[0, 1, 2, 4, 5]] / expected
    np.testing.assert_allclose(found[[0, 3, 4]], 1.0, atol=1e-9)  # pull and pure bending are of second order, as the element is
    np.testing.assert_allclose(found[1:3], 1.0, atol=6e-3)  # the clamp holds the warping of shear, which one wedge across has not
