"""The small-deformation meter: against closed forms, against corotational elements, and what the commands say of it."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from preprocessing import build
from preprocessing.builders.frame_recipe import polygon_beam
from preprocessing.reduction.basis import BasisChoice
from tests.models.frames import SECTION, cantilever, ring
from tests.models.rectangular_beams import linear_chain, points_of, rectangles
from tests.models.scenes import hanging_skin
from toolkit.analyses.sensitivity.preparation import prepare, solve
from toolkit.command_line.cli import app
from toolkit.command_line.run_answer import deformation_record, deformation_table
from toolkit.components.bodies.model_body import FRAME
from toolkit.description.design import BodyPoint
from toolkit.files.scene_reader import read_scene
from toolkit.foundation import processes
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.file import load, save
from toolkit.responses.joint_force import JointForce
from toolkit.scene.resolution import loaded, resolve
from toolkit.validity.bodies.chain import (
    mean_rows,
    second_order_forces,
    stiffness_matrix,
)
from toolkit.validity.bodies.corotational_beams import Corotational, compare_with_corotational, compared
from toolkit.validity.bodies.critical_speed import critical_speed
from toolkit.validity.bodies.deformation import INSTANTS, LIMIT, deformation, deformations, divided, largest_instants
from toolkit.validity.bodies.known_chain import PlanarChain, chain, planar_chain

pytestmark = pytest.mark.usefixtures("programs_here")

MODELS = Path(__file__).parents[2] / "models"
WING, SPINNING = (str(MODELS / name / "scene.toml") for name in ("morphing_wing", "rotating_beam"))
FACTOR = 1.5
"""The estimate is within this factor of the truth as long as elements turn by less than 0.7 rad."""


def uniform(frame, held: np.ndarray) -> PlanarChain:
    return linear_chain(frame.nodes, frame.connectivity, held, rectangles(len(frame.connectivity), 70000.0, 0.5, 10.0))


def straight(n: int) -> PlanarChain:
    return uniform(cantilever(n), np.eye(3, 3 * n + 3))


def stiffness_of(behind: PlanarChain) -> float:
    """E I of each element."""
    return behind.made_of.bending_stiffness[0, 0]


def linear(behind: PlanarChain, load: np.ndarray) -> np.ndarray:
    """Displacements of the chain clamped at its first node, exact for a straight beam."""
    u = np.zeros(len(load))
    u[3:] = np.linalg.solve(stiffness_matrix(behind.forms)[3:, 3:], load[3:])
    return u


def distances(u: np.ndarray) -> np.ndarray:
    return np.hypot(u[0::3], u[1::3])


def true_error(behind: PlanarChain, u: np.ndarray) -> float:
    return compared(behind, points_of(len(behind.connectivity)), u, u).error


# what the elements are made of


def test_sections_of_the_wing_are_those_of_its_skin_file_and_follow_the_scene():
    for changes, modulus, thickness in ({}, 70000.0, 1.5), ({"thickness": "1.6", "youngs_modulus": "65000.0"}, 65000.0, 1.6):
        found = chain(loaded(read_scene(WING, {f"bodies.skin.{name}": value for name, value in changes.items()})), "skin").made_of
        np.testing.assert_allclose(found.stress_per_strain, modulus, rtol=1e-14)
        np.testing.assert_allclose(found.axial_stiffness, modulus * thickness * 1000.0, rtol=1e-14)
        np.testing.assert_allclose(found.bending_stiffness[:, 0], modulus * thickness**3 * 1000.0 / 12, rtol=1e-14)


BASES = {
    "full": BasisChoice("full"),
    "craig-bampton": BasisChoice("craig-bampton", count=6),
    "eigenmodes": BasisChoice("eigenmodes", count=8),
    "free": BasisChoice("eigenmodes", boundary="free", count=8),
}


def arc(n: int = 10) -> np.ndarray:
    return ring(2 * n, 50.0).nodes[: n + 1]


def _length(nodes: np.ndarray) -> float:
    return np.linalg.norm(np.diff(nodes, axis=0), axis=1).sum()


@pytest.mark.parametrize("kind", BASES)
def test_elements_behind_any_basis_are_those_that_its_matrices_were_made_of(kind):
    """Psi^T K Psi of the elements is the stiffness of the model, and their stress at rest its stress operator."""
    model = polygon_beam(arc(), SECTION, {"start": 0.0, "end": float(_length(arc()))}, "mm-t-s", basis=BASES[kind])
    behind = planar_chain(DesignPoint(model))
    mine, whole = behind.shapes.T @ stiffness_matrix(behind.forms) @ behind.shapes, model.invariants.stiffness
    scale = np.sqrt(np.outer(np.diag(whole), np.diag(whole)))
    np.testing.assert_allclose(mine / scale, whole / scale, atol=1e-6)  # K psi of shapes that hardly stretch loses digits
    turning = Corotational(behind.nodes, behind.connectivity, behind.made_of)
    for shape, told in zip(behind.shapes.T, model.invariants.stress_operator.T, strict=True):
        np.testing.assert_allclose(turning.linear_stress(shape, model.stress), told, atol=1e-9 * np.abs(told).max())


def test_sections_that_differ_between_elements_are_kept_one_by_one():
    """Every element with a modulus, thickness and width of its own; the model knows them by name only."""
    model = polygon_beam(arc(4), SECTION, {}, "mm-t-s", separate=("youngs_modulus", "thickness", "width"))
    wanted = {f"{name}_{e}": getattr(SECTION, name) * (1 + 0.1 * e) for name in ("youngs_modulus", "width") for e in range(4)}
    wanted |= {f"thickness_{e}": SECTION.thickness * (1 - 0.1 * e) for e in range(4)}
    found = planar_chain(DesignPoint(model, wanted)).made_of
    modulus, thickness, width = ([wanted[f"{name}_{e}"] for e in range(4)] for name in ("youngs_modulus", "thickness", "width"))
    np.testing.assert_allclose(found.stress_per_strain, modulus, rtol=1e-14)
    np.testing.assert_allclose(found.axial_stiffness, np.prod([modulus, thickness, width], axis=0), rtol=1e-14)
    np.testing.assert_allclose(found.fibre_distance[0::4, 0], -np.array(thickness) / 2, rtol=1e-14)


# the displacement of second order


def test_second_order_forces_are_what_corotational_elements_add_to_linear_ones():
    """[f(h u) - h K u] / h^2 = f_2(u) + O(h)."""
    frame = ring(9, 50.0)
    behind, u = uniform(frame, np.eye(3, 27)), np.random.default_rng(1).normal(size=27)
    body, exact = Corotational(behind.nodes, behind.connectivity, behind.made_of), second_order_forces(behind.forms, u[None])[0]
    stiffness, sizes = stiffness_matrix(behind.forms), np.array([1e-3, 5e-4, 2.5e-4])
    rest = [np.abs((body.force(h * u) - h * (stiffness @ u)) / h**2 - exact).max() for h in sizes]
    assert np.polyfit(np.log(sizes), np.log(rest), 1)[0] == pytest.approx(1, abs=0.02)  # terms of fourth order are 1e-2


def test_an_end_moment_shortens_a_cantilever_by_a_sixth_of_the_angle_squared():
    """Linear: no shortening. Arc of a circle: 1 - sin(a) / a = a^2 / 6. With n elements the chords turn: 1 - 1 / (4 n^2) of that."""
    n, angle = 20, 0.1
    behind = straight(n)
    load = np.zeros(3 * n + 3)
    load[-1] = stiffness_of(behind) * angle / 100.0
    u = linear(behind, load)
    u_2 = behind.second_order(u[None])[0]
    chords = (np.arange(n) + 0.5) / n
    np.testing.assert_allclose(u_2[-3], -100.0 * angle**2 / 2 * np.mean(chords**2), rtol=1e-8)  # condition times round-off
    np.testing.assert_allclose(u_2[-3], -100.0 * angle**2 / 6, rtol=1 / (2 * n**2))
    np.testing.assert_allclose(u_2[-2], 0, atol=1e-8 * angle)


def test_tension_stiffens_a_cantilever_as_the_theory_of_second_order_says():
    """Pull N and push Q at the tip: deflection Q L^3 / 3 E I less N Q L^5 (2/15) / (E I)^2, the first term of Q / N (L - tanh(k L) / k)."""
    n, push, pull = 16, 1e-3, 1e-2
    behind = straight(n)
    load = np.zeros(3 * n + 3)
    load[-3], load[-2] = pull, push
    u_2 = behind.second_order(linear(behind, load)[None])[0]
    expected = -2 / 15 * pull * push * 100.0**5 / stiffness_of(behind) ** 2
    np.testing.assert_allclose(u_2[-2], expected, rtol=2 / n**2)  # the geometric stiffness of straight chords


@pytest.mark.parametrize("angle", [0.01, 0.1, 0.3, 0.7])
@pytest.mark.parametrize("kind", ["moment", "force"])
def test_the_estimate_for_a_cantilever_is_within_its_factor_of_corotational_elements(kind, angle):
    n = 20
    behind = straight(n)
    load = np.zeros(3 * n + 3)
    if kind == "moment":
        load[-1] = stiffness_of(behind) * angle / 100.0
    else:
        load[-2] = 2 * stiffness_of(behind) * angle / 100.0**2
    u = linear(behind, load)
    estimate = distances(behind.second_order(u[None])[0]).max()
    assert 1 / FACTOR < estimate / true_error(behind, u) < FACTOR


def test_a_free_body_is_measured_against_its_mean_motion():
    """A straight free beam between opposite end moments: it bends symmetrically, and its ends come nearer by a^2 L / 24 in all."""
    n, angle = 20, 0.1
    frame = cantilever(n)
    held = mean_rows(frame.nodes, frame.connectivity)
    behind = uniform(frame, held)
    s = np.linspace(-0.5, 0.5, n + 1)
    u = np.column_stack([0 * s, 50.0 * angle * s**2, angle * s]).ravel()
    u_2 = behind.second_order(u[None])[0].reshape(-1, 3)
    np.testing.assert_allclose(u_2[0, 0] - u_2[-1, 0], 100.0 * angle**2 / 24, rtol=2 / n**2)  # the chords turn less than the ends
    np.testing.assert_allclose(held @ u_2.ravel(), 0, atol=1e-8)


# the meter of a run


def wing(factor: float, kind: str = "static", **changes: str):
    return solve(prepare(read_scene(WING, {"loads.drive.torque": str(4200 * factor), **changes})), kind)


@pytest.mark.parametrize("factor", [0.1, 0.5, 1.0, 1.5])
def test_the_estimate_for_the_wing_is_within_its_factor_of_corotational_elements(factor):
    found = compare_with_corotational(wing(factor), "skin")
    assert 1 / FACTOR < found.estimate.error / found.error < FACTOR


def test_craig_bampton_shapes_give_the_same_numbers_as_all_coordinates(tmp_path):
    """They are statically exact at the joints; round-off of the shapes at the clamped node must not look like a free body."""
    shutil.copytree(MODELS / "morphing_wing", tmp_path, dirs_exist_ok=True)
    skin = tmp_path / "skin.toml"
    skin.write_text(skin.read_text() + '\n[basis]\nkind = "craig-bampton"\ncount = 10\n')
    save(build(skin), tmp_path / "skin.h5")
    reduced = compare_with_corotational(solve(prepare(read_scene(tmp_path / "scene.toml")), "static"), "skin")
    full = compare_with_corotational(wing(1.0), "skin")
    for name in ("error", "stress_error"):
        assert getattr(reduced, name) == pytest.approx(getattr(full, name), rel=1e-4)  # digits that stiff tension leaves
    assert reduced.estimate.error == pytest.approx(full.estimate.error, rel=1e-4)


def test_in_motion_the_end_of_the_wing_is_as_in_statics():
    """The torque rises in a second, a hundred times slower than the wing swings."""
    still, moving = deformation(wing(1.0), "skin"), deformation(wing(1.0, "transient"), "skin")
    assert moving.error == pytest.approx(still.error, rel=1e-3)  # what swings on
    assert moving.time > 0.9


def test_the_forces_of_the_check_are_those_of_the_joints():
    """K u at the nodes that the joints grip; nothing elsewhere."""
    solution = wing(1.0)
    behind = chain(solution.system.scene, "skin")
    u = behind.displacements(np.real(solution.q[:, solution.coordinates("skin")]))[0]
    forces = (stiffness_matrix(behind.forms) @ u).reshape(-1, 3)
    signs = {"C": (10, -1), "E": (25, -1), "G": (30, 1)}  # a joint exerts its force on its first body
    for joint, (node, sign) in signs.items():
        expected = [sign * JointForce(joint=joint, component=name).value(solution) for name in ("x", "y", "torque")]
        np.testing.assert_allclose(forces[node], expected, atol=1e-4)  # E A u is 7e5 N per mm: round-off of u, in N and N mm
    np.testing.assert_allclose(np.delete(forces, [0, 10, 25, 30], axis=0), 0, atol=1e-4)


def test_a_body_with_a_moving_frame_is_measured_in_its_frame():
    """Hung from a pendulum and a rod, or the whole scene turned by a right angle with its gravity: the same numbers."""
    solution = solve(prepare(hanging_skin()), "transient")
    turned = replace(solution, q=solution.q + np.eye(solution.q.shape[1])[solution.coordinates("skin").start + 2] * np.pi / 2)
    assert deformation(solution, "skin") == deformation(turned, "skin")
    found = compare_with_corotational(solution, "skin")
    assert 1 / FACTOR < found.estimate.error / found.error < FACTOR


def test_a_body_that_does_not_deform_is_exact_and_not_zero_by_zero():
    solution = wing(1.0)
    rest = replace(solution, q=0 * solution.q)
    found = deformation(rest, "skin")
    assert (found.error, found.displacement, found.relative, found.exceeded) == (0, 0, 0, False)


def test_of_long_runs_the_instants_of_the_largest_coordinates_count():
    elastic = np.sin(np.linspace(0, 20, 5000))[:, None] * [1.0, 1e-6]
    found = largest_instants(elastic)
    assert len(found) == INSTANTS
    assert np.abs(elastic[found, 0]).min() > 0.999
    assert np.array_equal(found, np.sort(found))


def test_critical_speed_of_the_beam_is_its_lowest_clamped_frequency():
    """omega = 1.8751^2 sqrt(E I / rho A) / L^2, less 4.6478 I / (2 A L^2) of it by rotary inertia (int w'^2 / int w^2 of that mode)."""
    exact = 1.875104068711961**2 * np.sqrt(210e9 * 0.02**2 / 12 / 7800.0) * (1 - 4.6478 * 0.02**2 / 24)
    assert critical_speed(loaded(read_scene(SPINNING)), "beam") == pytest.approx(exact, rel=1e-5)  # 20 cubic elements


# what the commands say


def run(*arguments: str):
    return CliRunner().invoke(app, list(arguments))


def test_the_wing_is_reported_and_warned_about():
    done = run("statics", WING, "--json")
    assert done.exit_code == 0
    found = json.loads(done.stdout)["deformation"]["skin"]
    assert found["geometric_error"]["unit"] == "mm"
    assert found["relative_to_displacement"] > found["limit"] == LIMIT
    assert "warning: skin leaves the range of small deformations" in done.stderr
    quiet = run("statics", WING, "--quiet")
    assert "geometric error, mm" in quiet.stdout
    assert quiet.stderr == ""


def test_a_wing_under_a_small_load_is_reported_without_warning():
    done = run("statics", WING, "--set", "loads.drive.torque=420", "--json")
    assert 0 < json.loads(done.stdout)["deformation"]["skin"]["relative_to_displacement"] < LIMIT
    assert "warning" not in done.stderr


def test_scenes_without_flexible_bodies_print_nothing_of_it():
    scene = str(MODELS / "pendulum" / "scene.toml")
    changes = ("--set", "solver.end_time=0.01")
    assert "deformation" not in json.loads(run("simulate", scene, *changes, "--json").stdout)
    assert "deformation" not in run("simulate", scene, *changes).stdout
    refused = run("check-deformation", scene, *changes)
    assert refused.exit_code == 1
    assert "no body of the scene is flexible" in refused.stderr


def test_a_model_without_mesh_has_no_number_and_says_so(tmp_path):
    shutil.copytree(MODELS / "morphing_wing", tmp_path, dirs_exist_ok=True)
    save(replace(load(tmp_path / "skin.h5"), mesh=None), tmp_path / "skin.h5")
    scene = str(tmp_path / "scene.toml")
    solution = solve(prepare(read_scene(scene)), "static")
    found = deformations(solution)
    assert deformation_record(solution, found) == {"skin": None}
    assert deformation_table(solution, found).rows == [("skin", *["not available"] * 5)]
    refused = run("check-deformation", scene, "--static")
    assert refused.exit_code == 1
    assert "does not hold its mesh" in refused.stderr


SHORT = ("--set", "solver.end_time=0.05")


def test_a_beam_below_its_critical_speed_runs_without_warning():
    done = run("simulate", SPINNING, *SHORT)
    assert done.exit_code == 0
    assert "critical speed" not in done.stdout + done.stderr


def test_a_beam_beyond_its_critical_speed_is_warned_about():
    """It should stretch by 0.2 mm, and bends out by half its length: linear FFRF lacks centrifugal stiffening."""
    done = run("simulate", SPINNING, "--set", "solver.end_time=0.1", "--set", "bodies.beam.angular_velocity=120.0", "--json")
    assert done.exit_code == 0
    found = json.loads(done.stdout)["deformation"]["beam"]
    assert found["largest_displacement"]["value"] > 0.1
    assert found["relative_to_displacement"] > 0.5
    spins = done.stderr.index("beam spins with 120 rad/s, faster than its critical speed of 105.3 rad/s")
    assert spins < done.stderr.index("beam leaves the range of small deformations")


DRIVE = """
[joints.motor]
type = "angle-driver"
bodies = ["beam", "ground"]
point = "hub"
curve = { type = "smooth-step", duration = 0.4, height = 80.0 }
"""


def test_a_beam_that_comes_to_spin_too_fast_diverges_with_a_word_of_its_critical_speed(tmp_path):
    """Up to 375 rad/s on the way: the run ends where the deflection has grown beyond what Newton can resolve."""
    text = Path(SPINNING).read_text().replace("[design]", DRIVE + "\n[design]").replace(", angular_velocity = 50.0", "")
    shutil.copy(MODELS / "rotating_beam" / "beam.h5", tmp_path / "beam.h5")
    (tmp_path / "scene.toml").write_text(text)
    done = run("simulate", str(tmp_path / "scene.toml"))
    assert "critical speed" in done.stderr


BRIEFLY = ("--variables", "t_w")
"""The whole mechanism is solved again at two values of each variable."""


def test_check_deformation_reads_scenes_and_results_alike(tmp_path):
    kept = str(tmp_path / "wing.h5")
    assert run("statics", WING, "--output", kept).exit_code == 0
    of_results = json.loads(run("check-deformation", kept, *BRIEFLY, "--json").stdout)["deformation"]["skin"]
    of_scene = json.loads(run("check-deformation", WING, "--static", *BRIEFLY, "--json").stdout)["deformation"]["skin"]
    assert of_results == of_scene
    assert of_scene["stress_error"]["value"] > 1.0
    assert "Leave it out" in run("check-deformation", kept, "--static").stderr


def test_check_deformation_needs_no_preprocessing(monkeypatch):
    monkeypatch.setattr(processes, "is_installed", lambda: False)
    done = run("check-deformation", WING, "--static", *BRIEFLY, "--json")
    assert json.loads(done.stdout)["deformation"]["skin"]["error"]["value"] > 0.1


def test_more_frames_are_advised_with_what_they_refuse():
    """A body with several frames has no point at the origin of its frame: who follows the advice has to move what is there."""
    scene = read_scene(MODELS / "morphing_wing" / "scene.toml")
    held = scene.model_copy(update={"points": {**scene.points, "P": BodyPoint(body="skin", interface=FRAME)}})
    assert "P, now at '(frame)', at an interface point" in divided(resolve(held), "skin", 4.0)
    assert FRAME not in divided(resolve(scene), "skin", 4.0)
