"""Frames of spatial beams from frame.toml: closed forms, exact dependence on every parameter, and refusals by key."""

from __future__ import annotations

import re
import sys
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh

from preprocessing import build
from preprocessing.builders.frame_file import frame_elements, frame_space
from preprocessing.builders.frame_recipe import FrameRecipe
from preprocessing.commands.cli import main
from preprocessing.reduction.chosen_basis import tangent_frame
from preprocessing.reduction.invariants import contract_at
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.dependence import scattered
from toolkit.reduced_model.file import load, save
from toolkit.reduced_model.model import MEAN_AXES, ReducedModel
from toolkit.reduced_model.parts import SpatialInvariants

NAMES = [field.name for field in fields(SpatialInvariants)]

FRAME = """units = "m-kg-s"
clamp = ["A"]

[nodes]
A = [0, 0, 0]
B = [0, 0, 1]
C = [1, 0.2, 1.3]
D = [1.1, 1, 0.9]

[[beams]]
from = "A"
to = "B"
elements = 2
section = "leg"

[[beams]]
from = "B"
to = "C"
elements = 3
section = "arm"
orientation = [0, 0.1, 1]

[[beams]]
from = "C"
to = "D"
elements = 1
section = "foreign"

[[beams]]
from = "B"
to = "D"
elements = 2
section = "rod"

[sections]
leg = { kind = "tube", diameter = 0.05, wall = 0.004, material = "steel" }
arm = { kind = "rectangle", thickness = 0.01, width = 0.04, material = "alloy" }
rod = { kind = "circle", diameter = 0.02, material = "alloy" }
foreign = { kind = "general", area = 4e-4, I_y = 2e-8, I_z = 1e-8, J = 1.5e-8, I_p = 3e-8, fibres = [[0.01, -0.02]], material = "steel" }

[materials]
steel = { youngs_modulus = 2.1e11, poisson_ratio = 0.3, density = 7850.0 }
alloy = { youngs_modulus = 7e10, poisson_ratio = 0.34, density = 2700.0 }

[damping]
mass = 0.3
stiffness = 1e-4

[interface_points]
tip = { node = "D" }
"""

BENT = """units = "m-kg-s"
clamp = ["A"]
nodes = { A = [0, 0, 0], B = [0.7, 0, 0], C = [0.7, 0.4, 0] }
beams = [{ from = "A", to = "B", section = "rod", elements = 2 }, { from = "B", to = "C", section = "rod", elements = 1 }]
sections = { rod = { kind = "circle", diameter = 0.02, material = "steel" } }
materials = { steel = { youngs_modulus = 2e11, poisson_ratio = 0.25, density = 7800.0 } }
interface_points = { tip = { node = "C" } }
"""


@pytest.fixture
def path(tmp_path):
    (tmp_path / "frame.toml").write_text(FRAME)
    return tmp_path / "frame.toml"


def close(found, expected, tolerance):
    np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance * np.abs(expected).max(initial=0))


def rate(model: ReducedModel, item: str, parameter: str) -> np.ndarray:
    """Derivative of an item by a parameter, from polynomials and derivatives together."""
    shape, number, found = model.item(item).shape, model.numbers[parameter], 0.0
    lists = [model.derivatives[item]] if item in model.derivatives else []
    if item in model.affine:
        lists.append(model.affine[item].rates(np.array(list(model.nominal.values()))))
    for each in lists:
        found = found + scattered(*each.by(number), int(np.prod(shape))).reshape(shape)
    return found if lists else np.zeros(shape)


def test_bent_cantilever_sinks_by_bending_and_torsion(tmp_path):
    """P a^3 / 3EI + P b^3 / 3EI + P a b^2 / GJ under a load across the plane of an L, and the interface point says so."""
    (tmp_path / "bent.toml").write_text(BENT)
    model = build(tmp_path / "bent.toml")
    position, rotation = model.interfaces["tip"].here
    moved = np.linalg.solve(model.invariants.stiffness, position[2, 1:])
    a, b, inertia = 0.7, 0.4, np.pi * 0.02**4 / 64
    shear = 2e11 / 2.5
    expected = a**3 / (3 * 2e11 * inertia) + b**3 / (3 * 2e11 * inertia) + a * b**2 / (shear * 2 * inertia)
    np.testing.assert_allclose(position[2, 1:] @ moved, expected, rtol=1e-10)  # exact at nodes; condition 1e5
    about_x = a * b / (shear * 2 * inertia) + b**2 / (2 * 2e11 * inertia)
    np.testing.assert_allclose(rotation[0, 1:] @ moved, about_x, rtol=1e-10)
    np.testing.assert_allclose(position[:, 0], [0.7, 0.4, 0], rtol=1e-15)


