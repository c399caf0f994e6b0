"""Gradients end to end: those from the reduced model's derivatives against preprocessing afresh, gmsh included, at other designs."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from preprocessing import build
from preprocessing.builders.frame_recipe import polygon_beam
from preprocessing.elements.section import Section
from toolkit.analyses.sensitivity.certificate.fresh_models import disagreements, fresh_gradients
from toolkit.analyses.sensitivity.direct import direct
from toolkit.analyses.sensitivity.preparation import values_of
from toolkit.analyses.sensitivity.run import Run
from toolkit.files.scene_reader import read_scene
from toolkit.reduced_model.file import load, save
from toolkit.scene.scene import Scene

WING = Path(__file__).parents[2] / "models" / "morphing_wing"
CHANGES = {
    "loads.drive.curve.duration": "0.02", "solver.end_time": "0.02", "solver.step": "0.002", "solver.tolerance": "1e-12",
    "responses.max_stress.aggregation": "1.0",
}  # fmt: skip
MORE = """
[groups.nose]
elements = [4, 7]
thickness = 1.3

[shape.bulge]
arc_length = 60.0
half_width = 40.0
"""
BASES = {
    "full": "",
    "craig-bampton": 'kind = "craig-bampton"\ncount = 5',
    "eigenmodes": 'kind = "eigenmodes"\ncount = 9',
    "free eigenmodes": 'kind = "eigenmodes"\nboundary = "free"\ncount = 9',
    "static": 'kind = "static"',
}
VARIABLES = {
    "youngs_modulus": 70.0, "density": 1e-11, "thickness": 5e-3, "thickness_nose": 5e-3, "width": 5.0, "poisson_ratio": 1e-3,
    "damping_stiffness": 1e-5, "chord": 0.5, "y_scale": 2e-3, "bulge": 0.05, "interface_points.C.arc_length": 0.03,
}  # fmt: skip
"""Parameters, and steps of about a thousandth of what changes the wing visibly; C is only 0.8 mm from the next kink of the polygon."""


SMOOTH = ("max_stress", "shape_rmse", "drive_angle")
"""Responses without kinks; a true maximum can jump from one point to another between two designs."""
MOTION, REST = 0.1, 1.0
"""In units of the steps above; with half of them and Richardson's extrapolation the error is of fourth order. For one variable of an
equilibrium a tenth would magnify the round-off of fresh shapes, 1e-10 of a response, to 1e-6 instead of 1e-7; for all variables of a
motion, whose stress rings, ten times as much would leave an error of 1e-4."""


def project(folder: Path, basis: str) -> Scene:
    """The wing with few elements and all kinds of parameters; a body with free modes is held by a joint at F instead of by its frame."""
    for name in ("high_speed.dat", "low_speed.dat"):
        shutil.copy(WING / name, folder / name)
    text = (WING / "skin.toml").read_text()
    for old, new in {
        "elements = 30": "elements = 12",
        "C = { node = 10 }": "C = { arc_length = 98.0 }",
        "E = { node = 25 }": 'E = { x = 96.0, side = "lower" }',
        "G = { node = 30 }": "G = { node = 12 }\nF = { node = 0 }",
        "poisson_ratio = 0.35": 'poisson_ratio = 0.35\nstate = "plane-strain"',
        "stiffness = 0.0": "stiffness = 1e-4",
    }.items():
        assert old in text
        text = text.replace(old, new)
    (folder / "skin.toml").write_text(text + MORE + (f"\n[basis]\n{BASES[basis]}\n" if BASES[basis] else ""))
    scene = (WING / "scene.toml").read_text()
    if basis == "free eigenmodes":
        scene = scene.replace('frame = "grounded"', 'frame = "moving"').replace(
            "[bodies]", 'F = { body = "skin", interface = "F" }\n\n[bodies]'
        )
        scene = scene.replace("[joints]", '[joints]\nF = { type = "rigid", bodies = ["skin", "ground"], point = "F" }')
    (folder / "scene.toml").write_text(scene)
    return fresh(folder, {})


def fresh(folder: Path, values: dict[str, float]) -> Scene:
    """The scene with its reduced model built anew at other values of the parameters."""
    save(build(folder / "skin.toml", values=values), folder / "skin.h5")
    return read_scene(folder / "scene.toml", CHANGES)


def path_of(parameter: str) -> str:
    """Path of a parameter's number in the scene."""
    return "points.C.arc_length" if parameter.startswith("interface_points") else f"bodies.skin.{parameter}"


def extrapolated(folder: Path, nominal: dict[str, float], steps: dict[str, float], kind: str) -> dict[str, float]:
    """Derivatives of the responses along the steps, by central differences of two sizes."""

    def difference(h: float) -> dict[str, float]:
        up, down = (
            values_of(fresh(folder, {p: nominal[p] + sign * h * step for p, step in steps.items()}), kind) for sign in (1, -1)
        )
        return {name: (up[name] - down[name]) / (2 * h) for name in up}

    step = MOTION if kind == "transient" else REST
    coarse, fine = difference(step), difference(step / 2)
    return {name: (4 * fine[name] - coarse[name]) / 3 for name in fine}


def compare(folder: Path, found: Run, kind: str, group: list[str]) -> None:
    """The directional derivative, along the parameters of a group together, against differences of fresh models."""
    nominal = {p: float(found.solution.system.scene.number(path_of(p))) for p in VARIABLES}
    expected = extrapolated(folder, nominal, {p: VARIABLES[p] for p in group}, kind)
    for response in SMOOTH:
        value = expected[response]
        parts = [found.gradients[response][path_of(p)] * VARIABLES[p] for p in group]
        # fresh eigenmodes carry round-off of 1e-10 of the response, which differences at a thousandth magnify to 1e-7
        scale = max(np.abs(parts).max(), 1e-4 * abs(found.values[response]))
        assert abs(sum(parts) - value) < 1e-6 * scale, (group, response, sum(parts), value)


