"""A linear beam beyond its critical speed, sqrt(K / G_ff) = 105.3 rad/s: it must diverge, and be warned about (the warnings themselves
and the closed form of the speed: tests/validity/test_deformation.py)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from toolkit.analyses.transient import simulate
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene
from toolkit.validity.bodies.critical_speed import critical_speed, too_fast_at_start, too_fast_in_motion
from toolkit.validity.bodies.deformation import deformation

BEAM = Path(__file__).parents[2] / "models" / "rotating_beam" / "scene.toml"
CRITICAL = 1.875104068711961**2 * float(np.sqrt(210e9 * 0.02**2 / 12 / 7800.0))
DISTURBANCE = 1e-9
FORMULATIONS = pytest.mark.parametrize("formulation", ["index-1", "index-3", "ggl"])


def disturbed(speed: float, formulation: str, end_time: float) -> Solution:
    """A beam that is bent by a nanometre at its tip, and spins freely."""
    system = compile_scene(read_scene(BEAM, {"bodies.beam.angular_velocity": repr(speed)}))
    q, v, x = np.zeros(system.n_q), np.zeros(system.n_q), np.linspace(0, 1, 21)[1:]
    v[2], q[4::3], q[5::3] = speed, DISTURBANCE * x**2, 2 * DISTURBANCE * x
    return simulate(system, RunOptions(end_time=end_time, step=5e-4, rho_inf=0.8, formulation=formulation), q, v)


@FORMULATIONS
@pytest.mark.parametrize("part", [0.5, 0.95])
def test_below_the_critical_speed_a_disturbance_dies_out(part, formulation):
    run = disturbed(part * CRITICAL, formulation, 0.5)
    assert abs(run.q[-1, -2]) < 1e-4 * DISTURBANCE
    assert not list(too_fast_in_motion(run))
    assert not list(too_fast_at_start(run.system.scene))


@FORMULATIONS
@pytest.mark.parametrize("part", [1.05, 1.2])
def test_beyond_it_a_disturbance_grows_without_bound_until_the_spin_has_slowed_down_to_it(part, formulation):
    """A bent linear beam rests in its frame at the critical speed alone: det(K - omega^2 G_ff) = 0."""
    speed = part * CRITICAL
    run = disturbed(speed, formulation, 0.5)
    assert np.abs(run.q[:, -2]).max() > 0.2  # of 1 m, where the true beam is stretched by 0.2 mm
    assert run.v[-1, 2] == pytest.approx(critical_speed(run.system.scene, "beam"), rel=1e-3)  # of decaying vibrations
    critical = critical_speed(run.system.scene, "beam")
    assert list(too_fast_at_start(run.system.scene)) == [("beam", speed, critical)]
    assert list(too_fast_in_motion(run)) == [("beam", pytest.approx(speed, rel=1e-3), critical)]
    found = deformation(run, "beam")
    assert found.exceeded
    assert found.relative > 0.5