def test_mass_and_its_moments_are_those_of_the_bodies_that_it_is_made_of(path):
    inv = build(path).invariants
    nodes = {"A": [0, 0, 0], "B": [0, 0, 1], "C": [1, 0.2, 1.3], "D": [1.1, 1, 0.9]}
    lines = {"AB": 7850 * np.pi * (0.05**2 - 0.042**2) / 4, "BC": 2700 * 4e-4, "CD": 7850 * 4e-4, "BD": 2700 * np.pi * 1e-4}
    ends = {name: [np.array(nodes[node], float) for node in name] for name in lines}
    masses = {name: lines[name] * np.linalg.norm(two - one) for name, (one, two) in ends.items()}
    np.testing.assert_allclose(inv.mass, sum(masses.values()), rtol=1e-14)
    expected = sum(masses[name] * (one + two) / 2 for name, (one, two) in ends.items())
    np.testing.assert_allclose(inv.first_moment[:, 0], expected, rtol=1e-13)


@pytest.mark.parametrize(
    ("basis", "n_f"),
    [
        ({}, 42),
        ({"kind": "eigenmodes", "count": 5}, 5),
        ({"kind": "eigenmodes", "count": 5, "derivative": "frozen"}, 5),
        ({"kind": "craig-bampton", "count": 2}, 8),
        ({"kind": "static"}, 6),
    ],
)
def test_every_basis_gives_a_file_that_is_read_back(path, tmp_path, basis, n_f):
    model = build(path, keys={"basis": basis} if basis else {})
    save(model, tmp_path / "frame.h5")
    read = load(tmp_path / "frame.h5")
    assert (read.dimension, read.n_f, list(read.interfaces)) == (3, n_f, ["tip"])
    # lines: eight fibres of a tube and a circle, four of a rectangle, one of the general section
    assert len(read.surface.lines) == 2 * 8 + 3 * 4 + 1 + 2 * 8
    assert read.invariants.stress_operator.shape == (2 * len(read.surface.lines), 1, n_f)


def test_a_free_frame_floats_about_mean_axes(path):
    """Its modes carry neither momentum nor, by their translations and rotations, angular momentum."""
    path.write_text(FRAME.replace('clamp = ["A"]\n', "") + '[basis]\nkind = "eigenmodes"\ncount = 6\nboundary = "free"\n')
    model = build(path)
    assert model.reference_condition == MEAN_AXES
    inv = model.invariants
    q = inv.second_moment[3:, 0, 1:] - inv.second_moment[3:, 1:, 0]
    size = np.sqrt(np.diag(inv.second_moment[:3].sum(axis=0)).max() * inv.mass)
    assert np.abs(inv.first_moment[:, 1:]).max() < 1e-9 * size  # round-off of the free modes: condition times 1e-16
    assert np.abs(q).max() < 1e-9 * size


def test_polynomials_are_a_fresh_preprocessing_at_any_design(path):
    model = build(path)
    file = FrameRecipe.read(path).file
    other = {
        name: value * (1.1 + 0.03 * k)
        for k, (name, value) in enumerate(model.nominal.items())
        if name[:2] not in ("x_", "y_", "z_")
    }
    other = {name: value for name, value in other.items() if not name.startswith("poisson")}
    assert set(other) == frame_space(file).in_monomials
    fresh, p = build(path, values=other), np.array(list({**model.nominal, **other}.values()))
    for name in NAMES:
        expected = getattr(fresh.invariants, name)
        close(model.affine[name](p, expected.size).reshape(expected.shape), expected, 1e-12)


def test_all_derivatives_are_the_complex_step(path):
    model, file = build(path), FrameRecipe.read(path).file
    for parameter in ("x_B", "z_D", "y_A", "poisson_ratio_alloy", "wall_leg", "I_p_foreign", "density_steel"):
        stepped = {**model.nominal, parameter: model.nominal[parameter] + 1e-30j}
        elements = frame_elements(file, stepped)
        z = tangent_frame(elements.nodes, 0, "A").z
        exact, tip = contract_at(elements.parts, stepped, z), elements.interfaces(z)["tip"]
        for name in NAMES:
            close(rate(model, name, parameter), np.imag(getattr(exact, name)) / 1e-30, 1e-10)
        for name in ("position", "rotation"):
            close(rate(model, f"interfaces.tip.{name}", parameter), np.imag(getattr(tip, name)) / 1e-30, 1e-10)


