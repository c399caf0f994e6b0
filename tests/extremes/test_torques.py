"""The wing without torque, and under a million times as much."""

from __future__ import annotations

import numpy as np
import pytest

from tests.models.scenes import WING
from toolkit.analyses.sensitivity.direct import direct
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import ConvergenceError
from toolkit.system.system import compile_scene
from toolkit.validity.bodies.deformation import deformation


def wing(factor: float, **changes: str):
    scheme = {"solver.scheme": "arnold-bruels", "loads.drive.torque": repr(4200.0 * factor)}
    return read_scene(WING, {**scheme, **{key.replace("__", "."): value for key, value in changes.items()}})


@pytest.mark.parametrize("kind", ["static", "transient"])
@pytest.mark.parametrize("formulation", ["index-1", "index-3", "ggl"])
def test_without_torque_nothing_moves_and_gradients_are_finite(kind, formulation):
    found = direct(wing(0.0, solver__formulation=formulation), ["t_w", "M_t"], kind)
    rest = found.solution.system.start()[0][: found.solution.system.n_q]
    np.testing.assert_allclose(
        found.solution.q, np.tile(rest, (len(found.solution.q), 1)), rtol=0, atol=1e-12
    )  # round-off of 80 mm
    assert found.values["max_stress_true"] == pytest.approx(0, abs=1e-8)  # round-off, times E/L = 1000 MPa per mm
    assert found.values["drive_angle"] == pytest.approx(0, abs=1e-13)
    # a thicker skin at rest stays at rest, a torque turns it
    assert found.gradients["drive_angle"]["t_w"] == pytest.approx(0, abs=1e-12)
    assert found.gradients["drive_angle"]["M_t"] > 1e-5
    assert all(np.isfinite(slope) for slopes in found.gradients.values() for slope in slopes.values())


@pytest.mark.parametrize("factor", [1e6, -1e6])
@pytest.mark.parametrize("formulation", ["index-1", "index-3", "ggl"])
def test_a_million_times_the_torque_is_refused(factor, formulation):
    system = compile_scene(wing(factor, solver__formulation=formulation))
    with pytest.raises(ConvergenceError, match=r"bifurcation|limit point|no equilibrium near"):
        solve_statics(system)
    with pytest.raises(ConvergenceError, match=r"Newton stopped at .*smaller solver.step"):
        simulate(system)


@pytest.mark.parametrize("factor", [1e-6, 1e-3])
def test_a_small_torque_moves_in_proportion(factor):
    """The linear response, its gradient at rest times the torque."""
    slope = direct(wing(0.0), ["M_t"], "static").gradients["drive_angle"]["M_t"]
    angle = direct(wing(factor), [], "static").values["drive_angle"]
    assert angle == pytest.approx(slope * 4200.0 * factor, rel=1e-7 + 3 * factor)  # round-off; the second order


def test_ten_times_the_torque_is_solved_and_said_to_leave_small_deformations():
    found = [solve(compile_scene(wing(10.0))) for solve in (solve_statics, simulate)]
    assert found[1].q[-1, 92] == pytest.approx(found[0].q[-1, 92], rel=1e-6)  # at rest again
    assert all(deformation(each, "skin").exceeded for each in found)
