"""Derivatives of spatial solids by motions of their nodes, against preprocessing of moved meshes."""

from __future__ import annotations

import numpy as np
import pytest

from preprocessing import build
from preprocessing.elements.elasticity import solid_matrices
from preprocessing.elements.solid_elements import element_blocks
from preprocessing.elements.stress import stress_rows
from preprocessing.mesh.faces import faces_of
from preprocessing.mesh.solid_mesh import SolidMesh
from tests.models.solid_bodies import SPATIAL_KINDS, box
from tests.preprocessing.test_spatial_solids import BASES, LENGTHS, body_file, responses
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.file import load, save

pytestmark = pytest.mark.usefixtures("read_here")

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
    basis = f"{BASES[basis]}\nspin_stiffening = true"
    path = body_file(folder, mesh, basis, tie=tie, more=f"\n[pressure_surfaces.top]\nnodes = {top}\n{SHAPE}{more}")
    return path, mesh


@pytest.mark.parametrize(
    ("basis", "tie"), [*((each, "averaged") for each in BASES), ("craig-bampton", "rigid"), ("free", "rigid")]
)
def test_responses_have_the_slopes_of_models_built_afresh(basis, tie, tmp_path):
    """Of all items together: mass, compliance, frequencies, pressure, stress, stiffening by spins, and moments of the
    deformed body."""
    path, _ = built(tmp_path, basis, tie)
    save(build(path), tmp_path / "body.h5")
    model = load(tmp_path / "body.h5")
    slopes = [np.imag(each) / STEP for each in responses(DesignPoint(model, {"bulge": STEP * 1j}))]
    fresh = {s: responses(DesignPoint(build(path, values={"bulge": s}), {})) for h in (2e-3, 1e-3) for s in (h, -h)}
    for k, slope in enumerate(slopes):
        expected = difference(lambda s, k=k: fresh[s][k], 2e-3)
        # fourth order in 2e-3, and the round-off of eigenvectors and factors over it
        np.testing.assert_allclose(slope, expected, atol=1e-7 * np.abs(expected).max(), err_msg=str(k))


@pytest.mark.parametrize(("basis", "parameter"), [("static", "bulge"), ("full", "bulge"), ("static", "poisson_ratio")])
def test_every_item_of_unique_shapes_has_the_derivative_of_models_built_afresh(basis, parameter, tmp_path):
    """Static shapes and nodal coordinates have no freedom in their span, so that all arrays can be compared themselves."""
    path, _ = built(tmp_path, basis, "averaged")
    model = build(path)
    number, own = model.numbers[parameter], model.nominal[parameter]
    fresh = {s: build(path, values={parameter: own + s}) for h in (2e-3, 1e-3) for s in (h, -h)}
    items = [*vars(model.invariants), "spin.stiffening", "surface_loads.top.force", "surface_loads.top.moment"]
    items += [f"interfaces.{name}.{array}" for name in ("hub", "tip") for array in ("position", "rotation")]
    for item in items:
        nominal = model.item(item)
        entry, value = model.derivatives[item].by(number) if item in model.derivatives else (np.zeros(0, int), np.zeros(0))
        rate = np.bincount(entry, value, nominal.size).reshape(nominal.shape)
        expected = difference(lambda s, item=item: fresh[s].item(item), 2e-3)
        # fourth order in 2e-3, and round-off over it of arrays that hardly change
        tolerance = 1e-8 * np.abs(expected).max() + 1e-11 * np.abs(nominal).max()
        np.testing.assert_allclose(rate, expected, atol=tolerance, err_msg=item)


def test_regions_are_those_of_the_mesh_before_it_moves(tmp_path):
    """A box keeps its nodes, so that the clamp does not jump with the variable."""
    mesh = box("tetra10", (2, 1, 1), LENGTHS)
    np.save(tmp_path / "bulge.npy", np.column_stack([mesh.nodes[:, 0] - 1.0, 0 * mesh.nodes[:, 1:]]))
    path = body_file(tmp_path, mesh, "static", more=SHAPE)
    text = path.read_text()
    path.write_text(text.replace(f"[clamp]\nnodes = {mesh.groups['left'].tolist()}", "[clamp]\nbox = [0, -1, -1, 0, 1, 1]"))
    moved = build(path, values={"bulge": 0.1})
    np.testing.assert_allclose(moved.interfaces["hub"].position[0, :, 0], [-0.1, 0, 0], atol=1e-15)
    np.testing.assert_allclose(moved.surface.position[:, 0, 0].min(), -0.1, rtol=1e-14)


@pytest.mark.parametrize(
    ("field", "message"),
    [
        (np.zeros((4, 3)), r"shape_variables.bulge: .* has shape \(4, 3\); the mesh file has 45 nodes"),
        (np.zeros((45, 3)), "moves no node of the elements"),
        (np.full((45, 3), np.nan), "other things than finite real numbers"),
        (None, "there is no file"),
        (np.array([[-40.0, 0, 0]] + 44 * [[0.0, 0, 0]]), "flat or folded over"),
    ],
)
def test_wrong_motions_are_refused_by_name(field, message, tmp_path):
    path, _ = built(tmp_path, "static")
    (tmp_path / "bulge.npy").unlink()
    if field is not None:
        np.save(tmp_path / "bulge.npy", field)
    with pytest.raises(InputError, match=message):
        build(path, values={"bulge": 0.5} if "folded" in message else {})
