"""Planar beams have the rotary inertia of their section: by Rayleigh's beam, the same beam in space, complex steps, and a pendulum."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import pytest
import scipy

import ffrf
from preprocessing.builders.build_model import build
from preprocessing.builders.frame_file import frame_space
from preprocessing.builders.frame_recipe import FrameRecipe, polygon_beam
from preprocessing.elements.beams import PlanarBeam
from preprocessing.elements.section import Section, distribute
from preprocessing.reduction.assembly import assemble
from preprocessing.reduction.chosen_basis import undeformed
from preprocessing.reduction.invariants import contract
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.file import save

BENT = """units = "m-kg-s"
dimension = {dimension}
clamp = ["A"]
nodes = {{ A = {A}, B = {B} }}
beams = [{{ from = "A", to = "B", section = "s", elements = 1 }}]
sections.s = {{ kind = "rectangle", thickness = 0.2, width = 0.05, material = "m" }}
materials.m = {{ youngs_modulus = 2e11, density = 7800.0{ratio} }}
interface_points.B = {{ node = "B" }}
"""
PENDULUM = """units = "m-kg-s"
[points]
A = { body = "b", interface = "A" }
[bodies]
b = { type = "flexible", model = "bar.h5" }
[joints]
A = { type = "revolute", bodies = ["b", "ground"], point = "A" }
[loads]
g = { type = "gravity", acceleration = [0.0, -9.81] }
[design]
t = "bodies.b.thickness"
[responses]
f = { type = "frequency", number = 1 }
"""


def planar(tmp_path):
    path = tmp_path / "frame.toml"
    path.write_text(BENT.format(dimension=2, A=[0.1, 0.3], B=[0.7, 1.1], ratio=""))
    return build(path)


@pytest.mark.parametrize("mode", [1, 4])
def test_a_pinned_beam_vibrates_as_rayleighs_does(mode):
    """omega^2 = (E I / rho A) k^4 / (1 + k^2 I / A), k = mode pi / L, of which thick beams are 12 % lower in the fourth mode."""
    section, n = asdict(Section(2e11, 7800.0, 0.1, 0.05)), 24
    nodes = np.column_stack([np.linspace(0, 1, n + 1), np.zeros(n + 1)])
    parameters = distribute(section, {}, (), n)
    chain = np.column_stack([np.arange(n), np.arange(1, n + 1)])
    at = assemble(PlanarBeam(nodes, chain, parameters.patches, rotary_inertia=True)).at(parameters.values)
    free = [k for k in range(3 * (n + 1)) if k % 3 and k not in (1, 3 * n + 1)]  # bending alone
    stiffness, mass = (at.coordinates.of_nodes(each).toarray()[np.ix_(free, free)] for each in (at.stiffness, at.mass))
    squares = scipy.linalg.eigh(stiffness, mass, eigvals_only=True)
    k = mode * np.pi
    exact = 2e11 * 0.1**2 / 12 / 7800 * k**4 / (1 + k**2 * 0.1**2 / 12)
    assert squares[mode - 1] == pytest.approx(exact, rel=1e-5 * mode**4)  # of fourth order in the length of an element


def test_a_beam_of_the_plane_has_the_inertia_of_the_same_beam_in_space(tmp_path):
    flat = planar(tmp_path)
    (tmp_path / "space").mkdir()
    path = tmp_path / "space" / "frame.toml"
    path.write_text(BENT.format(dimension=3, A=[0.1, 0.3, 0], B=[0.7, 1.1, 0], ratio=", poisson_ratio = 0.3"))
    space = build(path)
    kept = [0, *(1 + 6 * node + k for node in range(1) for k in (0, 1, 5))]
    xx, yy, *_, xy = space.invariants.second_moment[:, kept][:, :, kept]
    scale = np.abs(flat.invariants.inertia).max()
    np.testing.assert_allclose(flat.invariants.inertia, xx + yy, atol=1e-14 * scale)
    np.testing.assert_allclose(flat.invariants.gyroscopic, xy - xy.T, atol=1e-14 * scale)
    np.testing.assert_allclose(flat.elements.inertia.sum(axis=0)[0, 0], flat.invariants.inertia[0, 0], rtol=1e-14)


@pytest.mark.parametrize("name", ["thickness_s", "x_B"])
def test_derivatives_of_rotary_inertia_are_those_of_complex_steps(name, tmp_path):
    """By the thickness the inertia is a polynomial, by a place of a node not: a step through all of its formulas knows neither."""
    model, space = planar(tmp_path), frame_space(FrameRecipe.read(tmp_path / "frame.toml").file)
    stepped = {**space.values, name: space.values[name] + 1e-30j}
    at = space.discretise(stepped)
    z = np.column_stack([undeformed(at.nodes), np.eye(6)[:, 3:]])
    exact, found = contract(at.parts.at(stepped), z), DesignPoint(model, {name: stepped[name]})
    for item in ("inertia", "gyroscopic", "first_moment"):
        rate = np.imag(getattr(exact, item))
        np.testing.assert_allclose(np.imag(found.value(item)), rate, atol=1e-13 * np.abs(rate).max())


def test_a_thick_bar_swings_with_the_inertia_of_its_section(tmp_path):
    """omega^2 = g (L / 2) / (L^2 / 3 + t^2 / 12), and its derivative by t; without rotary inertia the last term is missing."""
    t, scene = 0.2, tmp_path / "scene.toml"
    scene.write_text(PENDULUM)
    section = Section(210e9, 7850.0, t, 0.01)
    for rotary in (1, 0):
        nodes = np.array([[0.0, 0.0], [0.0, -1.0]])
        save(polygon_beam(nodes, section, {"A": 0.0}, rotary_inertia=bool(rotary)), tmp_path / "bar.h5")
        found = ffrf.compile(ffrf.read_scene(scene), variables=["t"]).statics(gradients=True)
        inertia = 1 / 3 + rotary * t**2 / 12
        exact = np.sqrt(9.81 / 2 / inertia) / (2 * np.pi)
        assert found.values["f"] == pytest.approx(exact, rel=2e-6)  # the bar is not rigid
        assert found.gradients["f"]["t"] == pytest.approx(-exact * rotary * t / 12 / inertia, abs=1e-5)


def test_a_frame_in_space_cannot_go_without(tmp_path):
    path = tmp_path / "frame.toml"
    text = BENT.format(dimension=3, A=[0, 0, 0], B=[1, 0, 0], ratio=", poisson_ratio = 0.3")
    path.write_text("rotary_inertia = false\n" + text)
    with pytest.raises(InputError, match=r"rotary_inertia: beams in space \(dimension = 3\) have it"):
        build(path)