@pytest.mark.parametrize("basis", BASES)
def test_gradients_are_those_of_fresh_models_in_every_basis(tmp_path, basis):
    """All parameters at once, by steps of the same visible size: an error in one of them would show."""
    found = direct(project(tmp_path, basis), [path_of(p) for p in VARIABLES], "transient")
    compare(tmp_path, found, "transient", list(VARIABLES))


@pytest.fixture(scope="module")
def equilibrium(tmp_path_factory) -> tuple[Path, Run]:
    """A folder of the project with few modes, and its equilibrium with gradients by all parameters."""
    folder = tmp_path_factory.mktemp("wing")
    return folder, direct(project(folder, "craig-bampton"), [path_of(p) for p in VARIABLES], "static")


@pytest.mark.parametrize(
    "parameter",
    [
        "thickness_nose",
        pytest.param("poisson_ratio", marks=pytest.mark.processors),
        "chord",
        "bulge",
        "interface_points.C.arc_length",
    ],
)
def test_gradients_are_those_of_fresh_models_by_single_variables(equilibrium, parameter):
    compare(*equilibrium, "static", [parameter])


@pytest.mark.usefixtures("programs_here")
def test_fresh_models_agree_and_find_a_wrong_derivative_in_the_file(tmp_path):
    """Wrong by 1 % in one item by one parameter: methods at run time agree with each other on it, fresh models do not."""
    scene, names = project(tmp_path, "craig-bampton"), ["bodies.skin.chord", "bodies.skin.bulge", "loads.drive.torque"]
    afresh = fresh_gradients(scene, names, "static", lambda *_: None)
    assert list(disagreements(afresh, direct(scene, names, "static"))) == []
    assert {name for slopes in afresh.slopes.values() for name in slopes} == {"bodies.skin.chord", "bodies.skin.bulge"}
    assert afresh.left_out == afresh.frozen == {}  # and what is no parameter is not looked for
    model = load(tmp_path / "skin.h5")
    stiffness = model.derivatives["stiffness"]
    factor = np.where(stiffness.parameter == model.numbers["chord"], 1.01, 1.0)
    spoilt = {**model.derivatives, "stiffness": replace(stiffness, value=stiffness.value * factor)}
    save(replace(model, derivatives=spoilt), tmp_path / "skin.h5")
    scene = read_scene(tmp_path / "scene.toml", CHANGES)
    afresh = fresh_gradients(scene, names[:1], "static", lambda *_: None)
    wrong = list(disagreements(afresh, direct(scene, names[:1], "static")))
    assert wrong
    assert all("bodies.skin.chord" in text for text in wrong)


@pytest.mark.usefixtures("programs_here")
def test_a_frozen_basis_is_measured_but_not_blamed(tmp_path):
    scene = project(tmp_path, "craig-bampton")
    skin = tmp_path / "skin.toml"
    skin.write_text(skin.read_text() + 'derivative = "frozen"\n')
    scene = fresh(tmp_path, {})
    afresh = fresh_gradients(scene, ["bodies.skin.thickness"], "static", lambda *_: None)
    exact = direct(scene, ["bodies.skin.thickness"], "static")
    assert list(afresh.frozen) == ["bodies.skin.thickness"]
    assert list(disagreements(afresh, exact)) == []
    slope, by_fresh = (each["max_stress"]["bodies.skin.thickness"] for each in (exact.gradients, afresh.slopes))
    assert 1e-4 < abs(slope - by_fresh.slope) / abs(by_fresh.slope) < 1  # five modes: freezing costs some digits, not the sign


def test_a_model_without_its_skin_file_is_left_out_by_name(tmp_path):
    scene = project(tmp_path, "full")
    (tmp_path / "skin.toml").unlink()
    afresh = fresh_gradients(scene, ["bodies.skin.chord"], "static", lambda *_: None)
    assert afresh.slopes == {}
    assert afresh.left_out == {"bodies.skin.chord": "there is no skin.toml beside the reduced model to build it from"}


def test_a_file_beside_the_model_that_it_was_not_built_from_is_left_alone(tmp_path):
    """A scene of the model's name was read as its skin, and ended the certificate."""
    section = Section(2e11, 7800.0, 0.02, 0.05)
    save(polygon_beam(np.array([[0, 0], [1.0, 0]]), section, {"root": 0.0, "tip": 1.0}), tmp_path / "beam.h5")
    (tmp_path / "beam.toml").write_text('units = "m-kg-s"\n')
    (tmp_path / "scene.toml").write_text(BESIDE)
    found = fresh_gradients(read_scene(tmp_path / "scene.toml"), ["b"], "static", lambda *_: None)
    assert found.slopes == {}
    assert found.left_out == {"b": "the reduced model was not built from the beam.toml beside it"}


BESIDE = """
units = "m-kg-s"
points = { tip = { body = "beam", interface = "tip" } }
bodies = { beam = { type = "flexible", model = "beam.h5", frame = "grounded" } }
loads = { pull = { type = "point-force", body = "beam", point = "tip", force = [0.0, 1.0] } }
design = { b = "bodies.beam.width" }
responses = { way = { type = "displacement", body = "beam", point = "tip", component = "y" } }
solver = { end_time = 0.02, step = 0.01 }
"""
