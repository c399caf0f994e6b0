"""Matrices of flexible bodies as a whole and as lists of entries: two ways to the same equations, of which a body takes one."""

from __future__ import annotations

import numpy as np
import pytest

from tests.models.any_scene import test_state_derivatives_are_the_complex_step_of_the_residual as judge_state_derivatives
from tests.models.spatial_cases import CASES, write_models
from toolkit.api.comparison import design_paths, inputs, random_state
from toolkit.components.bodies.body import SpatialFloatingNumbers
from toolkit.system import pattern
from toolkit.system.system import System, compile_scene

PAIRS = [("strip", "flag"), ("ground", "arm"), ("sled", "mast")]
"""Flexible bodies whose frames move, translate, turn, and are grounded."""


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    path = tmp_path_factory.mktemp("models")
    write_models(path)
    return path


@pytest.fixture(params=PAIRS, ids=" and ".join)
def scene(request, directory):
    return next(case for case in CASES if case.bodies == request.param).scene(directory)


@pytest.fixture
def listed(monkeypatch):
    """Nothing is worked with as a whole."""
    with monkeypatch.context() as patch:
        patch.setattr(SpatialFloatingNumbers, "full", property(lambda _part: False))
        patch.setattr(pattern, "SMALLEST_SQUARE", 1 << 30)
        yield


def evaluated(system: System) -> dict[str, np.ndarray]:
    terms = system.evaluate(inputs(system), *random_state(system), design=True)
    matrices = {name: system.matrix(getattr(terms, name)).toarray() for name in ("I_acc", "I_q", "A_q", "A_v")}
    return matrices | {name: getattr(terms, name) for name in ("inertial", "applied", "I_x", "A_x")}


@pytest.fixture
def of_whole_matrices(scene):
    system = compile_scene(scene, design_paths(scene))
    assert np.all(system.plan.floating.full == 1)
    assert np.any(system.plan.constant.segment_size > 0)
    return evaluated(system)


def test_whole_matrices_and_lists_of_entries_are_the_same_equations(scene, of_whole_matrices, listed):
    system = compile_scene(scene, design_paths(scene))
    assert not system.plan.floating.full.any()
    assert not system.plan.constant.segment_size.any()
    for name, ours in evaluated(system).items():
        # sums of at most 16 coordinates times nine integrals in another order
        np.testing.assert_allclose(
            ours, of_whole_matrices[name], rtol=0, atol=1e-13 * np.abs(ours).max(initial=1e-300), err_msg=name
        )


def test_derivatives_from_lists_are_the_complex_step_of_the_residual(scene, listed):
    judge_state_derivatives(scene)


def test_bodies_with_few_entries_keep_their_lists():
    n, empty = 12, np.zeros(0, int)
    few, many = np.arange(n), np.repeat(np.arange(n), n)

    def part(row: np.ndarray) -> SpatialFloatingNumbers:
        return SpatialFloatingNumbers(1.0, np.zeros((n, 3)), row, row, np.zeros((len(row), 9)), np.zeros(3), np.zeros(()))

    assert part(many).full
    assert not part(few).full
    assert not part(empty).full
