"""The equations of a whole scene at one state: residual in two groups, their derivatives by state and by design.

Sums of what the design changes in the steps of a backward run, over many steps at once, or for all variables together.

With the multiplier mu of a step its gradient grows by mu^T (f_I I_x + f_A A_x). Some of that changes by the design, and not with time:

    matrices   mu^T (f_I dM a + f_A (dD v + dK q)), row by row, for STEPS_SUMMED_AT_ONCE steps at once: their states
               and multipliers are kept until then
    points     of pins, z0 and Z of `markers.planar`: mu^T (...) is linear in their derivatives, and what it multiplies them by is summed
               over all steps, whatever the number of variables that move the point

All else is summed up step by step and variable by variable.

Unknowns are [a; lam]; q and v are padded with zeros to the same length, so that one pattern and one matrix serve all:

    inertial(q, acc)            M a, joint forces, phi_q a in the constraint rows
    applied(q, v, t)            D v + K q - f_ext - f_v, and - f_c in the constraint rows
    I_acc, I_q, A_q, A_v        their derivatives, values on the common sparsity pattern
    I_x, A_x                    their partial derivatives by the design, (n, n_x)
"""

from typing import Any, NamedTuple

import numpy as np

from toolkit.components.bodies.kernels.constant_kernel import (
    Changes,
    ConstantTerms,
    add_drag,
    add_drag_design,
    constant_design,
    constant_jacobian,
    constant_residual,
    moving_design,
    moving_linearized,
    moving_residual,
)
from toolkit.components.bodies.kernels.planar_floating import Floating
from toolkit.components.bodies.kernels.spatial_floating import SpatialFloating, is_mixed, parts_of
from toolkit.components.joints.kernels.all_joints import add_joint_designs, add_joints
from toolkit.components.joints.kernels.planar_pin import pull_pin
from toolkit.components.joints.kernels.records import Joints
from toolkit.components.loads.kernels.load_kernel import (
    Loads,
    LoadWork,
    evaluate_load,
    load_design,
    load_jacobian,
    load_residual,
    load_work,
)
from toolkit.components.loads.kernels.pressure_kernel import Pressures, add_pressure_designs, add_pressures
from toolkit.components.markers.planar import Markers
from toolkit.components.markers.poses import set_frames, update_pose_designs, update_poses
from toolkit.components.markers.spatial import SpatialMarkers
from toolkit.foundation.compiled.calls import by_value
from toolkit.foundation.compiled.rows import add_rows, filled_up
from toolkit.foundation.kernel import copy, inlined, inner, kernel

STEPS_SUMMED_AT_ONCE = 16
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
    inertial: np.ndarray  # (n, STEPS_SUMMED_AT_ONCE) f_I a of the last steps
    rate: np.ndarray  # f_A v
    place: np.ndarray  # f_A q
    multipliers: np.ndarray  # (n STEPS_SUMMED_AT_ONCE, n_r filled up) mu of the last steps
    number: np.ndarray  # (n, STEPS_SUMMED_AT_ONCE) rows of `multipliers` that belong to an unknown
    total: np.ndarray  # (STEPS_SUMMED_AT_ONCE,) scratch memory
    steps: np.ndarray  # (1,) how many these are


