"""Frames of plane beams from frame.toml: closed forms, lengths and angles as parameters, and refusals by key."""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np
import pytest

from preprocessing import build
from preprocessing.builders.frame_recipe import FrameRecipe, outline, polygon_beam
from preprocessing.elements.section import Section
from tests.preprocessing.test_chord import PLANE
from tests.preprocessing.test_frame_models import close, rate
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.file import load, save

CLAMPED = PLANE.replace("\n", '\nclamp = ["A"]\n', 1)


@pytest.fixture
def path(tmp_path):
    (tmp_path / "frame.toml").write_text(CLAMPED)
    return tmp_path / "frame.toml"


def test_a_portal_sways_as_the_textbook_says(tmp_path):
    """Two legs of height h that are clamped, a beam of width w on them, and a push at one corner, by slope and deflection."""
    text = """units = "m-kg-s"
dimension = 2
clamp = ["A", "D"]
nodes = { A = [0, 0], B = [0, 1.5], C = [2, 1.5], D = [2, 0] }
beams = [{ from = "A", to = "B", section = "s" }, { from = "B", to = "C", section = "s" }, { from = "C", to = "D", section = "s" }]
sections.s = { kind = "rectangle", thickness = 0.01, width = 0.1, material = "steel" }
materials.steel = { youngs_modulus = 2e11, density = 7800.0 }
interface_points = { corner = { node = "B" } }
"""
    (tmp_path / "frame.toml").write_text(text)
    model = build(tmp_path / "frame.toml")
    position, _ = model.interfaces["corner"].here
    found = position[0, 1:] @ np.linalg.solve(model.invariants.stiffness, position[0, 1:])
    bending, h, w = 2e11 * 0.1 * 0.01**3 / 12, 1.5, 2.0
    # slope deflection, beams without extension: each leg shears 12 EI (u / h^3) - 6 EI (theta / h^2), each corner
    # 4 EI theta / h - 6 EI u / h^2 + 6 EI theta / w = 0
    theta = (6 / h**2) / (4 / h + 6 / w)
    stiffness = 2 * (12 / h**3 - 6 / h**2 * theta) * bending
    np.testing.assert_allclose(found, 1 / stiffness, rtol=1e-4)  # extension, (thickness / length)^2 = 4e-5


def test_a_straight_frame_is_the_polygon_beam(tmp_path):
    text = """units = "m-kg-s"
dimension = 2
clamp = ["A"]
nodes = { A = [0.2, 0.1] }
polar_nodes = { B = { from = "A", length = 0.8, angle = 0.6 } }
beams = [{ from = "A", to = "B", section = "s", elements = 5 }]
sections.s = { kind = "rectangle", thickness = 0.01, width = 0.1, material = "steel" }
materials.steel = { youngs_modulus = 2e11, density = 7800.0 }
damping = { mass = 0.3, stiffness = 1e-4 }
interface_points = { tip = { node = "B" } }
"""
    (tmp_path / "frame.toml").write_text(text)
    found = build(tmp_path / "frame.toml")
    nodes = np.array([0.2, 0.1]) + np.linspace(0, 0.8, 6)[:, None] * [np.cos(0.6), np.sin(0.6)]
    expected = polygon_beam(nodes, Section(2e11, 7800.0, 0.01, 0.1, 0.3, 1e-4), {"tip": 0.8})
    for name in ("mass", "stiffness", "damping"):  # of the same nodes in another order
        one, other = (np.linalg.eigvalsh(np.atleast_2d(getattr(each.invariants, name))) for each in (found, expected))
        np.testing.assert_allclose(one, other, rtol=1e-9)  # condition 1e5
    compliances = [
        each.interfaces["tip"].here[0][:, 1:]
        @ np.linalg.solve(each.invariants.stiffness, each.interfaces["tip"].here[0][:, 1:].T)
        for each in (found, expected)
    ]
    close(*compliances, 1e-9)


