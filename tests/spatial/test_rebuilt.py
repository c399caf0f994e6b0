"""Planar scenes rebuilt in space give the planar numbers: motion, joint forces, energies and gradients.

An angle and a quaternion make different errors of a time step, so runs are compared after extrapolation to steps of zero.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from preprocessing import build
from tests.spatial.momenta import kinetic_energy
from tests.spatial.rebuilt import angle, angle_rates, force, in_space, place
from toolkit.analyses.modes import solve_modes
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.driver import AngleDriver
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.reduced_model.file import save
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene

MODELS = Path(__file__).parents[2] / "models"
SAME = 1e-8


def model(name: str) -> Scene:
    return read_scene(MODELS / name / "scene.toml")


def extrapolated(levels: list[np.ndarray]) -> np.ndarray:
    """Errors in h^2, h^3, h^4, ... taken out of results at h, h / 2, h / 4, ..."""
    for order in range(2, len(levels) + 1):
        levels = [fine + (fine - coarse) / (2**order - 1) for coarse, fine in pairwise(levels)]
    return levels[0]


def agree(planar: np.ndarray, spatial: np.ndarray, tolerance: float = SAME) -> None:
    np.testing.assert_allclose(spatial, planar, rtol=0, atol=tolerance * np.abs(planar).max())


def motion(run: Solution, every: int, bodies: list[str], hinges: list[str]) -> dict[str, np.ndarray]:
    """What both scenes have, at the times of the coarsest step."""
    energies = [kinetic_energy(run.system, q, v) for q, v in zip(run.q[::every], run.v[::every], strict=True)]
    found = {"energy": np.array(energies)}
    found |= {"angle": np.stack([angle(run, body)[::every] for body in bodies])}
    found |= {"place": np.stack([place(run, body)[::every] for body in bodies])}
    return found | ({"force": np.stack([force(run, name)[::every] for name in hinges])} if hinges else {})


def limits(scene: Scene, end: float, step: float, bodies: list[str], hinges: list[str]) -> dict[str, np.ndarray]:
    system, levels = compile_scene(scene), []
    for k in range(5):
        run = simulate(system, RunOptions(end_time=end, step=step / 2**k, rho_inf=0.8, tolerance=1e-13))
        levels.append(motion(run, 2**k, bodies, hinges))
    return {name: extrapolated([level[name] for level in levels]) for name in levels[0]}


LINKS = ["link0", "link1", "link2", "coupler1", "coupler2"]
MECHANISMS = {
    "pendulum": (1.0, 0.01, ["bob"], []),
    "slider_crank": (1.0, 0.01, ["crank", "rod"], ["O", "T"]),
    "four_bar_chain": (0.2, 0.01, LINKS, ["A0", "A1", "right1", "left2", "right2"]),
}


@pytest.mark.parametrize("name", MECHANISMS)
def test_motion_joint_forces_and_energy_are_those_of_the_plane(name):
    planar, spatial = (limits(scene, *MECHANISMS[name]) for scene in (model(name), in_space(model(name))))
    for quantity, expected in planar.items():
        agree(expected, spatial[quantity])


def test_a_driven_crank_moves_as_in_the_plane():
    planar = model("slider_crank")
    drive = AngleDriver(bodies=("crank", "ground"), point="O", curve=SmoothStep(height=1.0, duration=1.0))
    planar = planar.model_copy(update={"joints": {**planar.joints, "drive": drive}})
    found = [limits(scene, *MECHANISMS["slider_crank"]) for scene in (planar, in_space(planar))]
    for quantity, expected in found[0].items():
        agree(expected, found[1][quantity])


GRADIENTS = {
    "slider_crank": (
        "rod",
        {"loads.spring.stiffness": "", "points.X.x": "", "bodies.rod.inertia": ".2", "loads.pull.force.x": ".0"},
    ),
    "four_bar_chain": ("link2", {"bodies.coupler1.density": "", "points.B1.x": "", "loads.gravity.acceleration.y": ".1"}),
}
"""Scene -> body whose final angle is differentiated, and planar paths with what they are in space."""


@pytest.mark.parametrize("name", GRADIENTS)
def test_gradients_of_an_angle_are_those_of_the_plane(name):
    end, step, *_ = MECHANISMS[name]
    body, paths = GRADIENTS[name]
    in_three = [path.rsplit(".", 1)[0] + where if where in (".0", ".1") else path + where for path, where in paths.items()]
    found = []
    for scene, design in ((model(name), list(paths)), (in_space(model(name)), in_three)):
        system, levels = compile_scene(scene, design), []
        for k in range(4):
            run = simulate(system, RunOptions(end_time=end, step=step / 2**k, rho_inf=0.8, tolerance=1e-13))
            levels.append(angle_rates(run, body)[-1])
        found.append(extrapolated(levels))
    agree(*found)


@pytest.fixture(scope="module")
def wings(tmp_path_factory) -> tuple[Scene, Scene]:
    """The morphing wing in the plane, and in space with the spatial skin."""
    folder, planar = tmp_path_factory.mktemp("wing"), model("morphing_wing")
    save(build(MODELS / "morphing_wing" / "skin.toml", keys={"dimension": 3}), folder / "skin3.h5")
    planar = planar.model_copy(update={"responses": {}, "design": {}})
    return planar, in_space(planar, {"skin.h5": "skin3.h5"}, directory=folder)


RODS = ["body2", "body3", "body4", "body5"]


def skin(run: Solution) -> np.ndarray:
    """Elastic coordinates in the plane, (n_t, 90)."""
    own = run.q[:, run.coordinates("skin")]
    return own if run.system.scene.dimension == 2 else own.reshape(len(own), -1, 6)[:, :, [0, 1, 5]].reshape(len(own), -1)


def test_wing_in_equilibrium(wings):
    planar, spatial = (solve_statics(compile_scene(scene), RunOptions(end_time=1.0, tolerance=1e-13)) for scene in wings)
    agree(skin(planar), skin(spatial))
    for body in RODS:
        agree(angle(planar, body), angle(spatial, body))
        agree(place(planar, body), place(spatial, body))
    for joint in ("A", "B", "C", "D", "E"):
        agree(force(planar, joint), force(spatial, joint))


def test_wing_in_motion(wings):
    """Two steps, extrapolated: the rods' quaternions differ from angles by their inertia alone, which is small here."""
    found = []
    for scene in wings:
        system, levels = compile_scene(scene), []
        for every in (1, 2):
            options = RunOptions(end_time=0.5, step=0.025 / every, rho_inf=0.5, formulation="index-3", tolerance=1e-13)
            run = simulate(system, options)
            parts = [skin(run), angle(run, "body2"), place(run, "body4"), force(run, "C"), force(run, "E")]
            levels.append([part[::every] for part in parts])
        found.append([extrapolated([a, b]) for a, b in zip(*levels, strict=True)])
    for planar, spatial in zip(*found, strict=True):
        agree(planar, spatial)


