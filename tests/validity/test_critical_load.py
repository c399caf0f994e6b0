"""Critical loads of compressed bodies: against Euler's, against corotational elements, and what the commands say of them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import ffrf
from preprocessing.elements.section import Section
from tests.frames.test_cut_bodies import EI, STRAIGHT, cantilever, in_space
from tests.frames.test_cut_bodies import SECTION as FRAMED
from tests.models.beam_models import save_beam
from toolkit.analyses.sensitivity.preparation import prepare, solve
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.command_line.cli import app
from toolkit.files.scene_reader import read_scene
from toolkit.responses.least_frequency import LeastFrequency
from toolkit.solvers.static import static_matrix
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene
from toolkit.validity.bodies import critical_load, geometric_stiffness, physics
from toolkit.validity.bodies.corotational_beams import compare_with_corotational
from toolkit.validity.bodies.critical_load import Compression, compression
from toolkit.validity.bodies.deformation import flexible_bodies, node_places

MODELS = Path(__file__).parents[2] / "models"
SECTION = Section(youngs_modulus=210e9, density=7800.0, thickness=0.02, width=0.05)
BENDING, AXIAL = 210e9 * 0.05 * 0.02**3 / 12, 210e9 * 0.05 * 0.02
CANTILEVER, COLUMN = np.pi**2 * BENDING / 4, np.pi**2 * BENDING
"""Euler's loads of a length of 1 m."""
ELEMENTS, ANGLE = 20, 0.4
AXIS = np.array([np.cos(ANGLE), np.sin(ANGLE)])
MOMENT = 0.01

CLAMPED = '[joints]\nclamp = {{ type = "rigid", bodies = ["beam1", "ground"], point = "a1" }}'
PINNED = """[joints]
hinge = {{ type = "revolute", bodies = ["beam1", "ground"], point = "a1" }}
guide = {{ type = "slider", bodies = ["{last}", "ground"], point = "{end}", axis = {axis} }}"""
SLIDING = """[joints]
hinge = {{ type = "slider", bodies = ["beam1", "ground"], point = "a1", axis = {axis} }}
guide = {{ type = "slider", bodies = ["{last}", "ground"], point = "{end}", axis = {axis} }}
[loads.other]
type = "point-force"
body = "beam1"
point = "a1"
force = {opposite}
curve = {curve}"""


