"""Solid bodies in scenes: their motion against that of beams, their gradients against the complex step and preprocessing afresh."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from preprocessing import build
from preprocessing.builders.frame_recipe import polygon_beam
from preprocessing.elements.section import Section
from tests.models.directions import along, derivative_along, direction
from tests.models.solid_bodies import DENSITY, MODULUS, WIDTH, rectangle, write_body
from toolkit.analyses.sensitivity.certificate.fresh_models import disagreements, fresh_gradients
from toolkit.analyses.sensitivity.direct import direct
from toolkit.analyses.sensitivity.preparation import prepare, values_of
from toolkit.analyses.transient import simulate
from toolkit.files.scene_reader import read_scene
from toolkit.reduced_model.file import save
from toolkit.scene.scene import Scene

pytestmark = pytest.mark.usefixtures("read_here", "programs_here")

LENGTH, HEIGHT = 0.5, 0.02
CRAIG_BAMPTON = 'kind = "craig-bampton"\ncount = 4'

SCENE = """
units = "m-kg-s"
[points]
hub = { body = "arm", interface = "hub" }
tip = { body = "arm", interface = "tip" }
[bodies]
arm = { type = "flexible", model = "body.h5", frame = "moving" }
[joints]
hub = { type = "revolute", bodies = ["arm", "ground"], point = "hub" }
spin = { type = "angle-driver", bodies = ["arm", "ground"], point = "hub", curve = { type = "smooth-step", height = 1.5, duration = 0.03 } }
[loads]
shake = { type = "point-force", body = "arm", point = "tip", force = [300.0, 900.0], curve = { type = "sine", frequency = 40.0 } }
[responses]
x = { type = "displacement", body = "arm", point = "tip", component = "x" }
y = { type = "displacement", body = "arm", point = "tip", component = "y" }
turn = { type = "rotation", body = "arm", point = "tip" }
energy = { type = "strain-energy" }
stress = { type = "ks-stress", body = "arm", aggregation = 500.0, reference_stress = 1e8, measure = "absolute" }
[solver]
end_time = 0.05
step = 0.00025
rho_inf = 0.8
"""


def scene_with(folder: Path, model, changes: dict[str, str] | None = None) -> Scene:
    save(model, folder / "body.h5")
    (folder / "scene.toml").write_text(SCENE)
    return read_scene(folder / "scene.toml", changes)


def tip_bending(scene: Scene) -> np.ndarray:
    """Displacement of the tip across the arm in the body's frame over time."""
    solution = simulate(prepare(scene))
    position, _ = scene.model("body.h5", "interfaces").interfaces["tip"].here
    return np.real(solution.q[:, solution.coordinates("arm")][:, 3:]) @ position[1, 1:]


def test_solid_arm_that_is_spun_and_shaken_moves_as_the_beam_does(tmp_path):
    """The beam has no shear: E is lowered by what that adds to the deflection under a force, (E / G) 0.3 (height / length)^2 = 0.1 %."""
    shear = 2 * 0.3 * (HEIGHT / LENGTH) ** 2  # E / G = 2 without lateral contraction
    section = Section(MODULUS / (1 + shear), DENSITY, HEIGHT, WIDTH, damping_stiffness=1e-5)
    nodes = np.column_stack([np.linspace(0, LENGTH, 21), np.zeros(21)])
    beam = tip_bending(scene_with(tmp_path, polygon_beam(nodes, section, {"hub": 0.0, "tip": LENGTH})))
    errors = []
    for cells in ((5, 1), (10, 1), (20, 2)):
        body = write_body(tmp_path, rectangle("quad8", cells, LENGTH, HEIGHT), CRAIG_BAMPTON, poisson_ratio=0.0)
        solid = tip_bending(scene_with(tmp_path, build(body)))
        errors.append(np.abs(solid - beam).max() / np.abs(beam).max())
    # fourth order while elements are coarse, 1 / 8 and more; then what the beam leaves out of the vibrations: rotary inertia, and the
    # shear of a fixed-fixed mode, which is 4 times that of the cantilever, in the phase of some vibrations
    assert errors[1] < errors[0] / 8
    assert errors[2] < 4e-3


@pytest.mark.parametrize("basis", [CRAIG_BAMPTON, 'kind = "full"'])
def test_gradients_of_a_motion_are_those_of_the_complex_step(basis, tmp_path):
    body = write_body(tmp_path, rectangle("quad8", (5, 1), LENGTH, HEIGHT), basis)
    scene = scene_with(tmp_path, build(body), {"solver.end_time": "0.005", "solver.step": "0.001"})
    design = [f"bodies.arm.{name}" for name in ("youngs_modulus", "density", "width", "damping_stiffness", "poisson_ratio")]
    found = direct(scene, design, "transient")
    ours = found.gradients
    factors = {x: part * abs(scene.number(x)) for x, part in direction(design).items()}
    for response, judge in derivative_along(scene, factors, "transient", found.solution).items():
        largest = max(abs(slope * factors[x]) for x, slope in ours[response].items())
        # exact both, up to the Newton tolerance of 1e-10 relative to forces that only begin to grow
        assert along(ours[response], factors) == pytest.approx(judge, rel=0, abs=1e-7 * largest), response


@pytest.mark.parametrize("basis", [CRAIG_BAMPTON, pytest.param('kind = "eigenmodes"\ncount = 4', marks=pytest.mark.processors)])
def test_gradients_of_a_motion_are_those_of_models_built_afresh(basis, tmp_path):
    """As `ffrf certify` compares them, from the body.toml beside the model."""
    body = write_body(tmp_path, rectangle("quad8", (5, 1), LENGTH, HEIGHT), basis)
    scene = scene_with(tmp_path, build(body), {"solver.end_time": "0.01", "solver.step": "0.0005", "solver.tolerance": "1e-12"})
    design = [f"bodies.arm.{name}" for name in ("youngs_modulus", "density", "width", "poisson_ratio")]
    found = fresh_gradients(scene, design, "transient", lambda *_: None)
    assert set(found.slopes["y"]) == set(design)
    assert list(disagreements(found, direct(scene, design, "transient"))) == []


def test_rigid_and_averaged_ties_move_alike(tmp_path):
    """The tip's forces spread over a section of height 1 / 25 of the length: Saint-Venant."""
    found = []
    for tie in ("averaged", "rigid"):
        body = write_body(tmp_path, rectangle("quad8", (12, 2), LENGTH, HEIGHT), CRAIG_BAMPTON, tie=tie)
        found.append(values_of(scene_with(tmp_path, build(body)), "transient"))
    for name in ("x", "y", "turn", "energy"):
        assert found[0][name] == pytest.approx(found[1][name], rel=1e-2), name
