"""Pressure on a surface of a solid, with every frame that a body can have."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.models.solid_bodies import MODULUS, box, cantilever
from tests.spatial.scenes import at
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.api.comparison import check_design_derivatives, check_state_derivatives
from toolkit.components.bodies.flexible import SpatialFlexible
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.loads.pressure import Pressure
from toolkit.description.design import BodyPoint
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.file import save
from toolkit.responses.motion import Displacement
from toolkit.responses.stress import KSStress, MaxStress
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.system.solution import MarkerStates
from toolkit.system.system import compile_scene

LENGTH, WIDTH, HEIGHT = 1.0, 0.1, 0.06
TOP = f"\n[pressure_surfaces.top]\nbox = [0, {-WIDTH}, {HEIGHT / 2}, {LENGTH}, {WIDTH}, {HEIGHT / 2}]\n"
PRESSURE = 1e4
FRAMES = {
    "grounded": {},
    "translating": {},
    "turning": {"axis": (0.3, 1.0, 0.2)},
    "moving": {"angular_velocity": (0.1, 0.2, 0.3)},
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    where = tmp_path_factory.mktemp("solid")
    basis = 'kind = "craig-bampton"\ncount = 4'
    save(cantilever(where, box("hexahedron20", (10, 1, 1), (LENGTH, WIDTH, HEIGHT)), basis, 0.0, more=TOP), where / "beam.h5")
    return where


def pressed(folder: Path, frame: str, orientation: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Scene:
    """A solid beam under a pressure on its upper side."""
    return Scene(
        units="m-kg-s",
        dimension=3,
        points={**at(O=(0, 0, 0)), "tip": BodyPoint(body="beam", interface="tip")},
        bodies={"beam": SpatialFlexible(model="beam.h5", frame=frame, orientation=orientation, **FRAMES[frame])},  # type: ignore[arg-type]
        loads={"wind": Pressure(body="beam", surface="top", pressure=PRESSURE, curve=SmoothStep(height=1.0, duration=0.01))},
        responses={
            "tip-z": Displacement(body="beam", point="tip", component="z"),
            "peak": MaxStress(body="beam", when="end"),
            "smooth": KSStress(body="beam", aggregation=50.0, reference_stress=1e6),
        },
        solver=RunOptions(end_time=0.02, step=0.001),
        directory=folder,
    )


@pytest.mark.parametrize("frame", FRAMES)
def test_derivatives_agree_with_complex_steps(folder, frame):
    scene = pressed(folder, frame, (0.2, -0.3, 0.5))
    check_state_derivatives(scene)
    check_design_derivatives(scene)


@pytest.mark.parametrize("orientation", [(0.0, 0.0, 0.0), (0.4, 1.1, -0.7)])
def test_a_cantilever_bends_as_a_beam_does_wherever_it_points(folder, orientation):
    """w = p b L^4 / (8 E I) + p b L^2 / (2 5/6 G A) without lateral contraction, along the beam's own normal; the beam of ten elements and
    as many modes is stiffer by 0.5 %."""
    scene = pressed(folder, "grounded", orientation)
    solution = solve_statics(compile_scene(scene, None, (("beam", "tip"),)))
    inertia, shear = WIDTH * HEIGHT**3 / 12, MODULUS / 2
    expected = PRESSURE * (WIDTH * LENGTH**4 / (8 * MODULUS * inertia) + WIDTH * LENGTH**2 / (2 * 5 / 6 * shear * WIDTH * HEIGHT))
    body = scene.bodies["beam"]
    pose, _, _ = Displacement(body="beam", point="tip", component="z").pose(MarkerStates(solution.system), solution.q[0])
    moved = body.placement.T @ (pose[:3] - loaded(scene).position("tip"))  # type: ignore[attr-defined]
    np.testing.assert_allclose(moved, [0, 0, -expected], atol=5e-3 * expected)


def test_a_free_body_falls_away_from_the_pressure_as_newton_says(folder):
    """m r'' = p A after the curve's rise; the centre of mass stays on its way though the body turns little in this time."""
    scene = pressed(folder, "translating")
    mass = scene.model("beam.h5").invariants.mass
    solution = simulate(compile_scene(scene))
    first = scene.model("beam.h5").invariants.first_moment
    momentum = mass * solution.v[-1, 2] + first[2, 1:] @ solution.v[-1, 3:]
    impulse = -PRESSURE * WIDTH * LENGTH * (0.02 - 0.005)  # a smooth step has half of its height on the mean
    assert momentum == pytest.approx(impulse, rel=1e-3)  # second order in the step


def test_gradients_of_von_mises_stress_agree_by_all_methods(folder):
    """To 1e-9 of each: round-off of twenty steps."""
    scene, variables = pressed(folder, "grounded"), ["loads.wind.pressure", "bodies.beam.youngs_modulus", "bodies.beam.density"]
    results = {method: gradients_by(method, scene, variables, "transient") for method in ("complex-step", "direct", "adjoint")}
    for name in ("tip-z", "peak", "smooth"):
        reference, *found = (np.array([result.gradients[name][v] for v in variables]) for result in results.values())
        for ours in found:
            np.testing.assert_allclose(ours, reference, rtol=1e-9)


def test_an_unknown_surface_is_refused_with_those_that_exist(folder):
    scene = pressed(folder, "grounded")
    wrong = scene.loads["wind"].model_copy(update={"surface": "bottom"})
    with pytest.raises(InputError, match=r"no surface 'bottom'.*it has: top"):
        compile_scene(scene.model_copy(update={"loads": {"wind": wrong}}))