def beams(folder: Path, held: str, force: np.ndarray, frame: str = "moving", n: int = 1, curve: float = 0.2) -> Path:
    """A straight beam of n bodies along an axis of no special direction, loaded at its end; the path of its scene."""
    nodes = np.linspace(0, 1 / n, ELEMENTS // n + 1)[:, None] * AXIS
    save_beam(folder / "beam.h5", nodes, SECTION, {"start": 0.0, "end": 1 / n})
    points = [
        f'{name}{k} = {{ body = "beam{k}", interface = "{at}" }}'
        for k in range(1, n + 1)
        for name, at in (("a", "start"), ("b", "end"))
    ]
    bodies = [
        f'beam{k} = {{ type = "flexible", model = "beam.h5", frame = "{frame}"'
        + (f", position = {((k - 1) / n * AXIS).tolist()}" if frame == "moving" else "")
        + " }"
        for k in range(1, n + 1)
    ]
    keys = {"last": f"beam{n}", "end": f"b{n}", "axis": AXIS.tolist(), "opposite": (-force).tolist()}
    keys["curve"] = f'{{ type = "smooth-step", duration = {curve} }}'
    joints = [held.format(**keys)] if held else []
    load = (
        f'[loads.push]\ntype = "point-force"\nbody = "beam{n}"\npoint = "b{n}"\nforce = {force.tolist()}\ncurve = {keys["curve"]}'
    )
    welds = [
        f'weld{k} = {{ type = "rigid", bodies = ["beam{k}", "beam{k + 1}"], point = ["b{k}", "a{k + 1}"] }}' for k in range(1, n)
    ]
    path = folder / "scene.toml"
    response = '[responses]\nw = { type = "displacement", body = "beam1", point = "b1", component = "y" }'
    solver = "[solver]\nend_time = 0.2\nstep = 0.001"
    parts = [
        'units = "m-kg-s"',
        "[points]",
        *points,
        "[bodies]",
        *bodies,
        *joints,
        *(welds if held else []),
        load,
        response,
        solver,
    ]
    path.write_text("\n".join(parts))
    return path


def with_moment(path: Path) -> Path:
    """The same scene with a moment at the start of its first beam."""
    turn = f'[loads.turn]\ntype = "torque"\nbody = "beam1"\npoint = "a1"\ntorque = {MOMENT}\n'
    path.write_text(path.read_text().replace("[responses]", turn + "[responses]"))
    return path


def at_rest(path: Path) -> Solution:
    return solve_statics(compile_scene(read_scene(path)))


def shortened(force: float) -> float:
    """Levers in the equations are those of the deformed beam, shorter by P / EA; twice that is above what it changes."""
    return 2 * force / AXIAL


# Euler's loads; the elements themselves are off by (pi h / L)^4 / 720 = 1e-6 at most


@pytest.mark.parametrize("part", [0.1, 0.9, 1.0, 3.0])
def test_a_grounded_cantilever_has_the_load_of_euler(tmp_path, part):
    found = compression(at_rest(beams(tmp_path, "", -part * CANTILEVER * AXIS, "grounded")))
    assert found.load == pytest.approx(part, rel=1e-6)
    assert found.missed == (pytest.approx(part / (1 - part), rel=1e-4) if part < 1 - 1e-6 else pytest.approx(found.missed))
    assert (found.missed > 1e5) == (part >= 1)


@pytest.mark.parametrize(("held", "euler"), [(CLAMPED, CANTILEVER), (PINNED, COLUMN)])
@pytest.mark.parametrize("part", [0.1, 0.9, 3.0])
def test_beams_with_moving_frames_have_the_loads_of_euler(tmp_path, held, euler, part):
    found = compression(at_rest(beams(tmp_path, held, -part * euler * AXIS)))
    assert found.load == pytest.approx(part, rel=1e-6 + shortened(part * euler))


@pytest.mark.parametrize(("held", "frame"), [("", "grounded"), (CLAMPED, "moving")])
def test_tension_is_never_critical(tmp_path, held, frame):
    solution = at_rest(beams(tmp_path, held, 10 * COLUMN * AXIS, frame))
    found = compression(solution)
    assert max(found.load, found.missed, found.feigned) < 1e-9  # round-off
    assert "critical-load" not in solution.verdict.codes


@pytest.mark.parametrize("part", [0.02, 0.1, 0.2])
def test_a_hinged_bar_whose_frame_is_tied_to_one_end_is_too_soft_under_tension(tmp_path, part):
    solution = at_rest(with_moment(beams(tmp_path, PINNED, part * COLUMN * AXIS)))
    found, k, own = compression(solution), np.pi * np.sqrt(part), part * COLUMN / (3 * BENDING)
    assert found.load < 1e-9  # round-off
    assert found.feigned == pytest.approx(own / (1 - own), rel=shortened(part * COLUMN) / (1 - own))
    true = MOMENT / (part * COLUMN) * (k / np.tanh(k) - 1)  # rotation of the end that the moment acts on
    assert float(solution.q[0, 2]) / true > 1 + found.feigned  # the body is stiffer, besides
    assert [(each.doubt, "under its tension" in each.text) for each in solution.warnings] == [(True, True)]


def test_bending_alone_is_never_critical(tmp_path):
    assert compression(at_rest(beams(tmp_path, "", 10.0 * np.array([-AXIS[1], AXIS[0]]), "grounded"))) is None


def test_a_row_of_bodies_misses_less_the_more_they_are(tmp_path, monkeypatch):
    monkeypatch.setattr(critical_load, "LIMIT", 1e-6)
    missed = []
    for n in (1, 2, 4):
        found = compression(at_rest(beams(tmp_path, PINNED, -0.5 * COLUMN * AXIS, n=n)))
        assert found.load == pytest.approx(0.5, rel=1e-6 + shortened(0.5 * COLUMN))
        missed.append(found.missed)
    # a chord of each body turns in the equations: what they lack goes with the square of its length
    assert missed[0] > 0.5
    assert missed[2] < missed[1] / 3 < missed[0] / 6


def test_a_long_row_of_fine_bodies_keeps_its_softest_motion(tmp_path, monkeypatch):
    monkeypatch.setattr(critical_load, "LIMIT", 1e-6)
    monkeypatch.setattr("tests.validity.test_critical_load.ELEMENTS", 400)
    found = compression(at_rest(beams(tmp_path, PINNED, -0.3 * COLUMN * AXIS, n=20)))
    assert found.load == pytest.approx(0.3, rel=1e-6 + shortened(0.3 * COLUMN))


@pytest.mark.parametrize(("held", "n", "part"), [(CLAMPED, 1, 0.6), (PINNED, 3, 0.9), (CLAMPED, 1, 1.5)])
def test_sparse_matrices_of_many_coordinates_say_what_dense_ones_do(held, n, part, tmp_path, monkeypatch):
    solution = at_rest(beams(tmp_path, held, -part * COLUMN / (4 if held == CLAMPED else 1) * AXIS, n=n))
    dense = compression(solution)
    for module in (static_matrix, geometric_stiffness):
        monkeypatch.setattr(module, "SPARSE_FROM_UNKNOWNS", 10)
    monkeypatch.delattr(critical_load, "_of_few")
    sparse = compression(solution)
    assert sparse.body == dense.body
    assert sparse[2:] == pytest.approx(dense[2:], rel=1e-6)  # the dense ones lose six digits


@pytest.mark.usefixtures("programs_here")
def test_the_missed_part_is_what_corotational_elements_add(tmp_path):
    across = np.array([-AXIS[1], AXIS[0]])
    solution = at_rest(beams(tmp_path, "", -0.3 * CANTILEVER * AXIS + 0.001 * across, "grounded"))
    found = compare_with_corotational(solution, "beam1").error / (0.001 / (3 * BENDING))
    u = np.pi / 2 * np.sqrt(0.3)
    of_a_tip_force = 3 * (np.tan(u) - u) / u**3 - 1
    assert found == pytest.approx(of_a_tip_force, rel=5e-3)  # straight elements: (pi h / 2 L)^2 = 6e-3 bounds their error
    # the tip force bends nearly into the shape of buckling, for which most is missed
    assert 0.98 < of_a_tip_force / compression(solution).missed <= 1


@pytest.mark.parametrize("part", [0.05, 0.1, 0.5])
def test_one_body_with_a_moving_frame_misses_what_the_closed_form_of_a_column_says(tmp_path, part):
    solution = at_rest(with_moment(beams(tmp_path, PINNED, -part * COLUMN * AXIS)))
    k = np.pi * np.sqrt(part)
    true = MOMENT / (part * COLUMN) * (1 - k / np.tan(k))  # rotation of the end that the moment acts on
    missed = compression(solution).missed
    # this moment is not the worst of all lateral loads, but nearly
    assert 1 + 0.9 * missed < true / float(solution.q[0, 2]) <= 1 + missed


# motions


@pytest.mark.parametrize("held", [PINNED, SLIDING])
def test_a_motion_knows_the_load_of_its_largest_compression(tmp_path, held):
    solution = simulate(compile_scene(read_scene(beams(tmp_path, held, -0.6 * COLUMN * AXIS))))
    found = compression(solution)
    # the load grows within 0.2 s, a hundred periods of the axial vibration or more, and inertia adds little
    assert found.load == pytest.approx(0.6, rel=2e-3)
    assert found.time > 0.15
    assert "critical-load" in solution.verdict.codes


def test_what_a_motion_misses_is_known_to_be_less_than_any_larger_part_alone(tmp_path):
    """Of a column of load mu: mu / (1 - mu)."""
    solution = simulate(compile_scene(read_scene(beams(tmp_path, "", -0.3 * CANTILEVER * AXIS, "grounded"))))
    scene, last = solution.system.scene, len(solution.times) - 1
    known = {body: geometric_stiffness.stiffening(scene, body) for body in flexible_bodies(scene)}
    assert critical_load.misses_less(solution, known, last, 1.02 * 0.3 / 0.7)
    assert not critical_load.misses_less(solution, known, last, 0.98 * 0.3 / 0.7)


# what is said


@pytest.mark.parametrize(("part", "said"), [(0.02, False), (0.2, True), (0.6, True), (5.8, True)])
def test_verdict_and_json_say_it(tmp_path, part, said):
    """At 0.2 of it the first frequency is 1 / sqrt(0.8) = 1.12 of the true one. What is straight is shortened as it should be."""
    path = beams(tmp_path, "", -part * CANTILEVER * AXIS, "grounded")
    for command in (["statics"], ["modes"]):
        run = CliRunner().invoke(app, [command[0], str(path), *command[1:], "--json"])
        record = json.loads(run.stdout)
        texts = [each["text"] for each in record["warnings"] if each["code"] == "critical-load"]
        assert bool(texts) == said, command
        straight = command == ["statics"] and part < 1
        assert record["verdict"]["trusted"] == (straight or not said), command
        how = "carries" if straight else "is compressed with"
        assert all(f"beam1 {how} {part:.2g} times the critical load" in text for text in texts[:1])


@pytest.mark.parametrize(
    ("frames", "across", "variable", "trusted"),
    [
        (1, 0.0, None, True),
        (1, 1e-6, None, False),
        (1, 0.0, "t", True),
        (1, 0.0, "F", False),
        (2, 0.0, "t", True),
        (2, 0.0, "turned", False),
        (2, 1e-4, None, False),
    ],
)
def test_a_column_that_nothing_bends_is_right_below_its_critical_load(frames, across, variable, trusted, tmp_path):
    """It is shortened by P L / E A, by d / dt as -1 / t of it; what bends it, or would as a derivative says, is 31 % off with two."""
    force = 0.9 * np.pi**2 / 4 * EI
    scene = cantilever(tmp_path, STRAIGHT, frames, in_space((-force, across * EI)))
    solution = solve(prepare(scene, [variable] if variable else []), "static")
    assert solution.verdict.trusted == trusted
    assert "critical-load" in solution.verdict.codes
    if trusted:
        axis, stretch = np.array(in_space((1.0, 0.0))), force / (FRAMED.youngs_modulus * FRAMED.thickness * FRAMED.width)
        end = node_places(solution, "beam")[-1, -1] - np.array([0.3, -0.2])
        assert end == pytest.approx((1 - stretch) * axis, abs=1e-9 * stretch)  # round-off of EA against EI


def test_a_least_frequency_depends_on_what_a_straight_column_lacks(tmp_path):
    """As any frequency does: that of the true column is far below."""
    scene = cantilever(tmp_path, STRAIGHT, 1, in_space((-0.9 * np.pi**2 / 4 * EI, 0.0)))
    softest = scene.model_copy(update={"responses": {"f": LeastFrequency()}})
    assert not solve(prepare(softest, []), "static").verdict.trusted
    assert solve(prepare(scene, []), "static").verdict.trusted


@pytest.mark.parametrize(("moment", "straight"), [(0.0, True), (1e-9, False)])
def test_a_hair_that_bends_a_fine_column_is_felt(moment, straight, tmp_path, monkeypatch):
    """A moment of 1e-9 of Euler's load bends it by 2e-6 of its shortening, a tenth of what is true: with 300 elements too."""
    monkeypatch.setattr(f"{__name__}.ELEMENTS", 300)
    monkeypatch.setattr(f"{__name__}.MOMENT", moment * COLUMN)
    path = with_moment(beams(tmp_path, PINNED, COLUMN * (-0.9 * AXIS)))
    assert solve(prepare(read_scene(path), []), "static").verdict.trusted == straight


def test_gradients_by_the_adjoint_are_not_known_to_be_straight(tmp_path):
    model = ffrf.compile(cantilever(tmp_path, STRAIGHT, 1, in_space((-0.9 * np.pi**2 / 4 * EI, 0.0))), variables=["F"])
    for method in ("direct", "adjoint"):
        assert not model.statics(gradients=method).verdict.trusted
    assert model.statics().verdict.trusted


@pytest.mark.parametrize(("model", "said"), [("morphing_wing", False), ("rotating_beam", False), ("snap_through", True)])
def test_of_the_models_only_the_arch_that_snaps_is_near(model, said):
    warnings = simulate(compile_scene(read_scene(MODELS / model / "scene.toml"))).warnings
    assert [each.doubt for each in warnings if each.code == "critical-load"] == [
        True
    ] * said  # which large deformation makes a doubt, too


@pytest.mark.parametrize(("frames", "part", "said"), [(2, 0.9, True), (4, 0.9, True), (4, 0.99, True), (16, 0.9, False)])
def test_a_column_of_several_frames_near_its_critical_load_says_by_how_much_it_is_too_stiff(frames, part, said, tmp_path):
    """Its parts lose hardly any stiffness of their own, and the whole nearly all; exact is q / (P k) (tan k L - k L), k^2 = P / E I."""
    euler, across = np.pi**2 / 4 * EI, 1e-4 * EI
    solution = solve(prepare(cantilever(tmp_path, STRAIGHT, frames, in_space((-part * euler, across)))), "static")
    k = np.pi / 2 * np.sqrt(part)
    exact = across / (part * euler * k) * (np.tan(k) - k)
    end = (node_places(solution, "beam")[-1, -1] - node_places(solution, "beam")[-1, 0]) @ in_space((0.0, 1.0))
    lacks = exact / end - 1
    found = [each for each in solution.verdict.warnings if each.code == "critical-load"]
    assert bool(found) == said == (lacks > critical_load.LIMIT)
    if said:
        missed = compression(solution).missed
        assert lacks < missed < 1.05 * lacks  # the largest over all lateral loads, of which one at the end is nearly the worst
        assert not solution.verdict.trusted
        assert "cut beam into more frames" in found[0].text


def test_forces_that_compress_nothing_are_not_told_in_parts_of_a_critical_load(monkeypatch, tmp_path):
    """Whatever else the equations miss: eigenvalues leave 1e-18 of a load that is not there."""
    found = Compression("beam", 0.0, 1.7e-18, 0.06, 0.0, False)
    monkeypatch.setattr(physics, "critical_compressions", lambda _: iter([found]))
    (caution,) = physics.critical_loads(at_rest(beams(tmp_path, "", np.array([1.0, 0.0]), "grounded")))
    assert not caution.doubt
    assert "times the critical load" not in caution.text
