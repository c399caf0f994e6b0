"""The matrix of a step in space, into which derivatives go at once, is the sum of them."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from tests.models.spatial_cases import CASES, write_models
from toolkit.api.comparison import inputs, random_state
from toolkit.foundation.kernel import plain
from toolkit.solvers.transient.scheme import generalized_alpha, mix, newton_matrix
from toolkit.system.equations import allocate_terms, allocate_work, evaluate_all
from toolkit.system.system import System, compile_scene


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    path = tmp_path_factory.mktemp("models")
    write_models(path)
    return path


def step_matrix(system: System, mixed: bool) -> np.ndarray:
    """A step's matrix on the pattern, into which derivatives went as Newton asks for them, or from their parts."""
    plan, scheme = system.plan, generalized_alpha("arnold-bruels", 0.8, 0.4)  # so long a step that every part counts
    matrix, terms, work = np.full(len(plan.indices), np.nan), allocate_terms(plan, float), allocate_work(plan, float)
    memory = SimpleNamespace(work=work, terms=terms, whole=terms._replace(I_acc=matrix, I_q=matrix, A_q=matrix, A_v=matrix))
    to = plain(mix)(plan.markers.frames, plan, scheme, SimpleNamespace(active=False), memory) if mixed else terms
    system.run(evaluate_all, plan, system.functions, inputs(system), *random_state(system), True, False, to, work)
    if not mixed:
        plain(newton_matrix)(plan, scheme, terms, 0, matrix, matrix)
    return matrix


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_derivatives_that_go_to_one_matrix_are_the_sum_of_their_parts(case, directory):
    system = compile_scene(case.scene(directory))
    ours, theirs = (step_matrix(system, mixed) for mixed in (True, False))
    # sums of some ten terms of one size are rounded in another order
    np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-14 * abs(theirs).max())
