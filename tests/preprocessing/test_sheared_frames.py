"""Beams that shear deforms, in the plane and in space: Timoshenko's deflections and vibrations, and derivatives by complex steps."""

from __future__ import annotations

import numpy as np
import pytest

import ffrf
from preprocessing.builders.build_model import build
from preprocessing.builders.frame_file import frame_space
from preprocessing.builders.frame_recipe import FrameRecipe
from preprocessing.reduction.chosen_basis import undeformed
from preprocessing.reduction.invariants import contract
from tests.models.timoshenko import cantilever_frequency
from toolkit.analyses.sensitivity.preparation import prepare, solve
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.file import save
from toolkit.scene.resolution import loaded
from toolkit.validity.bodies.corotational_beams import compare_with_corotational, compared
from toolkit.validity.bodies.known_chain import chain

E, NU, T, B = 2e11, 0.3, 0.1, 0.05
SHEAR = 5 / 6 / (2 * (1 + NU))
"""kappa G / E."""
FRAME = """units = "m-kg-s"
shear = true
dimension = {dimension}
clamp = ["A"]
nodes = {{ A = {A}, B = {B} }}
beams = [{{ from = "A", to = "B", section = "s", elements = {elements} }}]
sections.s = {{ kind = "rectangle", thickness = 0.1, width = 0.05, material = "m" }}
materials.m = {{ youngs_modulus = 2e11, density = 7800.0, poisson_ratio = 0.3 }}
interface_points.B = {{ node = "B" }}
"""
SCENE = """units = "m-kg-s"
[points]
B = { body = "beam", interface = "B" }
[bodies]
beam = { type = "flexible", model = "frame.h5", frame = "grounded" }
[design]
t = "bodies.beam.thickness_s"
[loads]
F = { type = "point-force", body = "beam", point = "B", force = [0.0, 1000.0] }
[responses]
down = { type = "displacement", body = "beam", point = "B", component = "y" }
stress = { type = "max-stress", body = "beam" }
f1 = { type = "frequency", number = 1 }
f2 = { type = "frequency", number = 2 }
f4 = { type = "frequency", number = 4 }
"""


def written(folder, dimension=2, elements=3, ends=([0.0, 0.0, 0.0], [1.0, 0.0, 0.0])):
    one, other = (list(end[:dimension]) for end in ends)
    path = folder / "frame.toml"
    path.write_text(FRAME.format(dimension=dimension, A=one, B=other, elements=elements))
    return path


