"""`auto`: the cheaper exact method by a cost model, the only possible one where the other cannot, and a sentence that says why."""

from __future__ import annotations

import pytest

from tests.benchmarks.chain import chain
from tests.models.scenes import WING, hanging_skin
from toolkit.analyses.sensitivity.compiled import Compiled
from toolkit.analyses.sensitivity.direct import direct
from toolkit.analyses.sensitivity.methods import choose, gradients_by
from toolkit.files.scene_reader import read_scene
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Displacement
from toolkit.responses.over_time import TimeIntegral

ZERO_LENGTH = {"way": TimeIntegral(of=Displacement(body="arm", point="C", component="magnitude"))}


def forces(count: int) -> dict[str, JointForce]:
    return {f"force{k}": JointForce(joint="J0", component="y") for k in range(count)}


def test_many_variables_and_one_response_take_the_adjoint_with_the_same_gradients():
    scene = chain(20, steps=20).model_copy(update={"responses": forces(1)})
    found, exact = gradients_by("auto", scene, list(scene.design), "transient"), direct(scene, list(scene.design), "transient")
    assert found.method == "adjoint"
    assert "the adjoint, estimated at" in found.reason
    assert "60 design variables and 1 response" in found.reason
    slopes = exact.gradients["force0"]
    largest = max(abs(slope) for slope in slopes.values())
    # round-off, as in test_adjoint; derivatives by distant points are made of that of the largest
    assert found.gradients["force0"] == pytest.approx(slopes, rel=1e-9, abs=1e-10 * largest)


def test_one_variable_and_many_responses_take_direct_differentiation():
    scene = chain(20, steps=20).model_copy(update={"responses": forces(20)})
    found = gradients_by("auto", scene, ["density3"], "transient")
    assert (found.method, "direct differentiation, estimated at" in found.reason) == ("direct", True)


def test_derivatives_of_states_that_are_to_be_kept_need_direct_differentiation():
    scene = chain(20, steps=20).model_copy(update={"responses": forces(1)})
    method, reason = choose(Compiled(scene, tuple(scene.design)), "transient", keep_states=True)
    assert (method, "derivatives of the states are to be kept" in reason) == ("direct", True)


def test_an_equilibrium_takes_direct_differentiation():
    scene = read_scene(WING)
    assert gradients_by("auto", scene, list(scene.design), "static").method == "direct"


def test_derivatives_that_do_not_fit_into_memory_leave_the_adjoint():
    scene = chain(20, steps=20).model_copy(update={"responses": forces(20)})
    scene = scene.model_copy(update={"solver": scene.solver.model_copy(update={"memory": 8e-5})})
    method, reason = choose(Compiled(scene, ("density3",)), "transient")
    assert (method, "would take" in reason) == ("adjoint", True)


def test_a_length_that_starts_at_zero_falls_to_direct_differentiation_with_the_reason():
    """Many variables, so that the adjoint is tried first."""
    paths = hanging_skin().available_paths()
    scene = hanging_skin(responses=ZERO_LENGTH, design={f"x{k}": path for k, path in enumerate(paths)})
    assert choose(Compiled(scene, tuple(scene.design)), "transient")[0] == "adjoint"
    found = gradients_by("auto", scene, list(scene.design), "transient")
    assert found.method == "direct"
    assert found.reason.startswith("direct differentiation, because the run computed no derivatives of q")
