"""Derivatives of spatial solids by motions of their nodes, against preprocessing of moved meshes."""

from __future__ import annotations

import numpy as np
import pytest

from preprocessing.solids.build_body import build_body
from preprocessing.solids.elasticity import solid_matrices
from preprocessing.solids.elements import element_blocks
from preprocessing.solids.faces import faces_of
from preprocessing.solids.solid_mesh import SolidMesh
from preprocessing.solids.solid_stress import stress_rows
from tests.solid_bodies import SPATIAL_KINDS, box
from tests.test_spatial_solids import BASES, LENGTHS, body_file, responses
from toolkit.design_point import DesignPoint
from toolkit.reduced_model_file import load, save

STEP = 1e-30
SHAPE = '\n[shape_variables.bulge]\nfield = "bulge.npy"\n'


def bulge(nodes: np.ndarray) -> np.ndarray:
    """A motion that stretches, bends and thickens."""
    x, y, z = nodes.T
    return np.column_stack([0.3 * x + 0.2 * y * z, 0.4 * y * (1 + x**2), 0.1 * x**2 + 0.5 * z * np.cos(x)])


def difference(value, h: float) -> np.ndarray:
    """Central difference with Richardson's extrapolation, of order h^4."""
    central = [(value(s) - value(-s)) / (2 * s) for s in (h, h / 2)]
    return (4 * central[1] - central[0]) / 3


@pytest.mark.parametrize("kind", SPATIAL_KINDS)
def test_rates_of_all_matrices_are_those_of_moved_meshes(kind):
    mesh = box(kind, (2, 1, 1), LENGTHS, bent=0.02)
    motion = bulge(mesh.nodes)

    def matrices(h, motion=None):
        nodes = mesh.nodes + h * bulge(mesh.nodes)
        blocks, surface = element_blocks(SolidMesh(nodes, mesh.blocks)), faces_of(nodes, mesh.blocks)
        found = solid_matrices(blocks, len(nodes), 3, motion)
        return [found.scalar_mass, found.first, found.shear, *stress_rows(None, blocks, surface, motion)]

    moved = {h: matrices(h) for h in (1e-3, -1e-3, 5e-4, -5e-4)}
    for k, rate in enumerate(matrices(0.0, motion)):
        expected = difference(lambda h, k=k: moved[h][k].toarray(), 1e-3)
        # fourth order in 1e-3, and round-off over it
        np.testing.assert_allclose(rate.toarray(), expected, atol=2e-10 * np.abs(expected).max())


def built(folder, basis, tie="averaged", more=""):
    mesh = box("tetra10", (2, 1, 1), LENGTHS, bent=0.01)
    np.save(folder / "bulge.npy", bulge(mesh.nodes))
    top = mesh.groups["top"].tolist()
    path = body_file(folder, mesh, basis, tie=tie, more=f"\n[pressure_surfaces.top]\nnodes = {top}\n{SHAPE}{more}")
    return path, mesh


@pytest.mark.parametrize(
    ("basis", "tie"), [*((each, "averaged") for each in BASES), ("craig-bampton", "rigid"), ("free", "rigid")]
)
def test_responses_have_the_slopes_of_models_built_afresh(basis, tie, tmp_path):
    """Of all items together: mass, compliance, frequencies, pressure, stress, and moments of the deformed body."""
    path, _ = built(tmp_path, basis, tie)
    save(build_body(path), tmp_path / "body.h5")
    model = load(tmp_path / "body.h5")
    slopes = [np.imag(each) / STEP for each in responses(DesignPoint(model, {"bulge": STEP * 1j}))]
    fresh = {s: responses(DesignPoint(build_body(path, {"bulge": s}), {})) for h in (2e-3, 1e-3) for s in (h, -h)}
    for k, slope in enumerate(slopes):
        expected = difference(lambda s, k=k: fresh[s][k], 2e-3)
        # fourth order in 2e-3, and the round-off of eigenvectors and factors over it
        np.testing.assert_allclose(slope, expected, atol=1e-7 * np.abs(expected).max(), err_msg=str(k))