def test_wing_gradients_of_the_equilibrium(wings):
    design = ["points.A.x", "points.D.y", "bodies.skin.thickness", "bodies.skin.youngs_modulus", "loads.drive.torque"]
    planar, spatial = (
        solve_statics(compile_scene(scene, names), RunOptions(end_time=1.0, tolerance=1e-13))
        for scene, names in zip(wings, (design, [*design[:-1], "loads.drive.torque.2"]), strict=True)
    )
    ours, exact = (angle_rates(run, "body2")[-1] for run in (spatial, planar))
    np.testing.assert_allclose(ours, exact, rtol=SAME)


def test_wing_has_the_planar_frequencies_among_its_own(wings):
    planar, spatial = (
        solve_modes(solve_statics(compile_scene(scene), RunOptions(end_time=1.0, tolerance=1e-13))).frequencies for scene in wings
    )
    for frequency in planar[:4]:
        # Round-off, 1.1e-16, times the condition of the stiffness on a unit diagonal, 2e9 in the plane and 3.4e9 in space, is 2e-7 and
        # 4e-7 of a square, half of that in the frequency. Seen are 5e-8 and 1.2e-7, against the same matrices solved in long double;
        # these agree to 3e-8, by which half of the last digit of the stiffness moves the frequency.
        assert np.abs(spatial / frequency - 1).min() < 3e-7
