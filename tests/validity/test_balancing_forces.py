"""Forces of joints that balance all others: by hand, and by dense least squares where nothing can balance them."""

from __future__ import annotations

import numpy as np
import pytest

from tests.benchmarks.chain import chain
from toolkit.description.point import Point
from toolkit.solvers.direct_solve import MANY
from toolkit.solvers.static.equilibrium import LEVELS
from toolkit.system.system import compile_scene
from toolkit.validity.motion.balancing_forces import balancing_forces

RODS = 100
WEIGHT = 7800.0 * 1e-4 * 9.81


def found(angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Forces in the joints of a chain, rows of x and y, and those of dense least squares."""
    points = {f"P{k}": Point(x=k * np.sin(angle), y=-k * np.cos(angle)) for k in range(RODS + 1)}
    system = compile_scene(chain(RODS).model_copy(update={"points": points}))
    assert system.n >= MANY
    (q, v, *_), rest = system.start(), np.zeros(system.n)
    terms = system.evaluate(system.inputs(0.0, LEVELS), q, v, rest)
    weights = system.weights[: system.n_q]
    ties = system.dense(terms.I_acc)[: system.n_q, system.n_q :] / weights[:, None]
    dense = np.linalg.lstsq(ties, -(terms.inertial + terms.applied)[: system.n_q] / weights)[0]
    with pytest.MonkeyPatch.context() as patch:
        patch.delattr(np.linalg, "lstsq")  # whose work grows with the third power of the rods
        sparse = balancing_forces(system, terms)
    return sparse.reshape(RODS, 2), dense.reshape(RODS, 2)


def test_every_joint_of_a_hanging_chain_carries_the_rods_below_it():
    forces, _ = found(0.0)
    below = WEIGHT * (RODS - np.arange(RODS))
    np.testing.assert_allclose(np.abs(forces[:, 1]), below, rtol=1e-9)  # the condition of 100 rods is some 1e4
    np.testing.assert_allclose(forces[:, 0], 0.0, atol=1e-9 * WEIGHT * RODS)


def test_a_chain_that_would_fall_has_the_forces_of_dense_least_squares():
    forces, dense = found(1.0)
    assert np.abs(forces - dense).max() <= 1e-9 * np.abs(dense).max()
