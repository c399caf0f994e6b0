"""Steps from 1e-7 to 0.1 s and rho_inf from 0 to 1: the same motion and slopes to the scheme's order, or a refusal."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

from tests.models.scenes import WING
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.rigid import Rigid
from toolkit.components.joints.distance import Distance
from toolkit.components.loads.gravity import Gravity
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import ConvergenceError
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.system.system import System, compile_scene

GRAVITY = 9.81
STEPS = {1e-7: 1e-4, 1e-6: 1e-3, 1e-5: 1e-2, 1e-4: 0.1, 1e-3: 1.0, 1e-2: 1.0, 0.05: 1.0, 0.1: 1.0}
"""Step -> end time, both in s."""
KINDS = [("index-1", rho_inf) for rho_inf in (0.0, 0.5, 0.9, 1.0)] + [
    (kind, rho_inf) for kind, most in (("index-3", 0.8), ("ggl", 0.9)) for rho_inf in (0.0, 0.5, most)
]
"""Index 3 with rho_inf above 0.8 is refused, see tests/solvers/test_trades.py."""
DURATIONS = [(1.0, 0.001), (12.0, 0.1)]
"""Rise time of the wing's torque and step, in s."""


@pytest.fixture(scope="module")
def pendulum() -> System:
    """1 kg on 1 m, released from the horizontal, with the derivative by gravity."""
    scene = Scene(
        units="m-kg-s",
        points={"O": Point(x=0.0, y=0.0), "P": Point(x=-1.0, y=0.0)},
        bodies={"bob": Rigid(mass=1.0, inertia=1.0, center="P")},
        joints={"rod": Distance(bodies=("bob", "ground"), points=("P", "O"))},
        loads={"weight": Gravity(acceleration=(0.0, -GRAVITY))},
    )
    return compile_scene(scene, ["loads.weight.acceleration.y"])


def exact(time: float) -> tuple[float, float, float]:
    """Angle from the downward vertical, its derivative by g, and the rod's force of the pendulum of 1 m.

    sin(theta/2) = -k sn(K - tau, k), tau = sqrt(g/L) t, k = sin(45 deg), started at -90 deg; theta is a function of tau alone, so that
    dtheta/dg = t theta' / (2 g). Energy gives theta'^2 = 2 g cos(theta), and the force is m (g cos(theta) + theta'^2).
    """
    sn, cn, _, _ = ellipj(ellipk(0.5) - np.sqrt(GRAVITY) * time, 0.5)
    angle, rate = -2 * np.arcsin(np.sqrt(0.5) * sn), 2 * np.sqrt(0.5 * GRAVITY) * cn
    return angle, time * rate / (2 * GRAVITY), 3 * GRAVITY * np.cos(angle)


def errors(run: Solution, time: float) -> np.ndarray:
    """Those of the angle, its slope and the force at the end."""
    angle, slope, force = exact(time)
    x, y = run.q[-1, :2]
    by_g = -(x * run.dq[-1, 1, 0] - y * run.dq[-1, 0, 0]) / (x**2 + y**2)  # gravity is -g
    return np.abs([np.arctan2(x, -y) - angle, by_g - slope, run.multipliers[-1, 0] - force])


@pytest.mark.parametrize(("formulation", "rho_inf"), KINDS)
@pytest.mark.parametrize("step", STEPS)
def test_the_pendulum_moves_as_the_elliptic_functions_say_or_is_refused(pendulum, step, formulation, rho_inf):
    end = STEPS[step]
    options = RunOptions(end_time=end, step=step, formulation=formulation, rho_inf=rho_inf)
    if formulation == "index-1" and (step > 0.05 or (step == 0.05 and rho_inf < 0.9)):  # the rod grows by the square of the step
        with pytest.raises(ConvergenceError, match=r"joints came apart.*far too large for this motion"):
            simulate(pendulum, options)
        return
    angle, slope, force = errors(simulate(pendulum, options), end)
    # beta grows from 1/4 to 1 as rho_inf falls, and the errors of half a swing, in units of step^2, from 6 to 50 rad and from 120 to 800 N
    first, second = (60 * step**2, 1000 * step**2) if rho_inf < 0.5 else (12 * step**2, 400 * step**2)
    assert angle < first * end + 1e-14  # round-off
    assert slope < first * end + 1e-14
    # docs/limits.md: round-off of positions comes back as force over step^2, at 1e-7 s; with rho_inf near 1 it dies out slowest
    noise = {"index-1": 10, "index-3": 100, "ggl": 100}[formulation] / max(1 - rho_inf, 0.1) * np.finfo(float).eps
    assert force < second + noise / step**2


@pytest.mark.parametrize("rho_inf", [0.0, 0.5, 1.0])
@pytest.mark.parametrize(("duration", "step"), DURATIONS)
def test_the_wing_ends_at_rest_where_statics_has_it(duration, step, rho_inf):
    scene = read_scene(WING, {"loads.drive.curve.duration": str(duration), "solver.end_time": str(1.2 * duration)})
    system = compile_scene(scene)
    run = simulate(system, RunOptions(end_time=1.2 * duration, step=step, rho_inf=rho_inf))
    # what the rise excites of the lowest mode, 78 Hz: its third derivative, 60 / T^3, over omega^3, 5e-7 of 80 mm per rise time of 1 s
    np.testing.assert_allclose(run.q[-1], solve_statics(system).q[0], rtol=0, atol=1e-5)


def test_a_blow_of_a_tenth_of_a_millisecond_moves_the_wing_alike_in_steps_of_1e_7_s():
    """The torque rises a hundred times faster than the wing swings; second order from 4e-7 to 1e-7 s, so nothing is lost in round-off."""
    system = compile_scene(read_scene(WING, {"loads.drive.curve.duration": "1e-4"}), ["M_t"])
    runs = [simulate(system, RunOptions(end_time=1.2e-4, step=step, rho_inf=0.8)) for step in (4e-7, 2e-7, 1e-7)]
    for name in ("q", "dq"):
        coarse, middle, fine = (getattr(run, name)[-1] for run in runs)
        rate = np.log2(np.abs(coarse - middle).max() / np.abs(middle - fine).max())
        assert rate == pytest.approx(2, abs=0.1), name  # modes of up to 1e7 1/s do not resolve, and are damped
    moved = runs[2].q[-1] - runs[2].q[0]
    # as long as nothing has turned far (0.7 mrad), the motion is linear in the torque
    np.testing.assert_allclose(4200 * runs[2].dq[-1, :, 0], moved, atol=1e-3 * np.abs(moved).max())
