"""How a spin stiffens a body: elements under known stress, a bar's closed form, complex steps of every parameter, fresh models."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from preprocessing import build
from preprocessing.builders.discrete_body import lame_factors
from preprocessing.builders.frame_file import frame_elements
from preprocessing.builders.frame_recipe import FrameRecipe
from preprocessing.elements.elasticity import StressedSolid
from preprocessing.elements.solid_elements import element_blocks
from preprocessing.mesh.solid_mesh import rigid_motions
from tests.models.solid_bodies import DENSITY, KINDS, SPATIAL_KINDS, WIDTH, box, cantilever, rectangle, write_body
from tests.preprocessing.test_frame_models import FRAME
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.conversion import converted_model
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.file import load, save
from toolkit.reduced_model.parts import PAIRS, SPIN_STIFFENING, stiffness_of_spin

pytestmark = pytest.mark.usefixtures("read_here")

STEP = 1e-30
ASKED = "spin_stiffening = true"
PLANE = """units = "m-kg-s"
dimension = 2
clamp = ["A"]
nodes = { A = [0.1, 0.05], B = [0.7, 0.1], C = [0.8, 0.6] }
beams = [{ from = "A", to = "B", section = "s", elements = 3 }, { from = "B", to = "C", section = "t", elements = 2 }]
[sections]
s = { kind = "rectangle", thickness = 0.03, width = 0.1, material = "m" }
t = { kind = "rectangle", thickness = 0.02, width = 0.1, material = "m" }
[materials]
m = { youngs_modulus = 2e9, density = 1000.0 }
[interface_points]
tip = { node = "C" }
"""
BAR = """units = "m-kg-s"
dimension = {dimension}
clamp = ["A"]
nodes = {{ A = {start}, B = {end} }}
beams = [{{ from = "A", to = "B", section = "s", elements = 4 }}]
sections = {{ s = {{ kind = "rectangle", thickness = 0.03, width = 0.1, material = "m" }} }}
materials = {{ m = {{ youngs_modulus = 2e9, {ratio} density = 1000.0 }} }}
interface_points = {{ tip = {{ node = "B" }} }}
[basis]
spin_stiffening = true
"""


@pytest.mark.parametrize("kind", [*KINDS, *SPATIAL_KINDS])
def test_uniform_stress_works_on_a_rotation_as_on_greens_strain(kind):
    """Under a stress sigma the quadratic part of Green's strain of a small rotation about z has the energy (sigma_xx + sigma_yy) V / 2."""
    mesh = rectangle(kind, (3, 2), 1.0, 0.4, 0.02) if kind in KINDS else box(kind, (2, 1, 1), (1.0, 0.4, 0.3), 0.02)
    strain = np.array([[0.3, 0.1, -0.2], [0.1, -0.4, 0.5], [-0.2, 0.5, 0.7]])[: mesh.dimension, : mesh.dimension]
    lame = lame_factors(0.3, "plane-stress" if mesh.dimension == 2 else "space")
    solid = StressedSolid(element_blocks(mesh), lame)
    volume = sum(functions.dx.sum() for block in solid.blocks for _, functions in block.functions_in_parts())
    stress = lame[0] * np.trace(strain) * np.eye(mesh.dimension) + 2 * lame[1] * strain
    K = solid.stiffness((mesh.nodes @ strain).ravel())
    turn = rigid_motions(mesh.nodes)[:, -1]
    assert turn @ (K @ turn) == pytest.approx((stress[0, 0] + stress[1, 1]) * volume, rel=1e-12)
    assert abs(K - K.T).max() < 1e-15 * abs(K).max() * 10
    assert np.abs(K @ rigid_motions(mesh.nodes)[:, : mesh.dimension]).max() < 1e-12 * abs(K).max()


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.6, 0.8), (0.48, 0.6, 0.64)])
def test_a_bar_has_the_tension_of_its_spin(direction, tmp_path):
    """N = rho A omega^2 (L^2 - x^2) / 2, here on straight lines that turn about the root by theta: theta^2 rho A omega^2 L^3 / 3."""
    length, d = 2.0, len(direction)
    text = BAR.format(
        dimension=d, start=[0.0] * d, end=[length * x for x in direction], ratio="poisson_ratio = 0.3," if d == 3 else ""
    )
    (tmp_path / "frame.toml").write_text(text)
    model = build(tmp_path / "frame.toml")
    file = FrameRecipe.read(tmp_path / "frame.toml").file
    elements = frame_elements(file, model.nominal).element
    u = np.zeros(elements.coordinates.n)  # the exact stretch of the axis, which linear elements have at their nodes
    x = elements.nodes @ direction
    stretch = 1000.0 / (2 * 2e9) * (length**2 * x - x**3 / 3)
    places = elements.per_node * np.arange(5)[:, None] + np.arange(d)
    u[places] = stretch[:, None] * direction
    K = elements.geometric_stiffness(model.nominal, u)
    turned, across = np.zeros_like(u), np.array([-direction[1], direction[0], 0.0][:d]) / np.hypot(*direction[:2])
    turned[places] = x[:, None] * across
    rotation = (np.cross(direction, across) if d == 3 else np.ones(1))[None]
    turned[elements.per_node * np.arange(5)[:, None] + np.arange(d, elements.per_node)] = rotation
    mass = 1000.0 * 0.03 * 0.1
    assert turned @ (K @ turned) == pytest.approx(mass * length**3 / 3, rel=1e-12)
    assert model.spin is not None
    axis = np.cross(direction, across) if d == 3 else np.array([0.0, 0.0, 1.0])
    free = np.delete(np.arange(elements.coordinates.nodal), np.arange(elements.per_node))
    own = np.real(K.toarray())[np.ix_(free, free)]
    found = stiffness_of_spin(model.spin.stiffening, axis)
    np.testing.assert_allclose(found, own, atol=1e-10 * np.abs(own).max())  # what stretching a thin bar leaves of its digits


