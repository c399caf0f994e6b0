"""Two rigid bodies with exact solutions: the heavy top, and a free body about its intermediate axis (Dzhanibekov)."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tests.spatial.scenes import at
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.rigid import SpatialRigid
from toolkit.components.joints.spherical import Spherical
from toolkit.components.loads.gravity import SpatialGravity
from toolkit.description.run_options import RunOptions
from toolkit.foundation.kinematics.orientation import angular_velocity
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene

DATA = Path(__file__).parents[1] / "data" / "benchmarks"
TOP, FREE = (json.loads((DATA / f"{name}.json").read_text()) for name in ("heavy_top", "free_rigid_body_dzhanibekov"))


def heavy_top() -> Scene:
    p = TOP["parameters"]
    return Scene(
        units="m-kg-s",
        dimension=3,
        points=at(O=(0, 0, 0), C=p["com_position_body_m"]),
        bodies={
            "top": SpatialRigid(
                mass=p["mass_kg"],
                inertia=tuple(p["inertia_about_COM_kg_m2"]),
                center="C",
                velocity=tuple(np.cross(p["angular_velocity0_body_rad_per_s"], p["com_position_body_m"])),
                angular_velocity=tuple(map(float, p["angular_velocity0_body_rad_per_s"])),
            )
        },
        joints={"tip": Spherical(bodies=("top", "ground"), point="O")},
        loads={"weight": SpatialGravity(acceleration=(0.0, 0.0, -p["gravity_m_per_s2"]))},
    )


def handle() -> Scene:
    p = FREE["parameters"]
    return Scene(
        units="m-kg-s",
        dimension=3,
        points=at(C=(0, 0, 0)),
        bodies={
            "handle": SpatialRigid(
                mass=p["mass_kg"],
                inertia=tuple(p["principal_inertia_kg_m2"]),
                center="C",
                angular_velocity=tuple(map(float, p["omega0_rad_per_s"])),
            )
        },
    )


def states(run: Solution, times: list[float]) -> np.ndarray:
    """Position, quaternion and angular velocity at the times, (n_t, 10)."""
    n = np.rint(np.array(times) / run.times[1]).astype(int)
    np.testing.assert_allclose(run.times[n], times, rtol=1e-12)
    return np.column_stack([run.q[n], angular_velocity(run.q[n, 3:], run.v[n, 3:])])


def extrapolated(levels: list[np.ndarray]) -> np.ndarray:
    """What remains of results at h, h / 2, h / 4, ... after the errors in h^2, h^3, h^4, ... are taken out."""
    for order in range(2, len(levels) + 1):
        levels = [fine + (fine - coarse) / (2**order - 1) for coarse, fine in pairwise(levels)]
    return levels[0]


def judge(levels: list[np.ndarray], exact: np.ndarray) -> tuple[float, float, float]:
    """Order of convergence, error at the finest step, and of the extrapolation."""
    coarse, fine = (np.abs(level - exact).max() for level in levels[-2:])
    return float(np.log2(coarse / fine)), float(fine), float(np.abs(extrapolated(levels) - exact).max())


@pytest.mark.parametrize(("formulation", "rho_inf"), [("index-1", 0.8), ("index-3", 0.8), ("ggl", 0.8)])
def test_the_heavy_top_converges_to_the_elliptic_functions_with_second_order(formulation, rho_inf):
    """Half a second, 12 turns and most of a nutation; position and quaternion, as the reference states them."""
    times = [0.05, 0.1, 0.2, 0.4, 0.5]
    index = [TOP["rederived"]["t"].index(t) for t in times]
    exact = np.column_stack([np.array(TOP["rederived"][key])[index] for key in ("com_position_m", "quaternion_e0_e1_e2_e3")])
    system, levels = compile_scene(heavy_top()), []
    for step in (2.5e-4, 1.25e-4, 6.25e-5, 3.125e-5):
        run = simulate(system, RunOptions(end_time=0.5, step=step, rho_inf=rho_inf, formulation=formulation, tolerance=1e-13))
        levels.append(states(run, times)[:, :7])
        # by positions to round-off; by accelerations and Baumgarte's terms up to a few (omega h)^3 of a step
        allowed = 1e-13 if formulation != "index-1" else (150 * step) ** 3 / 100
        assert np.abs(np.sum(run.q[:, 3:] ** 2, axis=1) - 1).max() < allowed
    order, error, rest = judge(levels, exact)
    assert order == pytest.approx(2.0, abs=0.02)
    assert error < 2e-5  # phase of the spin: 75 rad (150 x 3.125e-5)^2 / 12 / 4
    assert rest < TOP["tolerance"]["com_position_abs_m"]


@pytest.mark.parametrize(("formulation", "rho_inf"), [("index-1", 1.0), ("index-3", 0.8)])
def test_the_free_body_flips_as_the_elliptic_functions_say(formulation, rho_inf):
    """Eight seconds with a flip to the stated digits. After the second flip what was wrong at the start has grown by a factor of 2000,
    so that at ten seconds round-off of 40 000 steps (and a fifth order at rho_inf = 0.8) is what is left."""
    times = FREE["rederived"]["t"][1:]
    exact = np.column_stack([np.array(FREE["rederived"][key])[1:] for key in ("quaternion", "omega_body")])
    system, levels = compile_scene(handle()), []
    for step in (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4):
        run = simulate(system, RunOptions(end_time=10.0, step=step, rho_inf=rho_inf, formulation=formulation, tolerance=1e-13))
        levels.append(states(run, times)[:, 3:])
    for part, tolerance, late in ((slice(0, 4), "quaternion_abs", 1e-7), (slice(4, 7), "omega_abs", 1e-6)):
        own = [level[:, part] for level in levels]
        order, _, _ = judge([level[:-1] for level in own], exact[:-1, part])
        rest = np.abs(extrapolated(own) - exact[:, part]).max(axis=1)
        assert order == pytest.approx(2.0, abs=0.05)
        assert rest[:-1].max() < FREE["tolerance"][tolerance]
        assert rest[-1] < late
