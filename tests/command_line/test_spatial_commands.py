"""A scene in space through all commands that need no picture, and what they say about its bodies."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

from preprocessing import build
from tests.command_line.test_cli import record, refused, run
from tests.models.spatial_cases import write_models
from tests.models.spatial_every_number import SCENES
from tests.scene.test_wrong_spatial_scenes import DOOR
from toolkit.analyses.sensitivity.run import restored
from toolkit.analyses.transient import simulate
from toolkit.description.run_options import RunOptions
from toolkit.files.results_file import load_results
from toolkit.files.scene_reader import read_scene
from toolkit.reduced_model.file import save
from toolkit.scene.resolution import loaded
from toolkit.studies.stability.maps import load_map, mass_map, speed_map, stiffness_map
from toolkit.system.system import compile_scene
from toolkit.validity.bodies.critical_speed import critical_speed, too_fast_at_start, too_fast_in_motion

FLAG = """units = "m-kg-s"
dimension = 3

[points]
root = { body = "flag", interface = "end" }
middle = { body = "flag", interface = "middle" }
free = [0.0, 2.0, 0.5]
tip = { body = "mast", interface = "end" }

[bodies]
flag = { type = "flexible", model = "frame.h5", frame = "moving", position = [0.5, 0.4, -0.3], angular_velocity = [0.0, 0.0, 0.1] }
mast = { type = "flexible", model = "frame.h5", frame = "grounded", position = [0.5, 0.4, -0.3] }
rubber = { type = "flexible", model = "solid.h5", frame = "grounded", position = [4.0, 0.0, 0.0] }

[joints]
hinge = { type = "revolute", bodies = ["flag", "mast"], point = ["root", "tip"], axis = [0.0, 0.0, 1.0] }

[loads]
spring = { type = "spring-damper", bodies = ["flag", "ground"], points = ["middle", "free"], stiffness = 0.3, damping = 0.1 }
wind = { type = "pressure", body = "rubber", surface = "top", pressure = 0.01 }

[responses]
strain = { type = "strain-energy" }
peak = { type = "ks-stress", body = "flag", aggregation = 20.0, reference_stress = 1.0 }

[design]
k = "loads.spring.stiffness"
rho = "bodies.mast.density_stuff"

[solver]
end_time = 0.05
step = 0.005
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("scenes")
    write_models(path)
    (path / "door.toml").write_text(DOOR)
    (path / "flag.toml").write_text(FLAG)
    return path


@pytest.mark.parametrize("name", ["door", "flag"])
def test_results_of_a_scene_in_space_are_kept_restored_and_exported(name, folder, tmp_path):
    scene, kept = str(folder / f"{name}.toml"), tmp_path / "results.h5"
    found = record("sensitivity", scene, "--method", "direct", "--output", str(kept))
    results = load_results(kept)
    solution = restored(results).solution
    np.testing.assert_array_equal(solution.q, results.q)
    fresh = simulate(compile_scene(read_scene(scene)))
    np.testing.assert_allclose(solution.q, fresh.q, rtol=0, atol=1e-12)  # the same steps, without derivatives
    assert record("inspect", str(kept))["sizes"]["coordinates"] == results.q.shape[1]
    assert run("export", str(kept), "--csv", str(tmp_path)).exit_code == 0
    with (tmp_path / "responses.csv").open() as file:
        rows = {row[0]: float(row[1]) for row in list(csv.reader(file))[1:]}
    assert rows == {response: each["value"] for response, each in found["responses"].items()}
    for body in results.bodies.values():
        assert len(set(body.stress_points)) == body.stress.shape[1]  # every column has a name of its own
    assert results.bodies.keys() == ({"flag", "mast", "rubber"} if name == "flag" else set())


@pytest.mark.parametrize("name", ["door", "flag"])
def test_equilibrium_and_modes_of_a_scene_in_space(name, folder):
    scene = str(folder / f"{name}.toml")
    assert run("statics", scene, "--json").exit_code == 0
    frequencies = record("modes", scene)["frequencies"]["value"]
    assert min(frequencies) > 0


def test_methods_agree_on_the_gradient_of_a_scene_in_space(folder):
    assert run("certify", str(folder / "door.toml"), "--no-fresh", "--set", "solver.end_time=0.03").exit_code == 0


