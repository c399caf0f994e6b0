"""The adjoint of a run that does not fit into memory: the same gradients, in the memory of a few windows."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from tests.benchmarks.chain import chain
from tests.models.response_cases import PLANE, plane, write_models
from tests.models.scenes import HANGING_DESIGN, hanging_skin
from toolkit.analyses.checkpoints import solve_windows, window_bounds
from toolkit.analyses.sensitivity.adjoint import adjoint
from toolkit.analyses.sensitivity.direct import direct
from toolkit.analyses.sensitivity.preparation import prepare
from toolkit.analyses.transient import simulate
from toolkit.foundation.errors import InputError
from toolkit.responses.joint_force import JointForce
from toolkit.responses.response import Partials, Response
from toolkit.responses.stress import KSStress
from toolkit.responses.windows import combine
from toolkit.scene.scene import Scene
from toolkit.solvers.transient.run import prepare_run

ROUND_OFF = 1e-10
"""The states are the same to the last bit, and so are the stresses and what looks at one instant. Sums over windows are taken in
another order, and the gradient by the density of a stiff skin multiplies their round-off by 10^5: 1e-11."""


def with_options(scene: Scene, **changes) -> Scene:
    return scene.model_copy(update={"solver": scene.solver.model_copy(update=changes)})


@pytest.mark.processors
@pytest.mark.parametrize(("scheme", "rho_inf"), [("arnold-bruels", 0.3), ("paper", 0.8)])
def test_gradients_of_every_kind_of_response_are_those_without_checkpoints(scheme, rho_inf):
    """`paper` carries a part of the residual over the checkpoints. 23 steps do not divide into equal windows."""
    scene = with_options(hanging_skin(), scheme=scheme, rho_inf=rho_inf, end_time=0.0115, step=0.0005)
    whole = adjoint(scene, HANGING_DESIGN, "transient")
    parts = adjoint(with_options(scene, memory=1e-6), HANGING_DESIGN, "transient")
    assert parts.values == pytest.approx(whole.values, rel=ROUND_OFF)
    assert parts.gradients["ks_absolute"] == whole.gradients["ks_absolute"]  # of the last instant alone
    for name, slopes in whole.gradients.items():
        largest = max(abs(slope) for slope in slopes.values())
        assert parts.gradients[name] == pytest.approx(slopes, rel=ROUND_OFF, abs=ROUND_OFF * largest), name


def test_responses_over_time_are_put_together_from_windows(tmp_path):
    """Also accelerations, whose derivatives enter the step backwards, and the work of a driver."""
    write_models(tmp_path)
    scene = with_options(plane(tmp_path), end_time=0.24, step=0.01).model_copy(update={"responses": PLANE})
    design = [
        "points.A.x",
        "loads.motor.torque",
        "loads.spring.damping",
        "bodies.crank.density",
        "joints.lead.curve.terms.2.amplitude",
    ]
    whole = adjoint(scene, design, "transient")
    parts = adjoint(with_options(scene, memory=1e-6), design, "transient")
    assert parts.values == pytest.approx(whole.values, rel=ROUND_OFF)
    for name, slopes in whole.gradients.items():
        largest = max(abs(slope) for slope in slopes.values())
        assert parts.gradients[name] == pytest.approx(slopes, rel=0, abs=ROUND_OFF * largest), name


def test_windows_hold_every_state_once_to_the_last_bit():
    scene = hanging_skin(responses={})
    run = prepare_run(prepare(scene))
    windows = list(solve_windows(run, window_bounds(len(run.times)), []))
    whole = simulate(prepare(scene))
    for name in ("times", "q", "v", "a", "multipliers"):
        assert np.array_equal(np.concatenate([getattr(window, name) for window in windows]), getattr(whole, name)), name


def test_memory_is_that_of_a_few_windows():
    scene = chain(5, steps=6400).model_copy(update={"responses": {"force": JointForce(joint="J0", component="x")}})
    small, states = with_options(scene, memory=1e-6), 8 * 6400 * 3 * 25
    adjoint(with_options(small, end_time=0.01), ["density0"], "transient")  # compiled code is loaded
    # 80 states of a window and 81 checkpoints take 0.2 MB, 6400 times in a few copies as much; the rest is independent of the run
    assert peak_memory(small) < states / 3
    assert peak_memory(scene) > states


def peak_memory(scene: Scene) -> int:
    """Most bytes at once of all arrays of a gradient's computation."""
    tracemalloc.start()
    adjoint(scene, ["density0"], "transient")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


def test_progress_ends_where_it_said():
    told = []
    adjoint(with_options(hanging_skin(), memory=1e-6), ["points.O.x"], "transient", lambda *moved: told.append(moved))
    assert told == sorted(told)
    assert told[-1] == (20, 20)


def test_the_direct_method_refers_to_checkpoints_when_its_derivatives_do_not_fit():
    with pytest.raises(InputError, match=r"more than solver.memory = 1e-05 GB.*adjoint method, which keeps checkpoints"):
        direct(with_options(hanging_skin(), memory=1e-5), HANGING_DESIGN, "transient")


def test_a_kind_of_response_that_nobody_put_together_is_refused_by_name():
    class Odd(Response):
        def partials(self, solution):
            return Partials(float(len(solution.times)))

    with pytest.raises(InputError, match=r"cannot be put together from windows.*Raise solver.memory"):
        combine(Odd(), np.zeros(2))


def test_a_smooth_maximum_of_smooth_maxima_is_the_smooth_maximum():
    parts = np.random.default_rng(3).normal(size=(4, 6))
    response = KSStress(body="skin", aggregation=7.0)

    def ks(values):
        return combine(response, values)[0]

    # a sum of exponentials in another order
    assert ks(np.array([ks(row) for row in parts])) == pytest.approx(ks(parts.ravel()), rel=1e-14)
