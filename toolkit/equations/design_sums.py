"""Sums of what the design changes in the steps of a backward run, over many steps at once, or for all variables together.

With the multiplier mu of a step its gradient grows by mu^T (f_I I_x + f_A A_x). Some of that changes by the design, and not with time:

    matrices   mu^T (f_I dM a + f_A (dD v + dK q)), row by row, for TOGETHER steps at once: their states and multipliers are kept until then
    points     of pins, z0 and Z of `markers.planar`: mu^T (...) is linear in their derivatives, and what it multiplies them by is summed
               over all steps, whatever the number of variables that move the point

All else is summed up step by step and variable by variable.
"""

from typing import NamedTuple

import numpy as np

from toolkit.bodies.kernels.constant_kernel import Changes
from toolkit.foundation.compiled.rows import add_rows, filled_up
from toolkit.foundation.kernel import copy, inlined, inner
from toolkit.joints.kernels.planar_pin import pull_pin

TOGETHER = 16
"""Steps whose changes of matrices are summed up at once: two vectors of numbers."""


class GatheredPlan(NamedTuple):
    """Parts of a plan whose effect in a backward run is summed up over many steps, or for all variables together."""

    mass: Changes
    damping: Changes
    stiffness: Changes
    row: np.ndarray  # of these, each once
    column: np.ndarray
    pin: np.ndarray  # (n_p,) pins with a point that any variable moves
    side: np.ndarray  # (n_p,) whose it is, 0 or 1


class DesignSums(NamedTuple):
    """Sums of a backward run, one column for every response, and what the next sums need."""

    plan: GatheredPlan
    gradient: np.ndarray  # (n_x, n_r filled up) what matrices have added
    points: np.ndarray  # (n_m, 2, n_r) of z0
    shapes: np.ndarray  # (n_columns, 2, n_r) of the rows of Z
    inertial: np.ndarray  # (n, TOGETHER) f_I a of the last steps
    rate: np.ndarray  # f_A v
    place: np.ndarray  # f_A q
    multipliers: np.ndarray  # (n TOGETHER, n_r filled up) mu of the last steps
    number: np.ndarray  # (n, TOGETHER) rows of `multipliers` that belong to an unknown
    total: np.ndarray  # (TOGETHER,) scratch memory
    steps: np.ndarray  # (1,) how many these are


def design_sums(plan: GatheredPlan, n_x: int, n: int, n_m: int, n_columns: int, n_r: int) -> DesignSums:
    """Empty sums for n unknowns, and n_m markers with n_columns columns."""
    return DesignSums(
        plan=plan,
        gradient=np.zeros((n_x, filled_up(n_r))),
        points=np.zeros((n_m, 2, n_r)),
        shapes=np.zeros((n_columns, 2, n_r)),
        **{name: np.zeros((n, TOGETHER)) for name in ("inertial", "rate", "place")},
        multipliers=np.zeros((n * TOGETHER, filled_up(n_r))),
        number=np.arange(n * TOGETHER).reshape(n, TOGETHER),
        total=np.zeros(TOGETHER),
        steps=np.zeros(1, np.int64),
    )


@inner
def gather(plan, sums, scheme, levels, state, factor_i, factor_a, q, v, acc, block):
    """Add the share of one multiplier, a block (n, n_r filled up), at the state that has been evaluated last."""
    at, inertia = sums.steps[0], factor_i if scheme.inertia else 0.0
    for k in sums.plan.column:
        sums.inertial[k, at], sums.rate[k, at], sums.place[k, at] = inertia * acc[k], factor_a * v[k], factor_a * q[k]
    for i in sums.plan.row:
        copy(block[i], sums.multipliers[sums.number[i, at]])
    sums.steps[0] += 1
    if sums.steps[0] == TOGETHER:
        add_up(sums)
    pull_points(plan.markers.plane, plan, sums, levels, state, factor_i, factor_a, q, v, acc, block)


@inlined
def pull_points(plane, plan, sums, levels, state, factor_i, factor_a, q, v, acc, block):
    """Add the share of the points of pins to the sums."""
    if plane is not None:
        for p in range(len(sums.plan.pin)):
            pull_pin(
                plan.joints, sums.plan.pin[p], sums.plan.side[p], plan.markers, state, levels, factor_i, factor_a, q, v, acc, block,
                sums.points, sums.shapes,
            )  # fmt: skip


@inner
def add_up(sums):
    """Add the share of the matrices in the last steps to the sums."""
    for k in sums.plan.column:
        for at in range(sums.steps[0], TOGETHER):
            sums.inertial[k, at], sums.rate[k, at], sums.place[k, at] = 0.0, 0.0, 0.0
    add_changes_of(sums.plan.mass, sums.inertial, sums)
    add_changes_of(sums.plan.damping, sums.rate, sums)
    add_changes_of(sums.plan.stiffness, sums.place, sums)
    sums.steps[0] = 0


@inner
def add_changes_of(changes, states, sums):
    """gradient += the changes of a matrix, times states (n, TOGETHER), times the multipliers."""
    for run in range(len(changes.row)):
        sums.total[:] = 0
        add_rows(sums.total, 1.0, 1.0, changes.value, changes.column, changes.start[run], changes.start[run + 1], states)
        row = sums.gradient[changes.variable[run]]
        add_rows(row, 1.0, 1.0, sums.total, sums.number[changes.row[run]], 0, TOGETHER, sums.multipliers)