def test_the_cost_summary_counts_what_a_spatial_scene_has_and_what_it_drops(folder):
    cost_summary = json.loads(run("inspect", str(folder / "flag.toml"), "--json", "--no-measure").stdout)["cost_summary"]
    lines = {
        section: {line["what"]: (line["kept"], line["dropped"]) for line in each}
        for section, each in cost_summary.items()
        if section not in ("cost", "meshes")
    }
    assert lines["coordinates"] == {"flag": (7 + 12, 0), "mast": (12, 7), "rubber": (12, 7)}
    rows = {"1 revolute": (5, 0), "1 lengths of quaternions": (1, 0), "frame of mast": (0, 7), "frame of rubber": (0, 7)}
    assert lines["constraint rows"] == rows
    kept, dropped = lines["bytes of solid.h5"]["surface_loads"]
    assert (kept > 0, dropped) == (True, 0)
    ways = {each["what"]: each["coordinates"] for each in cost_summary["cost"]}
    assert ways["with coordinates of grounded frames"] == ways["motion alone"] + 14


@pytest.mark.parametrize("name", ["door", "flag"])
def test_the_motion_is_the_same_with_everything_put_back(name, folder):
    scene = str(folder / f"{name}.toml")
    lean, whole = (record("simulate", scene, *more)["responses"] for more in ((), ("--keep-all",)))
    for response, each in lean.items():
        assert whole[response]["value"] == pytest.approx(
            each["value"], rel=1e-6
        )  # second order of the steps, with frames that are held


def test_the_deformation_check_says_that_it_knows_beams_only(folder):
    said = refused("check-deformation", str(folder / "flag.toml"))
    assert "body 'rubber' does not consist of beams," in said
    assert "[pieces] in its file" in said


def test_stability_maps_vary_numbers_of_a_scene_in_space(folder):
    scene = SCENES["frames"](folder)
    for make, path in (
        (mass_map, "bodies.wheel.inertia.3"),
        (load_map, "loads.wind.pressure"),
        (speed_map, "bodies.strip.angular_velocity.1"),
        (stiffness_map, "bodies.rubber.youngs_modulus"),
    ):
        found = make(scene)
        last = list(found.scenes)[-1]
        assert abs(found.scenes[last].number(path)) > abs(scene.number(path))


SHAFT = """units = "m-kg-s"
clamp = ["A"]
nodes = { A = [0.0, 0.0, 0.0], B = [1.0, 0.0, 0.0] }
beams = [{ from = "A", to = "B", section = "bar", elements = 5 }]
sections = { bar = { kind = "rectangle", thickness = 0.01, width = 0.02, material = "steel" } }
materials = { steel = { youngs_modulus = 2e11, poisson_ratio = 0.3, density = 7800.0 } }
interface_points = { end = { node = "B" } }
"""
SPIN = """units = "m-kg-s"
dimension = 3
points = {{ end = {{ body = "shaft", interface = "end" }} }}
bodies = {{ shaft = {{ type = "flexible", model = "shaft.h5", frame = "{frame}", orientation = [0.0, 0.0, 0.5], {more} }} }}
"""


@pytest.fixture(scope="module")
def shaft(tmp_path_factory):
    path = tmp_path_factory.mktemp("shaft")
    (path / "shaft.toml").write_text(SHAFT)
    save(build(path / "shaft.toml"), path / "shaft.h5")

    def scene(frame: str, more: str):
        (path / "scene.toml").write_text(SPIN.format(frame=frame, more=more))
        return read_scene(path / "scene.toml")

    return scene


def bending(depth: float) -> float:
    """Lowest frequency of a clamped bar, in rad/s: 1.8751^2 sqrt(E I / (rho A)), L = 1."""
    return 1.8751040687**2 * np.sqrt(2e11 * depth**2 / 12 / 7800.0)


def test_critical_speeds_of_a_bar_are_its_frequencies_across_each_axis(shaft):
    scene = shaft("moving", "angular_velocity = [1.0, 0.0, 0.0]")
    # rotary inertia is 1e-4 of the mass here, five cubic elements err by 1e-5
    for axis, depth in zip(np.eye(3), (0.01, 0.02, 0.01), strict=True):
        assert critical_speed(loaded(scene), "shaft", axis) == pytest.approx(bending(depth), rel=1e-3)


@pytest.mark.parametrize("part", [0.9, 1.1])
@pytest.mark.parametrize("frame", ["moving", "turning"])
def test_a_bar_that_starts_too_fast_is_named_with_its_speed(frame, part, shaft):
    """Its axes are turned by 0.5 rad about z, about which it spins."""
    speed = float(part * bending(0.01))
    axis = "axis = [0.0, 0.0, 1.0], " if frame == "turning" else ""
    scene = shaft(frame, f"{axis}angular_velocity = [0.0, 0.0, {speed!r}]")
    wanted = [("shaft", pytest.approx(speed, rel=1e-3), pytest.approx(bending(0.01), rel=1e-3))] if part > 1 else []
    assert list(too_fast_at_start(loaded(scene))) == wanted
    run_of = simulate(compile_scene(scene), RunOptions(end_time=1e-4, step=1e-5))
    assert list(too_fast_in_motion(run_of)) == wanted
