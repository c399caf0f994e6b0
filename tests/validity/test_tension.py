"""Tension stiffens a body across itself, which linear bodies lack: verdicts say so with its size, against closed forms."""

from __future__ import annotations

import re

import numpy as np
import pytest
import scipy

import ffrf
from preprocessing import build, save
from tests.models.solid_bodies import MODULUS, WIDTH, box, rectangle, write_body
from toolkit.analyses.modes import solve_modes
from toolkit.foundation.errors import BifurcationError
from toolkit.validity.bodies.pulled_joints import raised_by_tension
from toolkit.validity.bodies.stiffened_bodies import too_large

YOUNG, THICKNESS, BROAD = 7e10, 0.01, 0.05
BENDING, STRETCHING = YOUNG * BROAD * THICKNESS**3 / 12, YOUNG * BROAD * THICKNESS
FRAME = """units = "m-kg-s"
dimension = {dimension}
nodes = {{ A = {a}, M = {m}, B = {b} }}
beams = [ {{ from = "A", to = "M", section = "s", elements = 6{turned} }}, {{ from = "M", to = "B", section = "s", elements = 6{turned} }} ]
sections.s = {{ kind = "rectangle", thickness = 0.01, width = 0.05, material = "m" }}
materials.m = {{ youngs_modulus = 7e10, density = 2700.0{ratio} }}
"""
POINTS = 'interface_points = { A = { node = "A" }, M = { node = "M" }, B = { node = "B" } }\n'
SCENE = """units = "m-kg-s"
points.A = {{ body = "bar", interface = "A" }}
points.M = {{ body = "bar", interface = "M" }}
points.B = {{ body = "bar", interface = "B" }}
bodies.bar = {{ type = "flexible", model = "{name}.h5", {frame} }}
"""
HELD = 'joints.A = {{ type = "revolute", bodies = ["bar", "ground"], point = "A" }}\n'
PINNED = HELD + 'joints.B = {{ type = "revolute", bodies = ["bar", "ground"], point = "B" }}\n'
SLIDING = HELD + 'joints.B = {{ type = "slider", bodies = ["bar", "ground"], point = "B", axis = [1.0, 0.0] }}\n'
ACROSS = """loads.F.type = "point-force"
loads.F.body = "bar"
loads.F.point = "M"
loads.F.force = [0.0, {force}]
loads.F.curve = {{ type = "smooth-step", duration = 0.3 }}
design.F = "loads.F.force.y"
responses.w = {{ type = "displacement", body = "bar", point = "M", component = "y" }}
solver = {{ end_time = 0.3, step = 0.003 }}
"""
ALONG = """loads.T = {{ type = "point-force", body = "bar", point = "B", force = [{force}, 0.0] }}
design.T = "loads.T.force.x"
responses.f1 = {{ type = "frequency" }}
responses.f2 = {{ type = "frequency", number = 2 }}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A bar of 1 m x 50 x 10 mm by several frames and bases."""
    found = tmp_path_factory.mktemp("bars")
    places = {"a": "[0.0, 0.0]", "m": "[0.5, 0.0]", "b": "[1.0, 0.0]"}
    plane = FRAME.format(dimension=2, **places, turned="", ratio="")
    places = {name: each.replace("]", ", 0.0]") for name, each in places.items()}
    upright = ", orientation = [0.0, 0.0, 1.0]"
    space = FRAME.format(dimension=3, **places, turned=upright, ratio=", poisson_ratio = 0.3")
    ends, few = 'clamp = ["A", "B"]\n', 'basis = { kind = "craig-bampton", count = 6 }\n'
    files = {
        "chord": plane + POINTS + 'basis = { kind = "craig-bampton", count = 6, chord = ["A", "B"] }\n',
        "one": 'clamp = ["A"]\n' + plane + POINTS,
        "ends": ends + plane + POINTS,
        "space": ends + space + POINTS,
        "few": ends + space + 'interface_points = { M = { node = "M" } }\n' + few,
    }
    for name, text in files.items():
        (found / f"{name}.toml").write_text(text)
        save(build(found / f"{name}.toml"), found / f"{name}.h5")
    return found


