"""Four-bar linkages whose bars all lie on one line: passed through with the exact angle, refused by name as a start."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import SingularSystemError
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene

ROOT = Path(__file__).parents[2]
CHAIN = ROOT / "models" / "four_bar_chain" / "scene.toml"
FORMULATIONS = pytest.mark.parametrize("formulation", ["index-1", "index-3", "ggl"])


@pytest.mark.parametrize(
    ("formulation", "rho_inf"),
    [(kind, rho_inf) for kind in ("index-1", "index-3", "ggl") for rho_inf in (0.0, 0.5, 0.8)] + [("index-1", 0.9), ("ggl", 0.9)],
)
def test_five_singular_positions_are_passed_with_the_exact_angle(formulation, rho_inf):
    known = json.loads((ROOT / "tests" / "data" / "benchmarks" / "iftomm_a02_n_fourbar.json").read_text())["rederived"]["N=2"]
    system, exact = compile_scene(read_scene(CHAIN)), known["phi_rad"][known["t"].index(5.0)]
    errors = []
    for step in (2e-3, 1e-3):
        run = simulate(system, RunOptions(end_time=5.0, step=step, rho_inf=rho_inf, formulation=formulation))
        errors.append(abs(-run.q[-1, 2] - exact))
        links = run.q.reshape(-1, 5, 3)[:, :3, 2]
        np.testing.assert_allclose(links - links[:, :1], 0, atol=1e-5)  # all stay parallel: none has changed its branch
    assert errors[1] < (
        2e-3 if rho_inf == 0 else 3e-4
    )  # second order: 5 s at up to 7 rad/s in steps of 1 ms; beta at rho_inf = 0
    assert 1.8 < np.log2(errors[0] / errors[1]) < 2.9  # a little more than 2: Baumgarte's part is of third order


def chain_at(angle: float) -> Scene:
    """The links at an angle to the line of the bearings; every bar moves with -1 rad/s of the links."""
    x, y = np.cos(angle), np.sin(angle)
    places = {f"A{i}": (float(i), 0.0) for i in range(3)} | {f"B{i}": (i + x, y) for i in range(3)}
    scene = read_scene(CHAIN)
    speeds = {name: (y / 2, -x / 2, -1.0) if name.startswith("link") else (y, -x, 0.0) for name in scene.bodies}
    bodies = {
        name: body.model_copy(update={"velocity": speeds[name], "angular_velocity": None}) for name, body in scene.bodies.items()
    }
    return scene.model_copy(update={"points": {name: Point(x=a, y=b) for name, (a, b) in places.items()}, "bodies": bodies})


ALONG_THE_LINE = ", ".join(f"x of joint {name!r}" for name in ("A0", "A1", "A2", "left1", "right1", "left2", "right2"))
"""Both linkages are stretched: two mixtures of forces along the line are free, and every joint has a part in one of them."""


@pytest.mark.processors
@FORMULATIONS
@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-9, 1e-8])
def test_a_start_in_the_singular_position_is_refused_by_the_names_of_the_joints(angle, formulation):
    with pytest.raises(SingularSystemError, match=f"the constraints {ALONG_THE_LINE} repeat or contradict each other"):
        simulate(compile_scene(chain_at(angle)), RunOptions(end_time=0.1, step=1e-3, formulation=formulation))
    with pytest.raises(SingularSystemError, match=f"the constraints {ALONG_THE_LINE} repeat or contradict each other"):
        solve_statics(compile_scene(chain_at(angle)))


@FORMULATIONS
@pytest.mark.parametrize("angle", [1e-7, 1e-5, 1e-3])
def test_a_start_next_to_the_singular_position_moves_as_the_parallelogram_does(angle, formulation):
    """phi'' = -g (3/2 + 2) / (1 + 2) cos(phi) of three links about their ends and two couplers, phi = angle of the links; energy."""
    run = simulate(compile_scene(chain_at(angle)), RunOptions(end_time=0.5, step=1e-3, rho_inf=0.8, formulation=formulation))
    phi, rate = angle + run.q[:, 2], run.v[:, 2]
    energy = 1.5 * rate**2 + 3.5 * 9.81 * np.sin(phi)
    np.testing.assert_allclose(energy, energy[0], rtol=0, atol=1e-4 * np.abs(np.sin(phi)).max() * 3.5 * 9.81)  # (5 1/s x 1 ms)^2
    start = -9.81 * 3.5 / 3 * np.cos(angle)
    # the matrix is nearly singular by the angle: round-off over it
    assert run.a[0, 2] == pytest.approx(start, rel=1e-12 / angle + 1e-9)
    links = run.q.reshape(-1, 5, 3)[:, :3, 2]
    np.testing.assert_allclose(links - links[:, :1], 0, atol=1e-9)