@pytest.mark.parametrize("parameter", ["x_C", "thickness_arm"])
def test_eigenvalues_of_differentiated_modes_follow_the_design(path, parameter):
    """Against central differences of the eigenvalues of all coordinates, extrapolated from two steps."""
    keys: dict[str, Any] = {"basis": {"kind": "eigenmodes", "count": 4}}
    model = build(path, keys=keys)

    def eigenvalues(change: float) -> np.ndarray:
        values = {**model.nominal, parameter: model.nominal[parameter] * (1 + change)}
        elements = frame_elements(FrameRecipe.read(path).file, values)
        found = elements.parts.at(values)
        stiffness, mass = (found.coordinates.of_nodes(each).toarray()[6:, 6:] for each in (found.stiffness, found.mass))
        return eigh(stiffness, mass, eigvals_only=True)[:4]

    steps = [(eigenvalues(h) - eigenvalues(-h)) / (2 * h * model.nominal[parameter]) for h in (4e-3, 2e-3)]
    expected = (4 * steps[1] - steps[0]) / 3
    ours = np.diag(rate(model, "stiffness", parameter))
    np.testing.assert_allclose(
        ours, expected, rtol=0, atol=1e-6 * np.abs(expected).max()
    )  # fourth order: (4e-3)^4, and round-off


WRONG = [
    ('from = "A"', 'from = "Q"', "beams.0.from: there is no node 'Q'; there are A, B, C, D"),
    ('section = "rod"', 'section = "rot"', "beams.3.section: there is no section 'rot'; there are leg, arm, rod, foreign"),
    (
        'diameter = 0.02, material = "alloy"',
        'diameter = 0.02, material = "wood"',
        "sections.rod.material: there is no material 'wood'",
    ),
    ('node = "D"', 'node = "E"', "interface_points.tip.node: there is no node 'E'"),
    ('clamp = ["A"]', 'clamp = ["F"]', "clamp: there is no node 'F'"),
    (
        "orientation = [0, 0.1, 1]",
        "orientation = [2, 0.4, 0.6]",
        "beams.1.orientation: [2.0, 0.4, 0.6] is zero or runs along the beam",
    ),
    ("C = [1, 0.2, 1.3]", "C = [0, 0, 1]", "beams.1: its ends B and C are at one place; a beam needs a length"),
    (
        "D = [1.1, 1, 0.9]",
        "D = [1.1, 1, 0.9]\nE = [1, 1, 1]",
        "nodes: no beams lead from A to E; connect them, or leave them out",
    ),
    ("elements = 3", "elements = 499", "beams: all together have more than 500 elements"),
    (
        "elements = 3",
        "element = 3",
        "beams.1.element: unknown key, did you mean 'elements'; possible here: from, to, elements, section, orientation",
    ),
    ("wall = 0.004", "wall = 0.04", "sections.leg: the wall of a tube is at most half its diameter"),
    ("wall = 0.004", "width = 0.04", "sections.leg: a tube has the numbers diameter, wall (given: diameter, width)"),
    ("I_p = 3e-8", "I_p = 3e-9", "sections.foreign: an I_p below |I_y - I_z| belongs to no distribution of mass"),
    ("thickness = 0.01", "thickness = -0.01", "sections.arm.thickness: input should be greater than 0 (given: -0.01)"),
    ("poisson_ratio = 0.3,", "", "materials.steel.poisson_ratio: this key is missing; add it"),
    ('clamp = ["A"]', "", "the body's frame needs a place; add clamp"),
    ("A = [0, 0, 0]", "A = [0, 0]", "nodes.A: a frame in space (dimension = 3) has 3 coordinates (given: [0.0, 0.0])"),
]


@pytest.mark.parametrize(("old", "new", "message"), WRONG)
def test_wrong_input_is_refused_by_key(path, old, new, message):
    assert old in FRAME
    path.write_text(FRAME.replace(old, new, 1))
    with pytest.raises(InputError, match=re.escape(message)) as caught:
        build(path)
    assert str(path) in str(caught.value)


def run(monkeypatch, *arguments: str) -> int:
    monkeypatch.setattr(sys, "argv", ["ffrf-preprocess", *arguments])
    with pytest.raises(SystemExit) as caught:
        main()
    return int(caught.value.code or 0)