def test_lengths_and_angles_are_parameters_with_units_and_the_file_is_read_back(path, tmp_path):
    save(build(path), tmp_path / "frame.h5")
    model = load(tmp_path / "frame.h5")
    units = {
        name: model.nominal_units[name] for name in ("length_B", "angle_B", "length_C", "angle_C", "x_A", "y_D", "thickness_arm")
    }
    assert units == {**dict.fromkeys(units, "m"), "angle_B": "rad", "angle_C": "rad"}
    assert (model.dimension, model.n_f, list(model.interfaces)) == (2, 24, ["foot", "tip"])
    np.testing.assert_allclose(
        model.interfaces["tip"].here[0][:, 0],
        [0.1 + 0.8 * np.cos(1.2) + 0.5 * np.cos(-0.3), -0.2 + 0.8 * np.sin(1.2) + 0.5 * np.sin(-0.3)],
        rtol=1e-14,
    )


def test_a_node_moves_along_and_across_its_direction_and_takes_those_that_start_from_it(path):
    model = build(path)
    moved = {name: rate(model, "interfaces.tip.position", name)[0, :, 0] for name in ("length_B", "angle_B", "angle_C")}
    close(moved["length_B"], np.array([np.cos(1.2), np.sin(1.2)]), 1e-14)
    close(moved["angle_B"], 0.8 * np.array([-np.sin(1.2), np.cos(1.2)]), 1e-14)
    close(moved["angle_C"], 0.5 * np.array([np.sin(0.3), np.cos(0.3)]), 1e-14)


def test_other_lengths_are_those_of_another_file(path):
    """As `certify` builds it anew: the model of changed values is that of the changed text."""
    fresh = build(path, values={"length_B": 0.9, "angle_C": -0.2, "x_A": 0.15})
    text = (
        CLAMPED.replace("length = 0.8", "length = 0.9").replace("angle = -0.3", "angle = -0.2").replace("A = [0.1", "A = [0.15")
    )
    path.write_text(text)
    np.testing.assert_array_equal(fresh.invariants.stiffness, build(path).invariants.stiffness)


def test_its_picture_has_a_line_along_every_beam(path):
    file = FrameRecipe.read(path).file
    line, places = outline(file), file.places
    drawn = {tuple(sorted((tuple(one), tuple(other)))) for one, other in pairwise(line)}
    assert drawn == {tuple(sorted((tuple(places[beam.start]), tuple(places[beam.end])))) for beam in file.beams}


WRONG = [
    (
        "A = [0.1, -0.2]",
        "A = [0.1, -0.2, 0.0]",
        "nodes.A: a frame in the plane (dimension = 2) has 2 coordinates (given: [0.1, -0.2, 0.0])",
    ),
    (
        "density = 7850.0",
        "density = 7850.0, poisson_ratio = 0.3",
        "materials.steel.poisson_ratio: beams in the plane (dimension = 2) do not",
    ),
    (
        'kind = "rectangle", thickness = 0.02, width = 0.04',
        'kind = "circle", diameter = 0.02',
        "have sections of kind \"rectangle\" (given: 'circle')",
    ),
    ("elements = 2", "elements = 2, orientation = [0, 0, 1]", "beams.2.orientation: the thickness of a beam in the plane"),
    ("dimension = 2\n", "", "nodes.A: a frame in space (dimension = 3) has 3 coordinates (given: [0.1, -0.2])"),
    ('B = { from = "A"', 'B = { from = "Q"', "polar_nodes.B.from: there is no node 'Q'; there are A, D, C, B"),
    (
        'B = { from = "A"',
        'B = { from = "C"',
        "polar_nodes: C, B start from each other; let one of them start from a node with coordinates",
    ),
    ("C = { from", "D = { from", "beams.1.to: there is no node 'C'; there are A, D, D, B"),
    ("length = 0.5", "length = 0.0", "polar_nodes.C.length: input should be greater than 0"),
    ("D = [0.5, 0.9] }", "D = [0.5, 0.9], C = [1, 1] }", "polar_nodes.C: this node has coordinates in nodes already"),
]


@pytest.mark.parametrize(("old", "new", "message"), WRONG)
def test_wrong_input_is_refused_by_key(path, old, new, message):
    assert old in CLAMPED
    path.write_text(CLAMPED.replace(old, new, 1))
    with pytest.raises(InputError, match=re.escape(message)):
        build(path)
