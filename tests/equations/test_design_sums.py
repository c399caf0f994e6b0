"""What a backward run sums up for many steps, or all variables, at once is the product with the partial derivatives by each variable."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.models.scenes import HANGING_DESIGN, hanging_skin
from toolkit.foundation.compiled.rows import filled_up
from toolkit.foundation.kernel import plain
from toolkit.solvers.transient.scheme import scheme_of
from toolkit.system.equations import (
    STEPS_SUMMED_AT_ONCE,
    Plan,
    add_up,
    allocate_terms,
    allocate_work,
    design_sums,
    evaluate_all,
    gather,
)
from toolkit.system.system import System, compile_scene, plain_formulas_of

ROUND_OFF = 1e-12
"""Some ten thousand products are summed up in another order."""
STEPS, RESPONSES = STEPS_SUMMED_AT_ONCE + 3, 3


def with_bent_shapes(system: System, rng: np.random.Generator) -> System:
    """Every variable that moves a marker changes its shape functions too, which no variable of the scene does."""
    markers = system.plan.markers
    shape = np.zeros_like(markers.design_shape)
    for m in range(len(markers.frame)):
        frame = 3 if markers.frame[m] >= 0 else 0
        for d in range(markers.design_start[m], markers.design_start[m + 1]):
            first = markers.design_shape_start[d]
            size = markers.start[m + 1] - markers.start[m]
            shape[first + frame : first + size] = rng.normal(size=(size - frame, 3))
    return replace(system, plan=system.plan._replace(markers=markers._replace(design_shape=shape)))


def contracted(plan: Plan, system: System, factors, states, multipliers, sums=None) -> np.ndarray:
    """Sum of mu^T (f_I I_x + f_A A_x) over states, (n_x, n_r); some of it goes to `sums`, if these are given."""
    levels, scheme = np.array([1.0, 30.0, 200.0]), scheme_of(system.scene.solver)
    inputs, functions = system.inputs(1e-3, levels), plain_formulas_of(system.scene)
    terms, work = allocate_terms(plan, float), allocate_work(plan, float)
    total = np.zeros((plan.n_x, RESPONSES))
    for (f_i, f_a), (q, v, acc), mu in zip(factors, states, multipliers, strict=True):
        plain(evaluate_all)(plan, functions, inputs, q, v, acc, False, True, terms, work)
        total += (f_i * terms.I_x[:, : plan.n_x] + f_a * terms.A_x[:, : plan.n_x]).T @ mu[:, :RESPONSES]
        if sums is not None:
            plain(gather)(plan, sums, scheme, levels, work.markers, f_i, f_a, q, v, acc, mu)
    if sums is not None:
        plain(add_up)(sums)
    return total


def test_sums_over_steps_are_the_products_with_the_partial_derivatives():
    rng = np.random.default_rng(5)
    system = with_bent_shapes(compile_scene(hanging_skin(), HANGING_DESIGN), rng)
    plan, backward = system.plan, system.backward
    assert len(backward.gathered.pin) > 0
    assert len(backward.plan.touched_row) < len(plan.touched_row)
    factors = rng.normal(size=(STEPS, 2))
    multipliers = np.zeros((STEPS, plan.n, filled_up(RESPONSES)))
    multipliers[:, :, :RESPONSES] = rng.normal(size=(STEPS, plan.n, RESPONSES))
    given = factors, rng.normal(size=(STEPS, 3, plan.n)), multipliers
    expected = contracted(plan, system, *given)
    sums = design_sums(backward.gathered, plan.n_x, plan.n, len(plan.markers.frame), len(plan.markers.coordinate), RESPONSES)
    found = contracted(backward.plan, system, *given, sums) + backward.gradient(sums)
    for name, own, whole in zip(system.design.names, found, expected, strict=True):
        assert np.all(whole != 0), name
        assert own == pytest.approx(whole, rel=0, abs=ROUND_OFF * np.abs(whole).max()), name