@pytest.mark.parametrize("text", [PLANE, FRAME], ids=["plane", "space"])
def test_all_derivatives_of_beams_are_the_complex_step(text, tmp_path):
    """Through a dense complex solution of everything: loads, stiffness and geometric stiffness."""
    path = tmp_path / "frame.toml"
    path.write_text(text + f"\n[basis]\n{ASKED}\n")
    model = build(path)
    file = FrameRecipe.read(path).file
    assert model.spin is not None
    size = model.spin.stiffening.size
    changing = 0
    for number, parameter in list(enumerate(model.parameters))[:: 1 if text == PLANE else 3]:
        stepped = {**model.nominal, parameter: model.nominal[parameter] + STEP * 1j}
        expected = np.imag(dense_stiffening(frame_elements(file, stepped), stepped)) / STEP
        entry, value = model.derivatives[SPIN_STIFFENING].by(number)
        found = np.bincount(entry, value, size).reshape(expected.shape)
        scale = max(np.abs(expected).max(), np.abs(model.spin.stiffening).max() / max(abs(model.nominal[parameter]), 1e-3))
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10 * scale, err_msg=parameter)
        changing += bool(len(entry))
    assert changing > 8


def dense_stiffening(body: Any, values: Any) -> np.ndarray:
    """S of all nodal coordinates but those of the first node, from dense matrices, real or complex."""
    element, matrices = body.element, body.parts.at(values)
    coordinates, d = matrices.coordinates, matrices.coordinates.space.dimension
    at = np.zeros((coordinates.nodal, 1), complex)
    at.reshape(len(body.nodes), -1)[:, :d] = body.nodes
    xi = coordinates.undeformed(at)[:, 0]
    m = {pair: each.toarray() for pair, each in zip(coordinates.space.pairs, matrices.m, strict=True)}
    free = slice(element.per_node, coordinates.nodal)
    found = []
    for i, j in ((0, 0),) if d == 2 else PAIRS:
        if d == 2:
            load = (m[0, 0] + m[1, 1]) @ xi
        elif i == j:
            load = sum(m[a, a] for a in range(3) if a != i) @ xi
        else:
            load = -(m[i, j] + m[i, j].T) @ xi / 2
        u = np.zeros(coordinates.n, complex)
        u[free] = np.linalg.solve(matrices.stiffness.toarray()[free, free], load[free])
        found.append(element.geometric_stiffness(values, u).toarray()[free, free])
    return np.array(found)