@pytest.fixture(scope="module")
def cantilever(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sheared")
    save(build(written(folder, elements=16)), folder / "frame.h5")
    (folder / "scene.toml").write_text(SCENE)
    scene = ffrf.read_scene(folder / "scene.toml")
    return scene, ffrf.compile(scene, variables=["t"]).statics(gradients=True)


def test_vibrations_and_their_derivatives_are_timoshenkos(cantilever):
    """A length of 10 thicknesses, whose fourth vibration (f4; number 3 is its stretch) elements without shear make 9 % too fast."""
    _, run = cantilever
    for name, near, off in (
        ("f1", 81.16, 2e-5),
        ("f2", 486.4, 3e-4),
        ("f4", 1279.4, 2e-3),
    ):  # of second order in the length of an element
        exact = [cantilever_frequency(near, E, 7800.0, t, SHEAR) for t in (T, T + 1e-4, T - 1e-4)]
        assert run.values[name] == pytest.approx(exact[0], rel=off)
        assert run.gradients[name]["t"] == pytest.approx((exact[1] - exact[2]) / 2e-4, rel=4 * off)
    assert run.verdict.trusted


def test_deflection_stress_and_derivatives_by_a_force_at_the_end_are_exact(cantilever):
    """P L^3 / 3 E I + P L / (kappa G A), and P L t / 2 I of bending, whatever shear does."""
    _, run = cantilever
    second, area = B * T**3 / 12, B * T
    bent, sheared = 1000 / (3 * E * second), 1000 / (SHEAR * E * area)
    assert run.values["down"] == pytest.approx(bent + sheared, rel=1e-8)
    assert run.gradients["down"]["t"] == pytest.approx(-(3 * bent + sheared) / T, rel=1e-8)
    assert run.values["stress"] == pytest.approx(1000 * T / 2 / second, rel=1e-8)
    assert run.gradients["stress"]["t"] == pytest.approx(-2 * 1000 * T / 2 / second / T, rel=1e-8)


def test_elements_behind_a_model_know_their_shear(cantilever):
    found = chain(loaded(cantilever[0]), "beam").made_of
    np.testing.assert_allclose(found.bending_stiffness[:, 0], E * B * T**3 / 12, rtol=1e-12)
    np.testing.assert_allclose(found.shear_stiffness, SHEAR * E * B * T, rtol=1e-12)


def test_elements_that_turn_are_sheared_as_those_of_the_body(tmp_path):
    """Under the same forces they are the scene with a frame to every element, and the linear stress at the clamp is M t / 2 I."""
    save(build(written(tmp_path, elements=6, ends=([0.0, 0.0], [1.0, 0.0]))), tmp_path / "frame.h5")
    bent = SCENE.replace("[0.0, 1000.0]", "[0.0, 4e6]")
    (tmp_path / "scene.toml").write_text(bent)
    (tmp_path / "turning.toml").write_text(bent.replace('frame = "grounded"', 'frame = "grounded", frames = 6'))
    solution = solve(prepare(ffrf.read_scene(tmp_path / "scene.toml")), "static")
    found = compare_with_corotational(solution, "beam")
    turning = ffrf.compile(ffrf.read_scene(tmp_path / "turning.toml")).statics()
    behind, tip = chain(solution.system.scene, "beam"), 4  # the named nodes are the first ones
    u = behind.displacements(np.real(solution.q[-1:]))[0]
    turned = compared(behind, solution.system.scene.model("frame.h5", "stress").stress, u, u).corotational
    assert u[tip] > 2 * turning.values["down"]  # it bends far
    assert turned[tip] == pytest.approx(turning.values["down"], rel=1e-8)  # both solvers stop at 1e-10 of the size
    assert found.stress == pytest.approx(4e6 * T / 2 / (B * T**3 / 12), rel=1e-8)


def test_both_planes_of_a_beam_in_space_are_sheared(tmp_path):
    """One element is exact: K u = P for the deflection of its end along y, over the thickness, and along z, over the width."""
    found = np.linalg.inv(build(written(tmp_path, 3, elements=1)).invariants.stiffness)
    for axis, h, b in ((1, T, B), (2, B, T)):
        exact = 1 / (3 * E * b * h**3 / 12) + 1 / (SHEAR * E * b * h)
        assert found[axis, axis] == pytest.approx(exact, rel=1e-10)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("name", ["thickness_s", "width_s", "poisson_ratio_m", "x_B"])
def test_derivatives_are_those_of_complex_steps(name, dimension, tmp_path):
    path = written(tmp_path, dimension, 4 - dimension, ends=([0.1, 0.3, 0.2], [0.7, 1.1, 0.4]))
    model, space = build(path), frame_space(FrameRecipe.read(path).file)
    stepped = {**space.values, name: space.values[name] + 1e-30j}
    at = space.discretise(stepped)
    xi = undeformed(at.nodes)
    z = np.column_stack([xi, np.eye(len(xi))[:, 3 * dimension - 3 :]])
    exact, found = contract(at.parts.at(stepped), z), DesignPoint(model, {name: stepped[name]})
    for item in ("mass", "first_moment", "stiffness", "stress_operator", "inertia" if dimension == 2 else "second_moment"):
        rate, size = np.imag(getattr(exact, item)), np.abs(getattr(exact, item)).max()
        told = np.imag(found.value(item))
        np.testing.assert_allclose(told, rate.reshape(told.shape), atol=1e-11 * max(np.abs(rate).max(), 1e-30 * size))


@pytest.mark.parametrize(
    ("one", "other", "message"),
    [
        (
            ", poisson_ratio = 0.3",
            "",
            r"materials\.m\.poisson_ratio: this key is missing; add it, because shear deforms the beams",
        ),
        ("shear = true", "", r"materials\.m\.poisson_ratio: beams in the plane .* do not twist"),
        ('material = "m"', 'material = "m", shear_factor = 1.5', r"shear_factor: input should be less than or equal to 1"),
    ],
)
def test_what_shear_needs_is_asked_for(one, other, message, tmp_path):
    path = written(tmp_path)
    path.write_text(path.read_text().replace(one, other))
    with pytest.raises(InputError, match=message):
        build(path)


def test_a_tube_needs_its_shear_factor(tmp_path):
    path = written(tmp_path, 3)
    tube = 'kind = "tube", diameter = 0.1, wall = 0.01'
    path.write_text(path.read_text().replace('kind = "rectangle", thickness = 0.1, width = 0.05', tube))
    with pytest.raises(InputError, match=r"sections\.s\.shear_factor: this key is missing; a tube has no factor"):
        build(path)
    path.write_text(path.read_text().replace(tube, tube + ", shear_factor = 0.53").replace("shear = true", "shear = false"))
    with pytest.raises(InputError, match=r"shear does not deform these beams; write shear = true"):
        build(path)
