"""Forces of joints that balance all others: by hand, and by dense least squares where nothing can balance them."""

from __future__ import annotations

import numpy as np
import pytest

from tests.benchmarks.chain import chain
from toolkit.description.design import Point
from toolkit.solvers.direct_solve import SPARSE_FROM_UNKNOWNS
from toolkit.solvers.static.equilibrium import LEVELS
from toolkit.system.system import compile_scene
from toolkit.validity.snap_through import balancing_forces, balancing_forces_of

RODS = 100
WEIGHT = 7800.0 * 1e-4 * 9.81


def found(angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Forces in the joints of a chain, rows of x and y, and those of dense least squares."""
    points = {f"P{k}": Point(x=k * np.sin(angle), y=-k * np.cos(angle)) for k in range(RODS + 1)}
    system = compile_scene(chain(RODS).model_copy(update={"points": points}))
    assert system.n >= SPARSE_FROM_UNKNOWNS
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


@pytest.mark.parametrize("twice", [False, True])
def test_states_that_are_looked_at_together_have_the_forces_of_least_squares_each(twice):
    """Also where a joint stands there twice, so that only the sum of two forces is known, and the least ones are taken."""
    scene = chain(4)
    joints = {**scene.joints, **({"again": scene.joints["J1"]} if twice else {})}
    solver = scene.solver.model_copy(update={"redundant": "least-squares" if twice else scene.solver.redundant})
    system = compile_scene(scene.model_copy(update={"joints": joints, "solver": solver}))
    (q, v, *_), rest = system.start(), np.zeros(system.n)
    inputs, n_q, weights = system.inputs(0.0, LEVELS), system.n_q, system.weights[: system.n_q]
    terms = [system.evaluate(inputs, q + turn * np.sin(np.arange(system.n)), v, rest) for turn in (0.0, 0.3, 0.7)]
    for each, found in zip(terms, balancing_forces_of(system, terms), strict=True):
        ties = system.dense(each.I_acc)[:n_q, n_q:] / weights[:, None]
        exact = np.linalg.pinv(ties) @ (-(each.inertial + each.applied)[:n_q] / weights)
        np.testing.assert_allclose(found, exact, atol=1e-11 * np.abs(exact).max())