@pytest.mark.parametrize("basis", ['kind = "full"', 'kind = "craig-bampton"\ncount = 3', 'kind = "eigenmodes"\ncount = 4'])
def test_plane_solids_at_other_numbers_are_models_built_afresh(basis, tmp_path):
    """Density, width and modulus exactly; Poisson's ratio by its derivative, against central differences of order h^4."""
    path = write_body(tmp_path, rectangle("quad8", (4, 1), 1.0, 0.2), f"{basis}\n{ASKED}")
    save(build(path), tmp_path / "body.h5")
    model = load(tmp_path / "body.h5")
    values = {"density": 2 * DENSITY, "width": 0.7 * WIDTH, "youngs_modulus": 1e9}
    fresh = build(path, values=values)
    assert fresh.spin is not None
    assert softest(DesignPoint(model, values)) == pytest.approx(softest(DesignPoint(fresh, {})), rel=1e-9)  # modes found twice
    slope = np.imag(softest(DesignPoint(model, {"poisson_ratio": 0.3 + STEP * 1j}))) / STEP
    near = {h: softest(DesignPoint(build(path, values={"poisson_ratio": 0.3 + h}), {})) for h in (1e-3, -1e-3, 5e-4, -5e-4)}
    coarse, fine = ((near[h] - near[-h]) / (2 * h) for h in (1e-3, 5e-4))
    assert slope == pytest.approx((4 * fine - coarse) / 3, rel=2e-7)


def softest(design: DesignPoint) -> Any:
    """tr(K^-1 S), which does not depend on the choice of shapes in their span; complex-safe."""
    return np.trace(np.linalg.solve(design.value("stiffness"), design.value(SPIN_STIFFENING)[0]))


def test_a_floating_body_does_not_mind_where_its_axes_begin(tmp_path):
    """Its inertia balances the centrifugal forces, whatever part of them belongs to the place of the axis."""
    basis = f'kind = "eigenmodes"\nboundary = "free"\ncount = 3\n{ASKED}'
    sizes = []
    for shift in (0.0, 3.0):
        mesh = rectangle("quad9", (6, 1), 1.0, 0.1)
        path = write_body(tmp_path, replace(mesh, nodes=mesh.nodes + np.array([shift, 0.0])), basis)
        text = path.read_text()
        start, end = text.index("[clamp]"), text.index("[interface_points.hub]")
        path.write_text(text[:start] + text[end:])
        model = build(path)
        assert model.spin is not None
        sizes.append(np.linalg.eigvalsh(np.linalg.solve(model.invariants.stiffness, model.spin.stiffening[0])))
    np.testing.assert_allclose(sizes[0], sizes[1], rtol=1e-8)
    assert (sizes[0] > 0).all()


def test_files_convert_and_those_without_it_still_load(tmp_path):
    model = cantilever(tmp_path, rectangle("quad8", (4, 1), 1.0, 0.2), f'kind = "craig-bampton"\ncount = 2\n{ASKED}')
    save(model, tmp_path / "body.h5")
    other = converted_model(load(tmp_path / "body.h5"), "mm-t-s")
    save(other, tmp_path / "mm.h5")
    assert softest(DesignPoint(other, {})) == pytest.approx(softest(DesignPoint(model, {})), rel=1e-12)  # seconds in both
    moved = {"density": 2 * other.nominal["density"]}
    assert softest(DesignPoint(other, moved)) == pytest.approx(2 * softest(DesignPoint(model, {})), rel=1e-12)
    save(cantilever(tmp_path, rectangle("quad8", (4, 1), 1.0, 0.2), 'kind = "static"'), tmp_path / "plain.h5")
    assert load(tmp_path / "plain.h5").spin is None


def test_what_has_no_such_stiffening_is_refused(tmp_path):
    path = write_body(
        tmp_path, rectangle("quad", (4, 1), 1.0, 0.2), f'kind = "craig-bampton"\ncount = 2\nchord = ["hub", "tip"]\n{ASKED}'
    )
    with pytest.raises(InputError, match="spin_stiffening is that of a body whose frame is clamped"):
        build(path)