def system(folder, name, frame, rest, **numbers):
    (folder / "scene.toml").write_text(SCENE.format(name=name, frame=frame) + rest.format(**numbers))
    scene = ffrf.read_scene(folder / "scene.toml")
    return ffrf.compile(scene, variables=list(scene.design))


def doubts(run):
    """Texts of what is said about tension."""
    return [each.text for each in run.verdict.warnings if each.code == "tension" and each.doubt]


def pulled_frequencies(force: float, count: int) -> list[float]:
    """Of a cantilever, in parts of sqrt(E I / rho A L^4) / 2 pi, pulled by a force in parts of E I / L^2 (Bokaian 1990)."""

    def determinant(omega: float) -> float:
        half = np.hypot(force / 2, omega)
        a, b = np.sqrt(half + force / 2), np.sqrt(half - force / 2)
        return 2 * omega**2 + (force**2 + 2 * omega**2) * np.cosh(a) * np.cos(b) + force * omega * np.sinh(a) * np.sin(b)

    grid = np.linspace(0.1, 60, 3000)
    signs = np.sign([determinant(each) for each in grid])
    starts = np.flatnonzero(np.diff(signs))[:count]
    return [scipy.optimize.brentq(determinant, grid[k], grid[k + 1]) for k in starts]


def held_deflection(force: float) -> float:
    """In the middle of a bar whose ends are pinned, by its differential equation with the tension that its own length makes."""

    def shape(tension: float) -> tuple[float, float]:
        k = np.sqrt(tension / BENDING)
        x = np.linspace(0, 0.5, 2001)
        slope = force / (2 * tension) * (1 - np.cosh(k * x) / np.cosh(k / 2))
        return np.trapezoid(slope, x), np.trapezoid(slope**2, x)  # twice a half

    tension = scipy.optimize.brentq(lambda each: each / STRETCHING - shape(each)[1], 1e-3, 1e6)
    return shape(tension)[0]


@pytest.mark.parametrize("part", [10.0, 0.25])
def test_frequencies_of_a_pulled_cantilever_are_too_low_by_what_is_said(folder, part):
    run = system(folder, "one", 'frame = "grounded"', ALONG, force=part * BENDING).statics(gradients=True)
    true = np.divide(pulled_frequencies(part, 2), pulled_frequencies(1e-9, 2))
    assert raised_by_tension(run.solution)[:2] == pytest.approx(true, rel=2e-3)
    assert [f"f1 by {1 - 1 / true[0]:.1%}" in each for each in doubts(run)] == [True] * (part > 1)
    assert run.gradients["f1"]["T"] == 0
    assert ("unfelt" in run.verdict.codes) == (part < 1)  # zero is no right derivative where tension counts
    assert ("tension" in solve_modes(run.solution, 2).verdict.codes) == (part > 1)


def test_frames_in_number_know_it(folder):
    run = system(folder, "one", 'frame = "grounded", frames = 6', ALONG, force=10 * BENDING).statics()
    assert doubts(run) == []


def test_a_pulled_bar_that_its_frame_makes_buckle_is_refused_with_the_reason(folder):
    """At 3 EI / L^2 of a frame that turns with its end, instead of the frequencies of a bar between pins that is pulled."""
    force = 10 * BENDING
    with pytest.raises(
        BifurcationError, match=r"bar is in tension and does not buckle.*Fix: set frames = 9 .*basis\.chord"
    ) as told:
        system(folder, "one", 'frame = "moving"', SLIDING + ALONG, force=force).statics()
    assert told.value.load_factor == pytest.approx(0.3, rel=1e-3)
    k, per_length = np.pi * np.arange(1, 3), 2700.0 * BROAD * THICKNESS
    true = k**2 * np.sqrt(BENDING / per_length * (1 + 10.0 / k**2)) / (2 * np.pi)
    run = system(folder, "one", 'frame = "moving", frames = 9', SLIDING + ALONG, force=force).statics()
    assert [run.values["f1"], run.values["f2"]] == pytest.approx(true, rel=0.01)
    assert run.verdict.trusted


def test_modes_say_their_tension_once_and_nothing_of_responses(folder):
    found = system(folder, "chord", 'frame = "moving"', SLIDING + ALONG, force=10 * BENDING).modes(count=2)
    (text,) = doubts(found)
    assert "mode 1 by" in text
    assert "f1" not in str(found.verdict)


