"""The step of sequential quadratic programming meets the conditions of Karush, Kuhn and Tucker, also where constraints must give way."""

from __future__ import annotations

import numpy as np
import pytest

from toolkit.studies.optimization.methods.quadratic_step import SOFT, Linearised, quadratic_step

PRICE = 10.0
SHARP = 1e-6
"""Round-off of what is solved with PRICE / SOFT = 1e4 beside the numbers of a step, squared where the conditions are added up: 1e8 * 1e-16,
and a hundred for inverse curvatures of up to 10 in each factor."""


@pytest.mark.parametrize("seed", range(20))
def test_a_step_meets_the_conditions_of_an_optimum(seed):
    rng = np.random.default_rng(seed)
    n, m = rng.integers(1, 9), rng.integers(0, 4)
    root = rng.normal(size=(n, n))
    curvature = root @ root.T + 0.1 * np.eye(n)
    at = Linearised(rng.normal(size=n), rng.normal(size=m), rng.normal(size=(m, n)))
    low, high = -rng.random(n), rng.random(n)
    step = quadratic_step(curvature, at, low, high, PRICE)
    assert step is not None
    p, multipliers = step
    slope = at.g + curvature @ p - multipliers @ at.j
    inside = (p > low + SHARP) & (p < high - SHARP)
    assert np.all(np.abs(slope[inside]) < SHARP)
    assert np.all(slope[p <= low + SHARP] > -SHARP)
    assert np.all(slope[p >= high - SHARP] < SHARP)
    kept = at.c + at.j @ p
    assert np.all(multipliers > -SHARP)
    assert np.all(multipliers[kept > SHARP] < SHARP)
    violated = kept < -SHARP  # only where the multiplier is the price, and what grows with the violation
    assert multipliers[violated] == pytest.approx(PRICE - SOFT * kept[violated], rel=1e-6)


def test_constraints_give_way_only_where_they_must():
    """x >= 1 within a box of half the way: as far as it goes; and within a box that reaches it, to it."""
    at = Linearised(np.array([1.0]), np.array([-1.0]), np.array([[1.0]]))
    for reach, wanted in ((0.5, 0.5), (2.0, 1.0)):
        step = quadratic_step(np.eye(1), at, np.array([-reach]), np.array([reach]), PRICE)
        assert step is not None
        assert step.p == pytest.approx([wanted])