def design_sums(plan: GatheredPlan, n_x: int, n: int, n_m: int, n_columns: int, n_r: int) -> DesignSums:
    """Empty sums for n unknowns, and n_m markers with n_columns columns."""
    return DesignSums(
        plan=plan,
        gradient=np.zeros((n_x, filled_up(n_r))),
        points=np.zeros((n_m, 2, n_r)),
        shapes=np.zeros((n_columns, 2, n_r)),
        **{name: np.zeros((n, STEPS_SUMMED_AT_ONCE)) for name in ("inertial", "rate", "place")},
        multipliers=np.zeros((n * STEPS_SUMMED_AT_ONCE, filled_up(n_r))),
        number=np.arange(n * STEPS_SUMMED_AT_ONCE).reshape(n, STEPS_SUMMED_AT_ONCE),
        total=np.zeros(STEPS_SUMMED_AT_ONCE),
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
    if sums.steps[0] == STEPS_SUMMED_AT_ONCE:
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
        for at in range(sums.steps[0], STEPS_SUMMED_AT_ONCE):
            sums.inertial[k, at], sums.rate[k, at], sums.place[k, at] = 0.0, 0.0, 0.0
    add_changes_of(sums.plan.mass, sums.inertial, sums)
    add_changes_of(sums.plan.damping, sums.rate, sums)
    add_changes_of(sums.plan.stiffness, sums.place, sums)
    sums.steps[0] = 0


@inner
def add_changes_of(changes, states, sums):
    """gradient += the changes of a matrix, times states (n, STEPS_SUMMED_AT_ONCE), times the multipliers."""
    for run in range(len(changes.row)):
        sums.total[:] = 0
        add_rows(sums.total, 1.0, 1.0, changes.value, changes.column, changes.start[run], changes.start[run + 1], states)
        row = sums.gradient[changes.variable[run]]
        add_rows(row, 1.0, 1.0, sums.total, sums.number[changes.row[run]], 0, STEPS_SUMMED_AT_ONCE, sums.multipliers)


class Plan(NamedTuple):
    """The compiled scene: flat arrays only, which never change. A spatial scene has other parts in three places."""

    n_q: int
    n: int  # coordinates and multipliers
    n_x: int
    indptr: np.ndarray  # sparsity pattern of the Jacobian, compressed rows
    indices: np.ndarray
    constant: ConstantTerms
    floating: Floating | SpatialFloating
    drag: Floating | SpatialFloating  # the same of bodies that are damped by their mass, times that damping; mostly of none
    markers: Markers | SpatialMarkers
    joints: Joints
    loads: Loads
    pressures: Pressures | None  # in space
    dropped: np.ndarray  # rows of redundant constraints, in whose place the multiplier is zero
    curve_index: np.ndarray  # (n_d,) which time curve depends on the design
    curve_variable: np.ndarray  # (n_d,) on which variable
    touched_row: np.ndarray  # entries of I_x and A_x that can differ from zero, row by row
    touched_variable: np.ndarray


class Terms(NamedTuple):
    """Residual in two groups and its derivatives by state and design, which `evaluate` fills."""

    inertial: np.ndarray  # (n,)
    applied: np.ndarray  # (n,)
    I_acc: np.ndarray  # (n_entries,)
    I_q: np.ndarray
    A_q: np.ndarray
    A_v: np.ndarray
    I_x: np.ndarray  # (n, n_x)
    A_x: np.ndarray


class ScratchMemory(NamedTuple):
    """Scratch memory of `evaluate`."""

    markers: Any  # MarkerState or SpatialMarkerState
    scratch: np.ndarray
    rest: np.ndarray  # (n,) zeros
    care: (
        np.ndarray
    )  # (2,) EXACT, unless the caller sets ROUGH or LEFT_OUT, see `constant_kernel`; 1 if A_q lacks the factored stiffness
    halves: np.ndarray  # (2, n)
    joint: Any  # of the plan's joints
    load: LoadWork
    floating: Any  # of the plan's bodies with a moving frame
    drag: Any  # of those that are damped by their mass


@by_value
class Inputs(NamedTuple):
    """Inputs at one time: values f, f', f'' of every time curve, their design derivatives, load scale, constraint levels.

    Without `inertia` bodies feel neither accelerations nor, apart from dampers, velocities. With `joints_only` all other terms are zero.
    """

    curves: np.ndarray  # (n_curves, 3)
    curves_x: np.ndarray  # (n_d, 3)
    scale: float
    levels: np.ndarray  # (k_2, k_1, k_0), see `joints.kernels.planar_joint`
    inertia: bool
    joints_only: bool


def allocate_terms(plan: Plan, dtype: type) -> Terms:
    """Memory for the terms, with two rows and columns of derivatives by the design at least, see `of_variables`."""
    vectors: list[Any] = [np.zeros(plan.n, dtype) for _ in range(2)]
    entries: Any = np.zeros((4, len(plan.indices)), dtype)  # in one piece, of which a processor keeps track in larger pages
    # one row or column lies in both orders: another type, for which everything is compiled anew
    shape = max(plan.n, 2), max(plan.n_x, 2)
    by_design: Any = [np.zeros(shape, dtype, order="F") for _ in range(2)]  # a variable touches neighbouring rows
    return Terms(*vectors, *entries, *by_design)


def of_variables(plan: Plan, terms: Terms) -> Terms:
    """Terms without the rows and columns of memory that belong to no unknown and no design variable."""
    return terms._replace(I_x=terms.I_x[: plan.n, : plan.n_x], A_x=terms.A_x[: plan.n, : plan.n_x])


def allocate_work(plan: Plan, dtype: type) -> ScratchMemory:
    """Scratch memory for `evaluate`."""
    return ScratchMemory(
        markers=plan.markers.state(dtype),
        scratch=np.zeros((3, 3), dtype),
        rest=np.zeros(plan.n, dtype),
        care=np.zeros(2, np.int64),
        halves=np.zeros((2, plan.n), dtype),
        joint=plan.joints.work(dtype),
        load=load_work(plan.loads, plan.markers.start, len(plan.markers.pose), dtype),
        floating=plan.floating.work(dtype),
        drag=plan.drag.work(dtype),
    )


@inlined
def evaluate(plan, functions, inputs, q, v, acc, linearize, terms, work):
    """Compute both groups of the residual, and if `linearize` their derivatives by the state."""
    terms.inertial[:] = 0
    terms.applied[:] = 0
    rate, acceleration = (v, acc) if inputs.inertia else (work.rest, work.rest)
    plane, frames = plan.markers.plane, plan.markers.frames
    update_poses(plane, frames, plan.markers, work.markers, q, v, acc, linearize, work.scratch)
    if not inputs.inertia:
        set_frames(frames, work.markers, q, rate, acceleration)
    parts, mixed = parts_of(frames, work.floating), is_mixed(frames, work.floating)
    if linearize and inputs.joints_only:
        for values in (terms.I_acc, terms.I_q, terms.A_q, terms.A_v):
            values[:] = 0
    if not inputs.joints_only:
        constant_residual(
            plan.constant, q, v, acceleration, inputs.scale, work.care[0], work.halves, terms.inertial, terms.applied
        )
    if linearize and not inputs.joints_only:
        constant_jacobian(plan.constant, mixed, parts, work.care[1], terms.I_acc, terms.I_q, terms.A_q, terms.A_v)
        moving_linearized(
            plane, frames, plan.floating, work.markers, q, rate, acceleration, inputs.scale, work.floating,
            terms.inertial, terms.applied, terms.I_acc, terms.I_q, terms.A_q, terms.A_v,
        )  # fmt: skip
    elif not inputs.joints_only:
        moving_residual(
            plane, frames, plan.floating, work.markers, q, rate, acceleration, inputs.scale, work.floating,
            terms.inertial, terms.applied,
        )  # fmt: skip
    if len(plan.drag.frame) > 0 and not inputs.joints_only:
        add_drag(
            plane, frames, plan.drag, work.markers, q, v, work.rest, linearize, parts, mixed, work.drag,
            terms.applied, terms.A_q, terms.A_v,
        )  # fmt: skip
        set_frames(frames, work.markers, q, rate, acceleration)
    add_joints(
        plane,
        frames,
        functions[0],
        plan.joints,
        plan.markers,
        work.markers,
        inputs,
        q,
        v,
        acc,
        linearize,
        work.joint,
        parts,
        terms,
    )
    for k in range(0 if inputs.joints_only else len(plan.loads.family)):
        evaluate_load(functions[1], plan.loads, k, plan.markers, work.markers, q, inputs.curves, inputs.scale, work.load)
        load_residual(plan.loads, k, plan.markers, work.markers, v, work.load, terms.applied)
        if linearize:
            load_jacobian(plan.loads, k, plan.markers, work.markers, work.load, parts, terms.A_q, terms.A_v)
    if not inputs.joints_only:
        add_pressures(
            plan.pressures,
            frames,
            work.markers,
            q,
            inputs.curves,
            inputs.scale,
            linearize,
            work.scratch,
            parts[2],
            terms.applied,
            terms.A_q,
        )
    drop_rows(plan, acc, linearize, parts[0], terms)


@inlined
def drop_rows(plan, acc, linearize, by_a, terms):
    """Put lam = 0 in the place of redundant constraints."""
    for row in plan.dropped:
        terms.inertial[row], terms.applied[row] = acc[row], 0
        for e in range(plan.indptr[row], plan.indptr[row + 1] if linearize else plan.indptr[row]):
            terms.I_q[e], terms.A_q[e], terms.A_v[e] = 0, 0, 0  # before the first, which they may be
            terms.I_acc[e] = by_a if plan.indices[e] == row else 0


@inlined
def evaluate_design(plan, functions, inputs, q, v, acc, terms, work):
    """Compute the partial derivatives of the residual by the design, at the state of the last evaluation."""
    for e in range(len(plan.touched_row)):
        i, x = plan.touched_row[e], plan.touched_variable[e]
        terms.I_x[i, x], terms.A_x[i, x] = 0, 0
    rate, acceleration = (v, acc) if inputs.inertia else (work.rest, work.rest)
    plane, frames = plan.markers.plane, plan.markers.frames
    if not inputs.inertia:
        set_frames(frames, work.markers, q, v, acc)
    update_pose_designs(plane, frames, plan.markers, work.markers, q, v, acc, work.scratch)
    if not inputs.inertia:
        set_frames(frames, work.markers, q, rate, acceleration)
    if not inputs.joints_only:
        constant_design(plan.constant, q, v, acceleration, inputs.scale, terms.I_x, terms.A_x)
        moving_design(
            plane, frames, plan.floating, work.markers, q, rate, acceleration, inputs.scale, work.floating, terms.I_x, terms.A_x
        )
    if len(plan.drag.frame) > 0 and not inputs.joints_only:
        add_drag_design(plane, frames, plan.drag, work.markers, q, v, work.rest, work.drag, terms.A_x)
        set_frames(frames, work.markers, q, rate, acceleration)
    add_joint_designs(
        plane, frames, functions[0], plan.joints, plan.markers, work.markers, inputs, acc, plan.curve_variable, plan.curve_index,
        work.joint, terms,
    )  # fmt: skip
    for k in range(0 if inputs.joints_only else len(plan.loads.family)):
        if not plan.loads.designed[k]:
            continue
        evaluate_load(functions[1], plan.loads, k, plan.markers, work.markers, q, inputs.curves, inputs.scale, work.load)
        load_design(
            plan.loads, k, plan.markers, work.markers, plan.curve_variable, plan.curve_index, inputs.curves_x,
            inputs.scale, work.load, terms.A_x,
        )  # fmt: skip
    if not inputs.joints_only:
        add_pressure_designs(
            plan.pressures, work.markers, q, inputs.curves, inputs.curves_x, plan.curve_variable, plan.curve_index, inputs.scale,
            work.scratch, terms.A_x,
        )  # fmt: skip
    for row in plan.dropped:
        terms.I_x[row], terms.A_x[row] = 0, 0


@kernel
def evaluate_all(plan, functions, inputs, q, v, acc, linearize, design, terms, work):
    """Compute the residual; if `linearize` its derivatives by the state; if `design` its partial derivatives by the design."""
    evaluate(plan, functions, inputs, q, v, acc, linearize, terms, work)
    if design:
        evaluate_design(plan, functions, inputs, q, v, acc, terms, work)


@kernel
def evaluate_states(evaluator, plan, functions, curves, curves_x, levels, joints_only, q, v, acc, terms, work, residuals, values):
    """Compute the residuals (k, 2, n) of k states and their derivatives by the state (k, 4, n_entries), ordered as `Terms`."""
    for k in range(len(q)):
        inputs = Inputs(curves[k], curves_x[k], 1.0, levels, True, joints_only)
        evaluator(plan, functions, inputs, q[k], v[k], acc[k], True, False, terms, work)
        copy(terms.inertial, residuals[k, 0])
        copy(terms.applied, residuals[k, 1])
        copy(terms.I_acc, values[k, 0])
        copy(terms.I_q, values[k, 1])
        copy(terms.A_q, values[k, 2])
        copy(terms.A_v, values[k, 3])