@pytest.mark.parametrize("force", [200.0, 60.0, 15.0])
def test_a_bar_between_pins_is_too_soft_by_what_is_said(folder, force):
    run = system(folder, "chord", 'frame = "moving"', PINNED + ACROSS, force=force).statics(gradients=True)
    true, near = held_deflection(force), held_deflection(1.001 * force)
    told, stiffer = too_large(run.solution), (near - true) / (1e-3 * force)
    assert told.part == pytest.approx(1 - true / run.values["w"], rel=0.03)
    assert 1 + told.state.largest() == pytest.approx(run.gradients["w"]["F"] / stiffer, rel=0.05)
    (said,) = doubts(run)  # of 15 N only because of the derivative
    assert ("its largest displacement is" in said) == (told.part > 0.05) == (force > 15.0)
    assert told.by_itself


def test_a_small_force_leaves_nothing_to_doubt(folder):
    run = system(folder, "chord", 'frame = "moving"', PINNED + ACROSS, force=6.0).statics(gradients=True)
    assert run.values["w"] == pytest.approx(held_deflection(6.0), rel=0.01)
    assert "tension" not in run.verdict.codes


def test_a_bar_that_slides_at_one_end_is_right(folder):
    run = system(folder, "chord", 'frame = "moving"', SLIDING + ACROSS, force=200.0).statics()
    assert "tension" not in run.verdict.codes
    assert too_large(run.solution).part < 1e-6


@pytest.mark.parametrize(("held", "told"), [(PINNED, 1), (SLIDING, 0)])
def test_motions_say_it_too(folder, held, told):
    run = system(folder, "chord", 'frame = "moving"', held + ACROSS, force=200.0).simulate()
    assert len(doubts(run)) == told


@pytest.mark.parametrize("name", ["space", "few"])
def test_in_space_it_is_the_same_of_elements_and_of_lines(folder, name):
    frame = 'frame = "grounded"'
    rest = 'loads.F = {{ type = "point-force", body = "bar", point = "M", force = [0.0, {force}{z}] }}\n'
    plane = system(folder, "ends", frame, rest, force=800.0, z="").statics()
    text = SCENE.format(name=name, frame=frame).replace("points.A", "# ").replace("points.B", "# ")
    (folder / "scene.toml").write_text("dimension = 3\n" + text + rest.format(force=800.0, z=", 0.0"))
    space = ffrf.compile(ffrf.read_scene(folder / "scene.toml")).statics()
    assert too_large(space.solution).part == pytest.approx(too_large(plane.solution).part, rel=0.02)
    assert len(doubts(space)) == 1


SOLID = """units = "m-kg-s"
points.tip = {{ body = "bar", interface = "tip" }}
bodies.bar = {{ type = "flexible", model = "body.h5", frame = "grounded" }}
loads.F = {{ type = "point-force", body = "bar", point = "tip", force = [0.0, {force}{z}] }}
design.F = "loads.F.force.y"
responses.w = {{ type = "displacement", body = "bar", point = "tip", component = "y" }}
"""


@pytest.mark.parametrize("dimension", [2, 3])
def test_solids_that_are_clamped_at_both_ends(tmp_path, dimension):
    """1 N leaves nothing to doubt; a deflection of the thickness what the cubic of a clamped beam says."""
    size, count = 0.04, (12, 1)
    mesh = rectangle("quad8", count, 1.0, size) if dimension == 2 else box("hexahedron20", (*count, 1), (1.0, size, size))
    mesh.groups["left"] = np.union1d(mesh.groups["left"], mesh.groups["right"])
    mesh.groups["right"] = np.flatnonzero(np.abs(mesh.nodes[:, 0] - 0.5) < 1e-9)
    save(build(write_body(tmp_path, mesh, 'kind = "craig-bampton"\ncount = 4')), tmp_path / "body.h5")
    width = WIDTH if dimension == 2 else size
    stiffness = 192 * MODULUS * width * size**3 / 12
    z = ", 0.0" if dimension == 3 else ""

    def loaded(force: float):
        (tmp_path / "scene.toml").write_text(f"dimension = {dimension}\n" + SOLID.format(force=force, z=z))
        return ffrf.compile(ffrf.read_scene(tmp_path / "scene.toml")).statics()

    light = loaded(1.0).verdict
    assert not {"tension", "critical-load", "large-deformation"} & {*light.codes}
    heavy = loaded(stiffness * size)
    told = too_large(heavy.solution)
    part = scipy.optimize.brentq(lambda a: a + CUBIC * (heavy.values["w"] / size) ** 2 * a**3 - 1, 0, 1)
    assert told.part == pytest.approx(1 - part, rel=0.1)
    assert len(doubts(heavy)) == 1