def test_command_builds_a_frame_and_rests_when_nothing_changed(path, monkeypatch, capsys):
    assert run(monkeypatch, str(path)) == 0
    assert "42 elastic coordinates, interface points tip" in capsys.readouterr().out
    assert run(monkeypatch, str(path)) == 0
    assert "up to date" in capsys.readouterr().out
    assert run(monkeypatch, str(path), "--parameter", "x_B=0.1") == 0
    assert load(path.with_suffix(".h5")).nominal["x_B"] == 0.1
    assert run(monkeypatch, str(path), "--parameter", "x_Q=0.1") == 1
    assert "has no parameter 'x_Q', did you mean 'x_D'" in capsys.readouterr().err
    assert Path(path.with_suffix(".h5")).exists()


@pytest.mark.parametrize("kind", ['"craig-bampton"\ncount = 4', '"eigenmodes"\ncount = 4', '"static"'])
@pytest.mark.parametrize("dimension", [2, 3])
def test_an_interface_point_that_is_clamped_does_not_move_by_round_off(kind, dimension, tmp_path):
    pad = ", 0.0" * (dimension - 2)
    text = f"""units = "m-kg-s"
dimension = {dimension}
clamp = ["A"]
nodes = {{ A = [0.1, 0.2{pad}], B = [0.9, 0.8{pad}] }}
beams = [{{ from = "A", to = "B", section = "bar", elements = 7 }}]
interface_points = {{ A = {{ node = "A" }}, B = {{ node = "B" }} }}
sections.bar = {{ kind = "rectangle", thickness = 0.01, width = 0.02, material = "steel" }}
materials.steel = {{ youngs_modulus = 2.1e11, poisson_ratio = 0.3, density = 7850.0 }}
basis = {{ kind = {kind.replace(chr(10), ", ")} }}
"""
    (tmp_path / "frame.toml").write_text(text if dimension == 3 else text.replace("poisson_ratio = 0.3, ", ""))
    model = build(tmp_path / "frame.toml")
    held, free = model.interfaces["A"], model.interfaces["B"]
    assert not held.position[..., 1:].any()
    assert not held.rotation[..., 1:].any()
    assert free.position[..., 1:].any()
    assert free.rotation[..., 1:].any()
    for item, entries in model.derivatives.items():
        if item.startswith("interfaces.A"):  # its place follows its coordinates, and nothing else
            assert not (entries.entry % held.position.shape[-1]).any(), item


ROOF = """units = "m-kg-s"
clamp = ["A"]
nodes = { A = [0, 0, 0], B = [0.37, 0.41, 0.13], C = [0.74, 0, 0] }
beams = [{ from = "A", to = "B", section = "rod", elements = 3 }, { from = "C", to = "B", section = "rod", elements = 3 }]
sections = { rod = { kind = "circle", diameter = 0.02, material = "steel" } }
materials = { steel = { youngs_modulus = 2e11, poisson_ratio = 0.25, density = 7800.0 } }
interface_points = { tip = { node = "C" } }
"""


def test_round_off_is_neither_a_derivative_of_the_mass_nor_a_term_of_it(path):
    """Moved along x, the ridge makes one half of a roof as much longer as the other shorter; and what a section's points add to the mass
    when they turn is none of a translation's."""
    path.with_name("roof.toml").write_text(ROOF)
    roof = build(path.with_name("roof.toml"))
    changing = {list(roof.nominal)[k] for k in roof.derivatives["mass"].parameter}
    assert changing == {f"{axis}_{node}" for axis in "xyz" for node in "ABC"} - {"x_B"}
    areas = 2 + 1 + 1 + 1  # terms of those of a tube, a rectangle, a circle, and an area given
    assert len(build(path).affine["mass"].factor) == areas


def test_a_step_of_one_node_is_assembled_from_the_elements_it_moves(path):
    """So that many named nodes cost as many elements as there are, not their product; and nothing is lost."""
    file = FrameRecipe.read(path).file
    space = frame_space(file)
    for parameter in ("y_C", "poisson_ratio_alloy", "x_D"):
        stepped = space.stepped(parameter)
        few, all_parts = stepped.changing_parts, stepped.parts
        assert 0 < len(few.parts) < len(all_parts.parts)
        for name in ("mass", "stiffness", "damping", "stress"):
            ours, whole = (getattr(parts.at(space.values), name) for parts in (few, all_parts))
            close(ours.imag.toarray(), whole.imag.toarray(), 1e-14)