def cubic_of_a_clamped_bar() -> float:
    """c t^2 of a + c w^2 a^3 = 1 for the deflection by a force in the middle: (int w'^2)^2 E A / (2 L) over int E I w''^2, by w = 1."""
    x = np.linspace(0, 0.5, 4001)
    slope, curvature = 24 * x - 48 * x**2, 24 - 96 * x  # of w = 12 x^2 - 16 x^3
    growth, bent = (2 * np.trapezoid(each**2, x) for each in (slope, curvature))
    return growth**2 / 2 / (bent / 12)


CUBIC = cubic_of_a_clamped_bar()


def test_joints_lack_what_the_deflection_pulls_them_with(folder):
    """A pinned bar that 10 N bend by 0.7 mm is hardly stiffer: E A int w'^2 dx / 2 L at its ends, where 5 N hold it across."""
    force = 10.0
    pull = 'responses.pull = {{ type = "joint-force", joint = "B", component = "x" }}\n'
    run = system(folder, "chord", 'frame = "moving"', PINNED + pull + ACROSS, force=force).simulate()
    (text,) = [each for each in doubts(run) if "pull by" in each]
    slope_squared = (force / BENDING) ** 2 / 480  # int w'^2 of a bar of 1 m under a force F in its middle: F^2 L^5 / 480 (E I)^2
    true = STRETCHING * slope_squared / 2
    assert float(re.search(r"pull by ([\d.e+]+) N", text)[1]) == pytest.approx(
        true, rel=0.25
    )  # stiffer by 5 %, and not quite at rest


@pytest.mark.parametrize(("force", "told"), [(3.73, True), (0.8, False)])
def test_gradients_of_joint_forces_are_doubted_before_the_forces(folder, force, told):
    """Of a bar clamped at both ends a pull N of a fifth of V = F / 2 makes sqrt(V^2 + N^2) 2 % larger, and a thickness that V does not
    know makes it smaller by 5 N^2."""
    rest = """joints.B = {{ type = "rigid", bodies = ["bar", "ground"], point = "B" }}
responses.pull = {{ type = "joint-force", joint = "B", component = "magnitude" }}
design.t = "bodies.bar.thickness_s"
"""
    run = system(folder, "one", 'frame = "grounded"', rest + ACROSS, force=force).statics(gradients=True)
    pull = STRETCHING / 2 * (force / BENDING) ** 2 / 7680  # of int w'^2 = F^2 L^5 / 7680 (E I)^2
    assert doubts(run) == []
    assert ("geometric-gradients" in run.verdict.codes) is told
    if told:
        missing = -5 * pull**2 / np.hypot(force / 2, pull) / THICKNESS
        assert run.frame_errors.gradients["pull"]["t"] == pytest.approx(missing, rel=0.15)
        assert abs(run.gradients["pull"]["t"]) < 1e-3 * abs(missing)


@pytest.mark.parametrize(("force", "told"), [(0.233, True), (0.05, False)])
def test_so_they_are_of_a_body_in_a_few_shapes(folder, force, told):
    """A pinned bar whose elements show what its shapes lack: by thickness -5 N^2 / pull t; by the load, at 6 %, too little to be said."""
    more = (
        'responses.pull = {{ type = "joint-force", joint = "B", component = "magnitude" }}\ndesign.t = "bodies.bar.thickness_s"\n'
    )
    run = system(folder, "chord", 'frame = "moving"', PINNED + more + ACROSS, force=force).statics(gradients=True)
    assert ("geometric-gradients" in run.verdict.codes) is told
    if told:
        pull = STRETCHING * (force / BENDING) ** 2 / 480 / 2
        missing = -5 * pull**2 / np.hypot(force / 2, pull) / THICKNESS
        assert run.frame_errors.gradients["pull"]["t"] == pytest.approx(missing, rel=0.15)
